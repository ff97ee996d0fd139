"""Run time against error: engines and peers on one case, timed in interleaved rounds, judged by
certified truth.
"""
