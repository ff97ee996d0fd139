"""Random parameters of the iterations and of the long motion that faults act on, all of them
dyadic.
"""

from fractions import Fraction

import numpy as np


def _part(rng: np.random.Generator, low: int, high: int) -> Fraction:
    """A random multiple of 1/64 between low and high."""
    return Fraction(int(rng.integers(low, high, endpoint=True)), 64)


def chaotic_map(rng: np.random.Generator) -> dict[str, str]:
    """The logistic map at eta = 4, where its slope is never nearly 0 for long."""
    return {"eta": "4", "x0": str(_part(rng, 5, 59)), "n": "48"}


def growth(rng: np.random.Generator) -> dict[str, str]:
    """The logistic equation on its way up."""
    return {"form": "ode", "eta": str(_part(rng, 16, 64)), "x0": str(_part(rng, 2, 16)), "n": "12"}


def stadium(rng: np.random.Generator) -> dict[str, str]:
    """A stadium with straight walls, entered along neither of its axes."""
    return {
        "start": _inside(rng),
        "direction": _slanted(rng),
        "size": f"{3 + _part(rng, 0, 64)},2",
        "n": "40",
    }


def rectangle(rng: np.random.Generator) -> dict[str, str]:
    """A rectangle without a corner on the way, as far as it goes."""
    return {
        "geometry": "rectangle",
        "start": _inside(rng),
        "direction": _slanted(rng),
        "size": "3,2",
        "n": "100",
    }


def _inside(rng: np.random.Generator) -> str:
    return f"{_part(rng, -31, 31)},{Fraction(int(rng.integers(1, 63)) * 2 + 1, 256)}"


def _slanted(rng: np.random.Generator) -> str:
    return f"{rng.choice((-1, 1)) * _part(rng, 40, 90)},{_part(rng, 30, 80)}"


def long_oscillator(rng: np.random.Generator) -> dict[str, str]:
    """A hundred shortest times and a few more, for exponents."""
    return {
        "x0": str(_part(rng, 32, 96)),
        "v0": str(_part(rng, -64, 64)),
        "duration": "112",
        "samples": "64",
    }


def head(rng: np.random.Generator) -> dict[str, str]:
    """A cat's head in the phase space of an oscillator."""
    centre = f"{_part(rng, 32, 96)},{_part(rng, -96, -32)}"
    return {
        "centre": centre,
        "size": str(_part(rng, 8, 32)),
        "points": "96",
        "samples": "12",
        "duration": "8",
    }


def wet_head(rng: np.random.Generator) -> dict[str, str]:
    """Parameters of a head-on collision in a fluid."""
    return {**head(rng), "flow": "viscous", "delta": str(_part(rng, 8, 24))}
