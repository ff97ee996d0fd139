"""Measures: what a point is and how it is judged (other parameters, another frame, another step,
more steps).
"""
