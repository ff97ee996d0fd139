"""An outline of at least 1e5 points carried by a flow, with more points where it stretches."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from refdem.core.case import EnsembleCase
from refdem.core.problem import Ensemble
from refdem.gallery.runs import Array, answer, command, instance, remember
from refdem.mechanics.oscillation import phase_area

COARSE = 4096
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
        """Of the closed polygon through the points."""
        return phase_area(self.x, self.v)


def carried(duration: float, samples: int, **parameters: Any) -> Outline:
    """The head of `phase-flow` at these parameters: a coarse run tells how its sides stretch, a
    fine one is kept.
    """
    asked = instance(
        "phase-flow", duration=repr(float(duration)), samples=samples, points=COARSE, **parameters
    )
    remember(command(asked))
    case = asked.case
    coarse = asked.problem
    assert isinstance(case, EnsembleCase)
    assert isinstance(coarse, Ensemble)
    x, v = case.outline(asked.p, answer(coarse))
    long = np.hypot(np.diff(x, axis=1, append=x[:, :1]), np.diff(v, axis=1, append=v[:, :1])).max(
        axis=0
    )
    cuts = np.clip(np.ceil(long / long.sum() * FINE).astype(int), 1, MOST)
    while cuts.sum() < FINE:
        cuts += 1
    fine = Ensemble(
        coarse.scene,
        coarse.times,
        *case.starts(asked.p, finer(np.stack((x[0], v[0]), axis=1), cuts)),
    )
    trajectory = answer(fine)
    return Outline(trajectory.t, *case.outline(asked.p, trajectory))


def finer(outline: Array, cuts: Any) -> Array:
    """The outline (M, 2) with side k cut into cuts[k] equal parts."""
    side = np.repeat(np.arange(len(outline)), cuts)
    along = (np.arange(len(side)) - np.repeat(np.cumsum(cuts) - cuts, cuts)) / cuts[side]
    after = np.roll(outline, -1, axis=0)
    found: Array = outline[side] + along[:, None] * (after[side] - outline[side])
    return found
