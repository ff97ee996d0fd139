"""Numerical stability: scenes are made harder in steps (points of a sweep), each judged as in a
run, until a method fails; the point at which it fails is a number.
"""
