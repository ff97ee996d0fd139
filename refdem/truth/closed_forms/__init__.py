"""Closed forms, one family a file: elliptic and theta functions, exact rationals, roots by interval
Newton.
"""
