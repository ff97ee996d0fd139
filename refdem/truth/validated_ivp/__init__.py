"""Validated integration of smooth y' = f(y): every step a theorem, every number a ball that contains the exact solution.

field: f written once and traced; recurrences: its Taylor coefficients; enclosure: where the solution exists on a complex disc, and the
remainder that follows; moved: the error set under the flow (Lohner); integration: the pieces; truth: a Truth made of them.
"""
