"""Chung and Ooi, test 1: two equal spheres, head-on, Hertz; the material also as limestone."""

from refdem.cases.impact_benchmarks._pair import HertzPair

MEMBER = HertzPair(
    "Two equal spheres, head-on, Hertz", {"material": "glass", "radius": "0.01", "speed": "20"}
)
