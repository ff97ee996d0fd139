"""The catalogue: one file a case, found by itself."""
