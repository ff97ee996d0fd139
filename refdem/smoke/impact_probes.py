"""Probes of rigid contact: smooth spheres that meet once, and one that bounces back from a wall.

An impact changes the part of the relative velocity along the normal n alone, from c to -e c with
the coefficient of restitution e (Goldsmith, Impact, 1960, chapter 1).
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.smoke.probes import INTERVAL, Expected, Mistake, Probe

Array = NDArray[np.float64]

RESTITUTION = 0.7
"""Coefficient of restitution e: e, e^2, sqrt(e) and 1 - e differ clearly from one another and from
0 and 1.
"""
IMPACT = 8.5 * INTERVAL
"""Time [s] of the impact, midway between two samples, so that a delay of one step changes none."""
SPEED = 1.5
"""Closing speed [m/s] along the normal."""


@dataclass(frozen=True, kw_only=True)
class Meeting:
    """Two bodies (2,) and what an adapter makes of their impact; the second may be a wall.

    `position` and `velocity` are (2, 3). `shares` (2,) are the parts of the change of the relative
    velocity that each body takes: m2/(m1 + m2) and m1/(m1 + m2), or 1 and 0 at a wall. The bodies
    touch where their distance is `reach` [m], along `wall` (3,) if that is given.

    `sign` is -1 for an impulse that draws the bodies towards each other. `whole` reverses the whole
    relative velocity in place of its part along the normal.
    """

    position: Array
    velocity: Array
    shares: Array
    reach: float
    restitution: float = RESTITUTION
    wall: Array | None = None
    sign: float = 1.0
    whole: bool = False

    def motion(self, t: Array) -> Expected:
        """Position and velocity (T, 2, 3) at times t (T,) [s] since the start."""
        branch = self.position[0] - self.position[1]
        relative = self.velocity[0] - self.velocity[1]
        time = self._touch(branch, relative)
        normal = self.wall
        if normal is None:
            normal = branch + time * relative
            normal = normal / np.linalg.norm(normal)
        reversed_part = (relative @ normal) * normal
        if self.whole:
            reversed_part = relative
        change = -self.sign * (1.0 + self.restitution) * reversed_part
        # Body 0 takes its share of the change, body 1 the opposite of its own.
        jump = np.outer(self.shares * [1.0, -1.0], change)
        since = np.maximum(t - time, 0.0)[:, None, None]
        has_met = (t > time)[:, None, None]
        return {
            "position": self.position + t[:, None, None] * self.velocity + since * jump,
            "velocity": self.velocity + has_met * jump,
        }

    def _touch(self, branch: Array, relative: Array) -> float:
        """The time [s] at which the bodies touch."""
        if self.wall is not None:
            return float((self.reach - branch @ self.wall) / (relative @ self.wall))
        # |branch + t relative|^2 = reach^2, the smaller root.
        a = float(relative @ relative)
        b = float(branch @ relative)
        c = float(branch @ branch) - self.reach**2
        return (-b - float(np.sqrt(b * b - a * c))) / a


def impact_probes() -> tuple[Probe, ...]:
    """Two spheres on a line, in a plane and in space, and a sphere and a wall."""
    along = np.array([1.0, 0.0, 0.0])
    on_a_line = _spheres("impact on a line", normal=along, slip=0 * along, drift=0.5 * along)
    in_a_plane = _spheres(
        "impact in a plane",
        normal=np.array([0.6, 0.8, 0.0]),
        slip=np.array([-0.4, 0.3, 0.0]),
        drift=np.array([0.5, -0.25, 0.0]),
    )
    in_space = _spheres(
        "impact in space",
        normal=np.array([2.0, -1.0, 2.0]) / 3.0,
        slip=np.array([0.25, 0.5, 0.0]),
        drift=np.array([0.5, -0.25, 0.75]),
    )
    return on_a_line, in_a_plane, in_space, _wall()


def _spheres(name: str, *, normal: Array, slip: Array, drift: Array) -> Probe:
    """Two unlike spheres whose centre of mass moves with `drift`, which touch at IMPACT along
    `normal`, from the second to the first, and slip by `slip` [m/s].
    """
    masses = np.array([3.0, 2.0])
    radii = np.array([0.25, 0.5])
    total = masses.sum()
    shares = masses[::-1] / total
    relative = slip - SPEED * normal
    velocity = drift + np.outer(shares * [1.0, -1.0], relative)
    branch = radii.sum() * normal - IMPACT * relative
    centre = np.array([-1.0, 0.0, 0.0])
    position = centre + np.outer(shares * [1.0, -1.0], branch)
    met = Meeting(position=position, velocity=velocity, shares=shares, reach=float(radii.sum()))
    bodies = [
        Body(
            mass=float(masses[k]),
            position=tuple(position[k].tolist()),
            velocity=tuple(velocity[k].tolist()),
            shape=Sphere(radius=float(radii[k])),
        )
        for k in range(2)
    ]
    mistakes = [
        *_common_mistakes(met),
        Mistake(
            "the masses of the two spheres are exchanged", replace(met, shares=shares[::-1]).motion
        ),
    ]
    contact = Contact(law="rigid", restitution=RESTITUTION)
    return Probe(
        name=name,
        verifies="the restitution, masses, radii and line of centres of a rigid contact",
        scene=Scene.of(bodies, [contact]),
        expected=met.motion,
        mistakes=tuple(mistakes),
    )


def _wall() -> Probe:
    """A sphere that glides along a sloping wall and meets it at IMPACT."""
    normal = np.array([-0.6, 0.8, 0.0])
    glide = np.array([0.8, 0.6, 0.0])
    point = np.array([1.0, -2.0, 0.0])
    radius = 0.5
    velocity = glide - SPEED * normal
    start = point + radius * normal - IMPACT * velocity
    met = Meeting(
        position=np.stack([start, point]),
        velocity=np.stack([velocity, 0 * velocity]),
        shares=np.array([1.0, 0.0]),
        reach=radius,
        wall=normal,
    )
    body = Body(
        mass=2.0,
        position=tuple(start.tolist()),
        velocity=tuple(velocity.tolist()),
        shape=Sphere(radius=radius),
    )
    wall = Plane(point=tuple(point.tolist()), normal=tuple(normal.tolist()))
    mistakes = [
        *_common_mistakes(met),
        Mistake(
            "the wall acts on the centre of the sphere instead of its surface",
            replace(met, reach=0.0).motion,
        ),
    ]
    return Probe(
        name="bounce from a wall",
        verifies=(
            "the restitution of a rigid contact, the radius, the position and normal of a wall"
        ),
        scene=Scene.of([body], [wall, Contact(law="rigid", restitution=RESTITUTION)]),
        expected=partial(_first_body, met),
        mistakes=tuple(
            Mistake(mistake.description, partial(_first_body_of, mistake)) for mistake in mistakes
        ),
    )


def _common_mistakes(met: Meeting) -> list[Mistake]:
    """Mistakes of an adapter that are possible in any impact."""
    as_other = {
        "1": 1.0,
        "0": 0.0,
        "e^2": RESTITUTION**2,
        "sqrt(e)": RESTITUTION**0.5,
        "1 - e": 1.0 - RESTITUTION,
        "-e": -RESTITUTION,
    }
    mistakes = [
        Mistake(f"the restitution e is read as {words}", replace(met, restitution=value).motion)
        for words, value in as_other.items()
    ]
    return [
        *mistakes,
        Mistake("no contact is detected", replace(met, sign=0.0).motion),
        Mistake("the impulse or the normal has the opposite sign", replace(met, sign=-1.0).motion),
        Mistake(
            "the whole relative velocity is reversed instead of its normal component",
            replace(met, whole=True).motion,
        ),
        Mistake("a radius is read as a diameter", replace(met, reach=met.reach / 2).motion),
    ]


def _first_body(met: Meeting, t: Array) -> Expected:
    """The columns of the first body alone, (T, 1, 3): a wall is no body."""
    return {name: values[:, :1] for name, values in met.motion(t).items()}


def _first_body_of(mistake: Mistake, t: Array) -> Expected:
    """The columns of the first body alone, as a mistake makes them."""
    return {name: values[:, :1] for name, values in mistake.expected(t).items()}
