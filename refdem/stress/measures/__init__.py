"""What a rung is and how it is judged: the same case at other parameters, in another frame, at
another step.
"""
