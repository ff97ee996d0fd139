"""The certified store: proven values in files, what they were proved with, and how they are read,
compared and kept for judging.
"""
