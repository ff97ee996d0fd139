"""The gate: a program against truth and against its own accepted past; stored runs are never
read.
"""
