"""Known faults against checks: which quantity shows which fault."""
