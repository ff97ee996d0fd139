"""Random parameters of motions under constraints: tops, chains, hooks, strings, and pendulums next
to their equilibria; all dyadic.
"""

from fractions import Fraction

import numpy as np


def _part(rng: np.random.Generator, low: float, high: float) -> Fraction:
    """A random multiple of 1/64 between low and high."""
    return Fraction(int(rng.integers(int(low * 64), int(high * 64), endpoint=True)), 64)


def _sign(rng: np.random.Generator) -> int:
    return int(rng.choice((-1, 1)))


def top(rng: np.random.Generator) -> dict[str, str]:
    """A symmetric top that nutates as it goes round."""
    found = {
        "mass": _part(rng, 0.75, 1.25),
        "length": _part(rng, 0.375, 0.5),
        "theta0": _part(rng, 0.5, 1.25),
    }
    found |= {
        "phidot0": _sign(rng) * _part(rng, 1, 2),
        "thetadot0": _sign(rng) * _part(rng, 0.5, 1),
        "spin": _sign(rng) * _part(rng, 5, 8),
    }
    more = {
        "inertia": f"{_part(rng, 0.5, 0.625)},{_part(rng, 0.25, 0.375)}",
        "duration": "3/2",
        "samples": "12",
    }
    return {name: str(value) for name, value in found.items()} | more


def above(rng: np.random.Generator) -> dict[str, str]:
    """A pendulum that leaves its upper equilibrium."""
    found = {
        "length": _part(rng, 0.75, 1.5),
        "gravity": _part(rng, 4, 8),
        "delta": _sign(rng) * _part(rng, 0.0, 0.03125) / 4,
    }
    found["delta"] += Fraction(1, 512)
    return {name: str(value) for name, value in found.items()} | {"duration": "1", "samples": "16"}


def below(rng: np.random.Generator) -> dict[str, str]:
    """A pendulum next to its lower one."""
    return above(rng) | {"position": "bottom", "duration": "4", "samples": "32"}


def chain(rng: np.random.Generator) -> dict[str, str]:
    """Two bobs on two rods, well below chaos."""
    angles = ",".join(str(_sign(rng) * _part(rng, 0.5, 0.75)) for _ in range(2))
    return {
        "theta0": angles,
        "masses": f"{_part(rng, 2, 4)},{_part(rng, 0.25, 0.5)}",
        "duration": "3/2",
        "samples": "12",
    }


def captured(rng: np.random.Generator) -> dict[str, str]:
    """A mass that flies past a hook, and half of a turn or more round it."""
    speed = _part(rng, 0.75, 1.25)
    radius = _part(rng, 0.75, 1.25)
    return {
        "mass": str(_part(rng, 0.5, 2)),
        "speed": str(speed),
        "radius": str(radius),
        "duration": str(6 * radius / speed),
        "samples": "32",
    }


def machine(rng: np.random.Generator) -> dict[str, str]:
    """Swinging Atwood's machine in its integrable case: a wheel of no size, a mass of three
    pendulums.
    """
    mass = _part(rng, 0.5, 1.5)
    found = {
        "mass": mass,
        "counter_mass": 3 * mass,
        "wheel_radius": 0,
        "wheel_inertia": 0,
        "theta0": _sign(rng) * _part(rng, 1, 1.5),
    }
    found |= {"rdot0": _part(rng, 0, 0.5), "gravity": _part(rng, 4, 8), "r0": _part(rng, 1, 1.5)}
    return {name: str(value) for name, value in found.items()} | {"duration": "1", "samples": "16"}
