"""Certified truth: balls with proven radii, in python-flint; knows nothing of solvers or mechanics."""
