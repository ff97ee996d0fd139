"""Numerical stability: scenes are made harder in steps (rungs of a ladder), each judged as in a
run, until a method fails; the rung at which it fails is a number.
"""
