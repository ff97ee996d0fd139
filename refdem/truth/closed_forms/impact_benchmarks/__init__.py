"""Truths of the impact benchmarks."""
