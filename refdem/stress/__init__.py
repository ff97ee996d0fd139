"""Numerical stability: scenes made harder rung by rung, judged as in a run, until a code breaks;
where it breaks is a number.
"""
