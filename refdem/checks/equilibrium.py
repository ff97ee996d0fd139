"""Next to an equilibrium of a pendulum: bounded at the bottom, delta cosh(w0 t) to first order from the top."""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, Outcome, Trial
from refdem.core.finding import Finding
from refdem.core.judgement import Array, worst
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

SMALL = 0.05
"""Angle [rad] up to which the first order is looked at."""


class Equilibrium(Check):
    """Of one point let go at rest on a rod within 0.05 rad of the vertical; exactly on it, it must not move at all."""

    name = "equilibrium"
    title = "Equilibria of the pendulum"
    kills = "a top that attracts or lets nothing go, a bottom that repels, a wrong rate of departure"

    def applies(self, trial: Trial) -> str | None:
        """One rod to the world, gravity, a start at rest next to the vertical."""
        scene = trial.instance.scene
        kinds = sorted(element.kind for element in scene.elements)
        if kinds != ["rod", "uniform_gravity"] or len(scene.bodies) != 1 or scene.all(Rod)[0].b >= 0:
            return "there is no pendulum"
        if np.any(scene.bodies.velocity):
            return "it does not start at rest"
        return None if abs(_angles(scene, scene.bodies.position)[0]) <= SMALL else "it does not start next to an equilibrium"

    def needs(self, trial: Trial) -> tuple[Variant, ...]:
        """The finest level."""
        return (trial.finest,)

    def judge(self, trial: Trial, runs: Mapping[Variant, Outcome]) -> list[Finding]:
        """Distance from delta cosh(w0 t) while it is small; or how far beyond delta it goes."""
        run, scene, level = runs[trial.finest].trajectory, trial.instance.scene, trial.levels[-1]
        rod = scene.all(Rod)[0]
        seen, t = _angles(scene, run.position[:, rod.a]), run.t - run.t[0]
        w0 = np.sqrt(np.linalg.norm(scene.all(UniformGravity)[0].g) / rod.length)
        delta = _angles(scene, scene.bodies.position)[0]
        allowed = trial.truncation(level) + trial.round_off(level)
        if _is_top(scene):
            first = delta * np.cosh(np.minimum(w0 * t, 700.0))
            small = np.abs(first) <= SMALL
            third = np.abs(delta) ** 3 / 6 * (np.cosh(w0 * t[small]) ** 3 / 8 + 3 * w0 * t[small] * np.sinh(w0 * t[small]) / 8)
            t, values = run.t[small], np.abs(seen - first)[small]
            bound = 1.1 * third + allowed[small] * np.cosh(w0 * t) * (1 + w0 * t)
            name, what = "departure", "The angle from the top less delta cosh(w0 t), in radians,"
            basis = "the term of third order of the series, and round-off and truncation that grow as cosh"
        else:
            t, values, bound = run.t, np.maximum(0.0, np.abs(seen) - abs(delta)), allowed * (1 + w0 * t)
            name, what, basis = (
                "bounded",
                "The angle from the bottom beyond that of the start, in radians,",
                "energy bounds it by its start",
            )
        return [worst(check=self.name, quantity=name, t=t, values=values, allowed=bound, unit="1", basis=basis, what=what)]


def _arms(scene: Scene, position: Array) -> Array:
    return position - np.array(scene.all(Rod)[0].anchor_b)


def _is_top(scene: Scene) -> bool:
    """The point starts above the pivot."""
    return bool(_arms(scene, scene.bodies.position[0]) @ np.array(scene.all(UniformGravity)[0].g) < 0)


def _angles(scene: Scene, position: Array) -> Array:
    """Angle (T,) [rad] from the vertical on the side of the start, positive to the side to which it starts."""
    gravity = np.array(scene.all(UniformGravity)[0].g)
    up = gravity / np.linalg.norm(gravity) * (-1.0 if _is_top(scene) else 1.0)
    arm, start = _arms(scene, position), _arms(scene, scene.bodies.position[0])
    across = start - (start @ up) * up
    size = float(np.linalg.norm(across))
    side = arm @ across / size if size > 0 else np.linalg.norm(arm - np.outer(arm @ up, up), axis=-1)
    angle: Array = np.arctan2(side, arm @ up)
    return angle


CHECK = Equilibrium()
