"""Next to an equilibrium of a pendulum: bounded at the bottom, delta cosh(w0 t) to first order from
the top.
"""

from collections.abc import Mapping

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import Array, worst
from refdem.core.variant import Variant
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

SMALL = 0.05
"""Angle [rad] up to which the first order is looked at."""


class Equilibrium(Check):
    """One point let go at rest on a rod within 0.05 rad of the vertical; exactly on it, it must not
    move at all.
    """

    name = "equilibrium"
    title = "Equilibria of the pendulum"
    kills = (
        "an unstable equilibrium that attracts or holds, a stable one that"
        " repels, a wrong growth rate"
    )

    def applies(self, subject: Subject) -> str | None:
        """One rod to the world, gravity, a start at rest next to the vertical."""
        scene = subject.instance.scene
        kinds = sorted(element.kind for element in scene.elements)
        if (
            kinds != ["rod", "uniform_gravity"]
            or len(scene.bodies) != 1
            or scene.all(Rod)[0].b >= 0
        ):
            return "the scene has no pendulum"
        if np.any(scene.bodies.velocity):
            return "the pendulum does not start at rest"
        if abs(_angles(scene, scene.bodies.position)[0]) <= SMALL:
            return None
        return "the pendulum does not start near an equilibrium"

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Distance from delta cosh(w0 t) while that is small; or from delta cos(w0 t), and how far
        beyond delta it goes.
        """
        run = runs[subject.finest].trajectory
        scene = subject.instance.scene
        rod = scene.all(Rod)[0]
        seen = _angles(scene, run.position[:, rod.a])
        w0 = float(np.sqrt(np.linalg.norm(scene.all(UniformGravity)[0].g) / rod.length))
        delta = float(_angles(scene, scene.bodies.position)[0])
        if _is_top(scene):
            return [self._departure(subject, run.t, seen, w0, delta)]
        return self._at_bottom(subject, run.t, seen, w0, delta)

    def _departure(
        self, subject: Subject, t: Array, seen: Array, w0: float, delta: float
    ) -> Finding:
        """The finding about a start near the top, up to SMALL: the third-order term of the series
        is what is left of the true motion.
        """
        phase = w0 * (t - t[0])
        small = np.abs(delta) * np.cosh(np.minimum(phase, 700.0)) <= SMALL
        phase = phase[small]
        first = delta * np.cosh(phase)
        third = np.abs(delta) ** 3 / 6 * (np.cosh(phase) ** 3 / 8 + 3 * phase * np.sinh(phase) / 8)
        allowed = _in_proportion(subject, delta)[small]
        return worst(
            check=self.name,
            quantity="departure",
            t=t[small],
            values=np.abs(seen[small] - first),
            allowed=1.1 * third + allowed * np.cosh(phase) * (1 + phase),
            signal=np.abs(first - delta),
            unit="1",
            basis=(
                "the third-order term of the series, plus round-off and truncation error"
                " that grow as cosh"
            ),
            what="The deviation of the angle from delta cosh(w0 t) near the top, in radians,",
        )

    def _at_bottom(
        self, subject: Subject, t: Array, seen: Array, w0: float, delta: float
    ) -> list[Finding]:
        """theta = delta cos(w t) + delta^3/192 (cos 3wt - cos wt) with w = w0 (1 - delta^2/16), to
        third order (Lindstedt).
        """
        phase = w0 * np.abs(t - t[0])
        allowed = _in_proportion(subject, delta) * (1 + phase)
        first = delta * np.cos(phase)
        third = np.abs(delta) ** 3 * (phase / 16 + 1 / 96)
        bounded = worst(
            check=self.name,
            quantity="bounded",
            t=t,
            values=np.maximum(0.0, np.abs(seen) - abs(delta)),
            allowed=allowed,
            signal=abs(delta),
            unit="1",
            basis="conservation of energy limits the angle to its initial value",
            what="The angle from the bottom in excess of its initial value, in radians,",
        )
        swing = worst(
            check=self.name,
            quantity="swing",
            t=t,
            values=np.abs(seen - first),
            allowed=1.1 * third + allowed,
            signal=np.abs(first - delta),
            unit="1",
            basis="the third-order terms of the series, plus round-off and truncation error",
            what="The deviation of the angle from delta cos(w0 t) near the bottom, in radians,",
        )
        return [bounded, swing]


def _in_proportion(subject: Subject, delta: float) -> Array:
    """Truncation and round-off (T,) [rad].

    Next to an equilibrium the equation is linear, so the error of fixed steps is in proportion to
    delta; a tolerance is absolute.
    """
    level = subject.levels[-1]
    if subject.method.control == "step":
        size = abs(delta)
    else:
        size = 1.0
    found: Array = subject.truncation(level) * size + subject.round_off(level)
    return found


def _arms(scene: Scene, position: Array) -> Array:
    arms: Array = position - np.array(scene.all(Rod)[0].anchor_b)
    return arms


def _is_top(scene: Scene) -> bool:
    """True if the point starts above the pivot."""
    return bool(
        _arms(scene, scene.bodies.position[0]) @ np.array(scene.all(UniformGravity)[0].g) < 0
    )


def _angles(scene: Scene, position: Array) -> Array:
    """Angle (T,) [rad] from the vertical on the side of the start, positive to the side to which it
    starts.
    """
    gravity = np.array(scene.all(UniformGravity)[0].g)
    up = gravity / np.linalg.norm(gravity)
    if _is_top(scene):
        up = -up
    arm = _arms(scene, position)
    start = _arms(scene, scene.bodies.position[0])
    across = start - (start @ up) * up
    size = float(np.linalg.norm(across))
    if size > 0:
        side = arm @ across / size
    else:
        side = np.linalg.norm(arm - np.outer(arm @ up, up), axis=-1)
    angle: Array = np.arctan2(side, arm @ up)
    return angle


CHECK = Equilibrium()
