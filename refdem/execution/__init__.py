"""Runs made in processes of this machine, or in the workers of a cluster."""
