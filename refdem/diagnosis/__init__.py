"""Model-based diagnosis: which mistake in a program explains how its run deviates."""
