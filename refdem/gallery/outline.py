"""An outline of at least 1e5 points carried by a flow, with more points where it stretches."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from refdem.core.case import EnsembleCase
from refdem.core.problem import Ensemble
from refdem.gallery.runs import Array, answer, command, instance, remember
from refdem.mechanics.oscillation import phase_area

COARSE = 4096
"""Points of the outline: a thousandth of its length apart, which no eye sees in the picture."""
FINE = 100_000
"""Points that find out where the outline stretches, and points that it then has at least."""
MOST = 64
"""Points that a side of the coarse outline is cut into at most."""


@dataclass(frozen=True, eq=False)
class Outline:
    """Place x and rate v (T, M) of the points at the times t (T,); their areas (T,)."""

    t: Array
    x: Array
    v: Array

    @property
    def area(self) -> Array:
        """The areas (T,) of the closed polygons through the points."""
        return phase_area(self.x, self.v)


def carried(duration: float, samples: int, **parameters: Any) -> Outline:
    """The head of `phase-flow` at these parameters: a coarse run tells how its sides stretch, a
    fine one is kept.
    """
    case_instance = instance(
        "phase-flow", duration=repr(float(duration)), samples=samples, points=COARSE, **parameters
    )
    remember(command(case_instance))
    case = case_instance.case
    coarse = case_instance.problem
    assert isinstance(case, EnsembleCase)
    assert isinstance(coarse, Ensemble)
    x, v = case.outline(case_instance.p, answer(coarse))
    # Length (M,) of each side of the closed outline at the time when it is longest.
    across = np.diff(x, axis=1, append=x[:, :1])
    up = np.diff(v, axis=1, append=v[:, :1])
    longest = np.hypot(across, up).max(axis=0)
    # A side gets its part of the points, at least one.
    share = np.ceil(longest / longest.sum() * FINE).astype(int)
    cuts = np.clip(share, 1, MOST)
    while cuts.sum() < FINE:
        cuts += 1
    begin = finer(np.stack((x[0], v[0]), axis=1), cuts)
    fine = Ensemble(coarse.scene, coarse.times, *case.starts(case_instance.p, begin))
    trajectory = answer(fine)
    return Outline(trajectory.t, *case.outline(case_instance.p, trajectory))


def finer(outline: Array, cuts: Any) -> Array:
    """The outline (M, 2) with side k cut into cuts[k] equal parts."""
    # The side on which each new point lies, and how far along it, from 0 to 1.
    side = np.repeat(np.arange(len(outline)), cuts)
    first_of_side = np.cumsum(cuts) - cuts
    number_on_side = np.arange(len(side)) - np.repeat(first_of_side, cuts)
    along = number_on_side / cuts[side]
    begin = outline[side]
    end = np.roll(outline, -1, axis=0)[side]
    points: Array = begin + along[:, None] * (end - begin)
    return points
