"""A pendulum that starts next to an equilibrium: theta stays below delta at the bottom and grows as
delta cosh(w0 t) at the top, to first order.

delta is the initial angle from the vertical, w0^2 = g/l.
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
"""Largest angle [rad] at which the series in delta is used."""


class Equilibrium(Check):
    """One point on a rod, released at rest within 0.05 rad of the vertical; exactly on it, it must
    not move at all.
    """

    name = "equilibrium"
    title = "Equilibria of the pendulum"
    kills = (
        "an unstable equilibrium that attracts or holds, a stable one that"
        " repels, a wrong growth rate"
    )

    def applies(self, subject: Subject) -> str | None:
        """One rod to the world, gravity, and a start at rest next to the vertical."""
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
        """At the top: theta against delta cosh(w0 t) while that is small. At the bottom: theta
        against delta cos(w0 t), and |theta| against delta.
        """
        run = runs[subject.finest].trajectory
        scene = subject.instance.scene
        rod = scene.all(Rod)[0]
        theta = _angles(scene, run.position[:, rod.a])
        # w0 = sqrt(|g|/l).
        w0 = float(np.sqrt(np.linalg.norm(scene.all(UniformGravity)[0].g) / rod.length))
        delta = float(_angles(scene, scene.bodies.position)[0])
        if _is_top(scene):
            return [self._departure(subject, run.t, theta, w0, delta)]
        return self._at_bottom(subject, run.t, theta, w0, delta)

    def _departure(
        self, subject: Subject, t: Array, theta: Array, w0: float, delta: float
    ) -> Finding:
        """The finding on theta(t) from near the top, as long as delta cosh(w0 t) <= SMALL.

        theta'' = w0^2 sin(theta) = w0^2 (theta - theta^3/6 + ...) has the solution delta cosh(s) -
        delta^3 c3(s) + ... with s = w0 t. The third-order term satisfies c3'' - c3 = cosh^3(s)/6
        with c3(0) = c3'(0) = 0, so that

          c3 = (cosh(3 s) - cosh(s))/192 + s sinh(s)/16 <= (cosh^3(s)/8 + 3 s sinh(s)/8)/6.

        Higher terms are covered by the factor 1.1.
        """
        phase = w0 * (t - t[0])
        # cosh overflows beyond 710.
        is_small = np.abs(delta) * np.cosh(np.minimum(phase, 700.0)) <= SMALL
        phase = phase[is_small]
        first = delta * np.cosh(phase)
        # |delta|^3 (cosh^3(s)/8 + 3 s sinh(s)/8)/6.
        third = np.abs(delta) ** 3 / 6 * (np.cosh(phase) ** 3 / 8 + 3 * phase * np.sinh(phase) / 8)
        allowed = _angle_error(subject, delta)[is_small]
        return worst(
            check=self.name,
            quantity="departure",
            t=t[is_small],
            values=np.abs(theta[is_small] - first),
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
        self, subject: Subject, t: Array, theta: Array, w0: float, delta: float
    ) -> list[Finding]:
        """Two findings on theta(t) near the bottom: it never exceeds delta, and follows delta
        cos(w0 t).

        Lindstedt's series to third order, with w = w0 (1 - delta^2/16), is

          theta = delta cos(w t) - delta^3/192 (cos 3wt - cos wt),

        so theta differs from delta cos(w0 t) by at most |delta|^3 (w0 t/16 + 1/96). Conservation of
        energy bounds |theta| by |delta|.
        """
        phase = w0 * np.abs(t - t[0])
        allowed = _angle_error(subject, delta) * (1 + phase)
        first = delta * np.cos(phase)
        # |delta|^3 (w0 t/16 + 1/96).
        third = np.abs(delta) ** 3 * (phase / 16 + 1 / 96)
        bounded = worst(
            check=self.name,
            quantity="bounded",
            t=t,
            values=np.maximum(0.0, np.abs(theta) - abs(delta)),
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
            values=np.abs(theta - first),
            allowed=1.1 * third + allowed,
            signal=np.abs(first - delta),
            unit="1",
            basis="the third-order terms of the series, plus round-off and truncation error",
            what="The deviation of the angle from delta cos(w0 t) near the bottom, in radians,",
        )
        return [bounded, swing]


def _angle_error(subject: Subject, delta: float) -> Array:
    """Truncation and round-off (T,) [rad].

    Next to an equilibrium the equation is linear, so the truncation error of fixed steps is
    proportional to delta; a tolerance is absolute.
    """
    level = subject.levels[-1]
    if subject.method.control == "step":
        amplitude = abs(delta)
    else:
        amplitude = 1.0
    # truncation(h) |delta| + u_n; for a tolerance, truncation + u_n.
    error: Array = subject.truncation(level) * amplitude + subject.round_off(level)
    return error


def _arms(scene: Scene, position: Array) -> Array:
    """Vectors [m] from the pivot to positions."""
    arms: Array = position - np.array(scene.all(Rod)[0].anchor_b)
    return arms


def _is_top(scene: Scene) -> bool:
    """True if the point starts above the pivot."""
    return bool(
        _arms(scene, scene.bodies.position[0]) @ np.array(scene.all(UniformGravity)[0].g) < 0
    )


def _angles(scene: Scene, position: Array) -> Array:
    """Angle (T,) [rad] from the vertical through the equilibrium next to the start, positive to the
    side of the start.
    """
    gravity = np.array(scene.all(UniformGravity)[0].g)
    # The direction from the pivot to the equilibrium.
    vertical = gravity / np.linalg.norm(gravity)
    if _is_top(scene):
        vertical = -vertical
    # theta = atan2(component of the arm across the vertical, component along it).
    arm = _arms(scene, position)
    start = _arms(scene, scene.bodies.position[0])
    across = start - (start @ vertical) * vertical
    across_length = float(np.linalg.norm(across))
    # Signed towards the side of the start; exactly at the equilibrium the distance from the
    # vertical.
    if across_length > 0:
        horizontal = arm @ across / across_length
    else:
        horizontal = np.linalg.norm(arm - np.outer(arm @ vertical, vertical), axis=-1)
    angle: Array = np.arctan2(horizontal, arm @ vertical)
    return angle


CHECK = Equilibrium()
