"""Validated integration of smooth y' = f(y), f a traced field: discs and remainders, sets (Lohner),
and the pieces they make.
"""
