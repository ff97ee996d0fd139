"""Witnesses: for the cases of the catalogue, values by another way than the truth's own, sharing no
code with it.

A file is a family; WITNESSES maps case ids to a Witness (cross_check.py). Nothing here is proved:
what counts is that two ways agree.
"""
