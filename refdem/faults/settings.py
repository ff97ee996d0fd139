"""Settings for faults to act on: cases with random parameters, drawn by a seed inside sensible
bounds, all of them dyadic.

Each is a short motion (about eight shortest times), so that faults x settings x seeds fit into
minutes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from refdem.faults import held_draws, map_draws, positional

Draw = Callable[[np.random.Generator], dict[str, str]]


@dataclass(frozen=True)
class Setting:
    """A case with random parameters.

    `methods` are those of the transparent engine that run it; truth is withheld unless `proved`.
    """

    case: str
    draw: Draw
    methods: tuple[str, ...]
    proved: bool = True

    def parameters(self, name: str, seed: int) -> dict[str, str]:
        """The parameters of a seed, as text."""
        return self.draw(np.random.default_rng([seed, *name.encode()]))


def _between(rng: np.random.Generator, low: float, high: float, unit: int = 32) -> Fraction:
    """A random multiple of 1/unit in [low, high]."""
    return Fraction(int(rng.integers(int(low * unit), int(high * unit), endpoint=True)), unit)


def _list(values: object) -> str:
    return ",".join(str(value) for value in values)  # type: ignore[attr-defined]


def _sign(rng: np.random.Generator) -> int:
    return int(rng.choice((-1, 1)))


def _inertia(rng: np.random.Generator) -> list[Fraction]:
    """Moments of a box with well separated sides, in any order."""
    sides = [1 + _between(rng, 0, 0.25), 2 + _between(rng, 0, 0.25), 3 + _between(rng, 0, 0.25)]
    moments = [sum(other * other for other in sides) - side * side for side in sides]
    return [Fraction(round(float(moments[i]) * 8), 64) for i in rng.permutation(3)]


def _tumbler(rng: np.random.Generator) -> dict[str, str]:
    """A free body with three moments of inertia, spinning about no axis in particular, attitude
    anything.
    """
    omega = [_sign(rng) * _between(rng, 0.5, 1.25) for _ in range(3)]
    attitude = [int(rng.integers(1, 5)), *(_sign(rng) * int(rng.integers(1, 5)) for _ in range(3))]
    return {
        "inertia": _list(_inertia(rng)),
        "omega_body": _list(omega),
        "attitude": _list(attitude),
        "duration": "6",
        "samples": "32",
    }


def _flipper(rng: np.random.Generator) -> dict[str, str]:
    """A body that turns over once about its intermediate axis."""
    return {
        "offset": str(_between(rng, 1 / 16, 1 / 8, 128)),
        "direction": str(rng.choice(("1", "3"))),
        "duration": "24",
        "samples": "48",
    }


def _swing(rng: np.random.Generator) -> dict[str, str]:
    """Parameters of a pendulum that swings."""
    found = {
        "mass": _between(rng, 0.5, 3),
        "length": _between(rng, 0.5, 2),
        "gravity": _between(rng, 4, 12),
    }
    found |= {
        "theta0": _sign(rng) * _between(rng, 0.75, 1.75),
        "thetadot0": _between(rng, -0.5, 0.5),
    }
    return {name: str(value) for name, value in found.items()} | {"duration": "3", "samples": "32"}


def _circler(rng: np.random.Generator) -> dict[str, str]:
    """A pendulum that goes round."""
    found = {
        "mass": _between(rng, 0.5, 3),
        "length": _between(rng, 1, 2),
        "gravity": _between(rng, 1, 2),
    }
    found |= {"theta0": _between(rng, -1, 1), "thetadot0": _sign(rng) * _between(rng, 4, 5)}
    return {name: str(value) for name, value in found.items()} | {"duration": "2", "samples": "32"}


def _oscillator(rng: np.random.Generator) -> dict[str, str]:
    """Parameters of a mass on a spring."""
    found = {
        "mass": _between(rng, 0.5, 2),
        "stiffness": _between(rng, 0.5, 2),
        "x0": _sign(rng) * _between(rng, 0.5, 2),
    }
    return {name: str(value) for name, value in found.items()} | {
        "v0": str(_between(rng, -1, 1)),
        "duration": "8",
        "samples": "32",
    }


def _hanging(rng: np.random.Generator) -> dict[str, str]:
    """Parameters of a mass on a spring in gravity."""
    return _oscillator(rng) | {"gravity": str(_sign(rng) * _between(rng, 0.5, 1.5))}


def _viscous(rng: np.random.Generator) -> dict[str, str]:
    """The same in a fluid, below critical damping."""
    return _oscillator(rng) | {"delta": str(_between(rng, 0.125, 0.375))}


def _driven(rng: np.random.Generator) -> dict[str, str]:
    """A periodic force on a heavy mass, without damping, away from resonance."""
    found = {
        "mass": _between(rng, 1.5, 2),
        "stiffness": _between(rng, 1, 2),
        "f0": _between(rng, 0.75, 1.5),
        "delta": 0,
    }
    return {
        name: str(value) for name, value in (found | {"drive": _between(rng, 1.5, 2)}).items()
    } | {"duration": "8", "samples": "32"}


def _hardening(rng: np.random.Generator) -> dict[str, str]:
    """Parameters of a spring with a cubic term."""
    found = {
        "alpha": _between(rng, 0.75, 1.5),
        "beta": _between(rng, 0.25, 0.5),
        "amplitude": _sign(rng) * _between(rng, 0.5, 1),
    }
    return {name: str(value) for name, value in found.items()} | {"duration": "6", "samples": "32"}


def _lopsided(rng: np.random.Generator) -> dict[str, str]:
    """A spring with a square, let go, neither damped nor driven."""
    found = {
        "eps": _sign(rng) * _between(rng, 0.125, 0.25),
        "x0": _sign(rng) * _between(rng, 0.5, 1),
        "delta": 0,
        "f0": "0,0",
    }
    return {name: str(value) for name, value in found.items()} | {"duration": "6", "samples": "32"}


def _lopsided_down(rng: np.random.Generator) -> dict[str, str]:
    """The same, with a square of negative factor."""
    return _lopsided(rng) | {"eps": str(-_between(rng, 0.125, 0.25))}


def _far(rng: np.random.Generator) -> dict[str, str]:
    """A mass that swings about a place that is 1000 times as far from the origin as it moves."""
    found = _oscillator(rng) | {"mass": "1", "stiffness": "1", "gravity": "1024"}
    return found | {"x0": str(1024 + _sign(rng) * _between(rng, 0.5, 1))}


def _slider_along_wall(rng: np.random.Generator) -> dict[str, str]:
    """A sphere that slides along a wall from its touch to its end, with neither spring nor rest."""
    return {
        "member": "co-4",
        "tangential_stiffness": "0",
        "friction": str(_between(rng, 0.0625, 0.125, 128)),
        "angle": str(_sign(rng) * _between(rng, 0.875, 1.125)),
        "samples": "16",
    }


def _steep(rng: np.random.Generator) -> dict[str, str]:
    """A spring that pulls with the power 3/2 of its stretch."""
    found = {
        "mass": _between(rng, 0.5, 2),
        "stiffness": _between(rng, 0.5, 2),
        "amplitude": _sign(rng) * _between(rng, 0.5, 2),
    }
    return {name: str(value) for name, value in found.items()} | {"duration": "6", "samples": "32"}


def _cycle(rng: np.random.Generator) -> dict[str, str]:
    """Van der Pol's oscillator on the way to its cycle."""
    found = {
        "mu": _between(rng, 0.25, 0.5),
        "p": _between(rng, 0.25, 0.5),
        "x0": _between(rng, 1, 1.5),
    }
    return {name: str(value) for name, value in found.items()} | {"duration": "6", "samples": "24"}


def _rubbing(rng: np.random.Generator) -> dict[str, str]:
    """A mass on a spring that friction stops after two to four half cycles, well away from the edge
    between two numbers of them.
    """
    stiffness = _between(rng, 0.75, 2)
    x0 = _between(rng, 0.75, 1.5)
    share = Fraction(1, 2 * int(rng.integers(2, 5))) + Fraction(1, 128)
    found = {
        "mass": _between(rng, 0.75, 1.5),
        "stiffness": stiffness,
        "x0": _sign(rng) * x0,
        "friction_force": stiffness * x0 * share,
    }
    return {name: str(value) for name, value in found.items()} | {"duration": "20", "samples": "64"}


def _sticking(rng: np.random.Generator) -> dict[str, str]:
    """A driven mass that a belt catches, carries and lets go again."""
    found = {
        "eta": _between(rng, 1, 1.5),
        "gamma": _between(rng, 0.375, 0.75),
        "x0": _between(rng, 0.75, 1.25),
    }
    found |= {
        "mu0": _between(rng, 0.375, 0.4375),
        "mu1": Fraction(1, 8),
        "lambda0": _between(rng, 1.25, 1.5),
        "lambda1": Fraction(1, 64),
    }
    return {name: str(value) for name, value in found.items()} | {"duration": "8", "samples": "32"}


def _orbit(rng: np.random.Generator) -> dict[str, str]:
    """About one revolution about a centre of attraction."""
    return {
        "gm": str(_between(rng, 0.75, 1.5)),
        "eccentricity": str(_between(rng, 0.0625, 0.375)),
        "duration": "6",
        "samples": "32",
    }


def _ellipse(rng: np.random.Generator) -> dict[str, str]:
    """About one revolution on a spring."""
    return _orbit(rng) | {"stiffness": str(_between(rng, 0.75, 1.5))}


def _spheres(rng: np.random.Generator) -> dict[str, Fraction]:
    """Parameters of two unequal spheres."""
    return {"stiffness": _between(rng, 96, 192, 1), "closing_speed": _between(rng, 0.75, 1.25)}


def _pair(rng: np.random.Generator, low: float, high: float) -> str:
    """A number and a larger one, in any order."""
    small = _between(rng, low, high)
    both = [small, small * _between(rng, 1.5, 2.5, 4)]
    return _list(both[::-1] if rng.integers(2) else both)


def _collision(rng: np.random.Generator, **more: object) -> dict[str, str]:
    found = {
        **_spheres(rng),
        **more,
        "masses": _pair(rng, 0.75, 1.25),
        "radii": _pair(rng, 0.375, 0.625),
        "samples": 16,
    }
    return {name: str(value) for name, value in found.items()}


def _knock(rng: np.random.Generator) -> dict[str, str]:
    """Head-on, damped; the contact ends with the overlap."""
    return _collision(rng, damping=_between(rng, 2, 4))


def _parting(rng: np.random.Generator) -> dict[str, str]:
    """Head-on, damped; the contact ends when it would pull."""
    return _collision(rng, damping=_between(rng, 2, 4), cutoff="zero_force")


def _bounce(rng: np.random.Generator) -> dict[str, str]:
    """Parameters of a head-on elastic collision."""
    return _collision(rng, damping=0)


def _spins(rng: np.random.Generator) -> str:
    return f"0,0,{_between(rng, -0.125, 0.125)},0,0,{_between(rng, -0.125, 0.125)}"


def _scrape(rng: np.random.Generator) -> dict[str, str]:
    """Oblique with gross sliding; the lever arms add up to the distance."""
    side = _sign(rng)
    return _collision(
        rng,
        damping=_between(rng, 0.5, 1),
        friction=_between(rng, 0.0625, 0.09375),
        angle=side * _between(rng, 0.95, 1.1),
        spins=_spins(rng),
    )


def _scrape_long(rng: np.random.Generator) -> dict[str, str]:
    """Gross sliding of soft spheres with the radius as lever arm."""
    return _soft(rng) | {"branch": "R", "tangential_stiffness": "0"}


def _scrape_short(rng: np.random.Generator) -> dict[str, str]:
    """The same with the radius less the overlap as lever arm."""
    return _scrape(rng) | {"branch": "R-d"}


def _bristle(rng: np.random.Generator) -> dict[str, str]:
    """Gross sliding with a tangential spring that is at its limit from the start."""
    return _scrape(rng) | {"damping": "0", "tangential_stiffness": str(_between(rng, 80, 128, 1))}


def _spinner(rng: np.random.Generator) -> dict[str, str]:
    """Head-on; sphere 2 spins so fast that it slides all the time, sphere 1 slowly the other
    way.
    """
    side = _sign(rng)
    spins = f"0,0,{-side * _between(rng, 0.25, 0.5)},0,0,{side * _between(rng, 4, 6)}"
    return _collision(rng, damping=0, friction=_between(rng, 0.0625, 0.125), spins=spins)


def _soft(rng: np.random.Generator) -> dict[str, str]:
    """Gross sliding of soft spheres: the normal turns far while the tangential spring remembers."""
    stiffness = _between(rng, 2, 4)
    more = {
        "stiffness": stiffness,
        "tangential_stiffness": stiffness / 4,
        "closing_speed": _between(rng, 0.75, 0.875),
    }
    return _collision(
        rng,
        damping=0,
        friction=_between(rng, 0.125, 0.1875),
        angle=_sign(rng) * _between(rng, 1.15, 1.2),
        **more,
    )


def _sticker(rng: np.random.Generator) -> dict[str, str]:
    """Oblique; the tangential spring holds, then slides."""
    return _scrape(rng) | {
        "tangential_stiffness": str(_between(rng, 80, 128, 1)),
        "friction": "1",
        "angle": "1/4",
        "damping": "0",
    }


def _tumbling_spheres(rng: np.random.Generator) -> dict[str, str]:
    """The same with spins about all axes, so that the spring leaves the plane."""
    return _sticker(rng) | {
        "spins": _list(_sign(rng) * _between(rng, 1, 2) for _ in range(6)),
        "damping": "1/2",
    }


def _flyer(rng: np.random.Generator) -> dict[str, str]:
    """A free body that flies straight and spins steadily."""
    velocity = _list(_sign(rng) * _between(rng, 0.25, 1) for _ in range(3))
    return {
        "velocity": velocity,
        "spin": str(_between(rng, 0.75, 1.5)),
        "duration": "8",
        "samples": "32",
    }


def _resting(rng: np.random.Generator) -> dict[str, str]:
    """Two spheres in elastic balance."""
    return {"member": "spheres", "duration": str(_between(rng, 0.25, 0.5)), "samples": "16"}


SMOOTH = ("euler", "verlet", "suzuki", "rk4", "verlet-single")
TOUCHING = ("verlet", "verlet-single")
HELD = ("verlet", "suzuki", "verlet-single")
DAMPED = ("euler", "verlet", "rk4", "verlet-single")
ITERATED = ("iterated",)
SETTINGS: Mapping[str, Setting] = {
    "tumbler": Setting("free-rigid-body", _tumbler, SMOOTH),
    "flipper": Setting("intermediate-axis", _flipper, SMOOTH),
    "swing": Setting("pendulum", _swing, ("euler", "verlet", "suzuki", "verlet-single")),
    "circler": Setting("pendulum", _circler, ("euler", "verlet", "suzuki", "verlet-single")),
    "oscillator": Setting("harmonic-oscillator", _oscillator, SMOOTH),
    "hanging": Setting("harmonic-oscillator", _hanging, SMOOTH),
    "viscous": Setting("viscous-oscillator", _viscous, DAMPED),
    "driven": Setting("driven-oscillator", _driven, SMOOTH),
    "hardening": Setting("duffing", _hardening, SMOOTH),
    "lopsided": Setting("quadratic-response", _lopsided, SMOOTH),
    "lopsided-down": Setting("quadratic-response", _lopsided_down, SMOOTH),
    "far": Setting("harmonic-oscillator", _far, SMOOTH),
    "along-wall": Setting("impact-benchmarks", _slider_along_wall, TOUCHING),
    "steep": Setting("power-oscillator", _steep, ("euler", "verlet", "verlet-single")),
    "cycle": Setting("van-der-pol", _cycle, DAMPED),
    "rubbing": Setting("coulomb-oscillator", _rubbing, TOUCHING),
    "sticking": Setting("stick-slip", _sticking, TOUCHING),
    "orbit": Setting("two-body-orbit", _orbit, SMOOTH),
    "ellipse": Setting("two-body-orbit", _ellipse, SMOOTH),
    "knock": Setting("two-spheres", _knock, TOUCHING),
    "parting": Setting("two-spheres", _parting, TOUCHING),
    "bounce": Setting("two-spheres", _bounce, TOUCHING),
    "scrape": Setting("two-spheres", _scrape, TOUCHING),
    "scrape-long": Setting("two-spheres", _scrape_long, TOUCHING),
    "scrape-short": Setting("two-spheres", _scrape_short, TOUCHING),
    "bristle": Setting("two-spheres", _bristle, TOUCHING),
    "spinner": Setting("two-spheres", _spinner, TOUCHING),
    "soft": Setting("two-spheres", _soft, TOUCHING),
    "sticker": Setting("two-spheres", _sticker, TOUCHING),
    "gripper": Setting(
        "two-spheres", lambda rng: _sticker(rng) | {"spins": "0,0,1,0,0,3/4"}, TOUCHING
    ),  # spins add to the slip
    "tumbling-spheres": Setting("two-spheres", _tumbling_spheres, TOUCHING, proved=False),
    "unproved": Setting("van-der-pol", _cycle, DAMPED, proved=False),
    "hertz": Setting("hertz-spheres", positional.hertz, TOUCHING),
    "tent": Setting(
        "asymmetric-field", positional.tent, ("verlet",)
    ),  # in single precision one pair of levels is left above round-off
    "wedge": Setting("wedge-collision", positional.wedge, TOUCHING),
    "flyer": Setting("newtons-first-law", _flyer, SMOOTH),
    "resting": Setting("newtons-first-law", _resting, TOUCHING),
    "top": Setting("heavy-top", held_draws.top, HELD),
    "above": Setting("pendulum-equilibria", held_draws.above, HELD),
    "below": Setting("pendulum-equilibria", held_draws.below, HELD),
    "chain": Setting("double-pendulum", held_draws.chain, HELD),
    "captured": Setting("captured-mass", held_draws.captured, TOUCHING),
    "machine": Setting("pendulum-wheel-mass", held_draws.machine, HELD),
    "chaotic-map": Setting("logistic", map_draws.chaotic_map, ITERATED),
    "growth": Setting("logistic", map_draws.growth, ITERATED),
    "stadium": Setting("billiards", map_draws.stadium, ITERATED),
    "rectangle": Setting("billiards", map_draws.rectangle, ITERATED),
    "head": Setting("phase-flow", map_draws.head, ("carried",)),
    "wet-head": Setting("phase-flow", map_draws.wet_head, ("carried",)),
    "long-oscillator": Setting("harmonic-oscillator", map_draws.long_oscillator, ("verlet",)),
}
