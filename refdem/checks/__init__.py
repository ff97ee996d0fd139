"""What is verified: one file a check, found by itself."""
