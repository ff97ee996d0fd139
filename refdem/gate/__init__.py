"""The gate: a program against truth and against the baseline that its authors accepted; stored runs
are never read.
"""
