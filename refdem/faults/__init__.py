"""Known faults, and the transparent engine into which they are planted to test the checks."""
