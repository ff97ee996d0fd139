"""Mechanics as pure functions of arrays.

SI units, quaternions (w, x, y, z) that rotate body vectors into space.
"""
