"""Measures: what a rung is and how it is judged (other parameters, another frame, another step,
more steps).
"""
