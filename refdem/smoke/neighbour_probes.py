"""Probes of neighbour lists: spheres that start apart and collide later, that touch several others
or walls at once, that are far apart in a long list, or that collide across a periodic boundary.

Programs rebuild their neighbour lists as spheres move. All contacts are undamped and head-on, so
that each has a closed form.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.smoke.probes import Expected, Probe

Array = NDArray[np.float64]

STIFFNESS = 800.0
"""Stiffness [N/m] of contacts, which last one or two tenths of a second."""
AROUND = 5
"""Number of spheres around a central one, with gaps between them."""
BETWEEN = 80
"""Number of bodies listed between two that meet: more than the 64 bits of a word."""
PERIOD = 8.0
"""Period [m] of the box in which pairs meet across its boundary."""
SMALL_PERIOD = 2.5
"""Period [m] of a box of less than three large diameters, in which a pair may be found twice."""
ACROSS = (2.0, -3.0, 6.0)
"""Direction along which spheres meet across all three axes of the boundary; for a face or an edge
its other components are 0.
"""
_CORNER = np.ones((1, 3))
"""The axes across which each pair meets (one row per pair): all three, at a corner."""
_EVERY_CROSSING = np.array([axes for axes in np.ndindex(2, 2, 2) if any(axes)], float)
"""Three faces, three edges and the corner."""


def neighbour_probes() -> tuple[Probe, ...]:
    """The probes of neighbour lists: late, many and periodic contacts."""
    return (
        _meeting("meeting later", between=0),
        _meeting("meeting one at rest", between=0, is_second_at_rest=True),
        _surrounded(),
        _meeting("many", between=BETWEEN),
        _across_boundary("across a periodic boundary", _EVERY_CROSSING, PERIOD),
        _across_boundary("in a small periodic box", _CORNER, SMALL_PERIOD),
        _in_corner(),
    )


def _bounce(t: Array, rate: float, speed: float, start: float) -> tuple[Array, Array]:
    """Closing velocity (T,) [m/s] and the distance closed (T,) [m] since t = 0, of a pair that
    closes with `speed` [m/s] and touches at `start` [s].

    The overlap is sin(w (t - start)) speed/w with w = `rate` [1/s] for half a period, after which
    the pair parts with the same speed.
    """
    phase = np.clip(rate * (t - start), 0.0, np.pi)
    before = np.minimum(t, start)
    after = np.maximum(t - start - np.pi / rate, 0.0)
    return speed * np.cos(phase), speed * (before + np.sin(phase) / rate - after)


def _meeting(name: str, *, between: int, is_second_at_rest: bool = False) -> Probe:
    """Two unlike spheres that start apart, the first and the last in the list, and meet head-on.

    The gap is wider than half the larger radius, and each sphere moves by less than that until they
    meet, unless the second is at rest and the first comes all the way. The bodies between them in
    the list are at rest and far away. The contact has w = sqrt(k/mu) with the reduced mass
    mu = m1 m2/(m1 + m2).
    """
    masses = np.array([2.0, 3.0])
    radii = (0.5, 0.25)
    gap = 0.375
    speed = 1.0
    along = np.array([0.6, 0.8, 0.0])
    place = np.array([-1.0, 0.5, 0.0])
    starts = np.stack([place, place + (sum(radii) + gap) * along])
    rate = float(np.sqrt(STIFFNESS * masses.sum() / masses.prod()))
    # Both move at the same speed before they meet, or the first alone. The centre of mass keeps its
    # velocity.
    shares = masses[::-1] / masses.sum() * [1.0, -1.0]
    centre_velocity = (masses[0] - masses[1]) / masses.sum() * speed / 2
    if is_second_at_rest:
        centre_velocity = masses[0] / masses.sum() * speed
    rows, columns = np.divmod(np.arange(between), 10)
    far = np.column_stack([4.0 + 1.25 * rows, 1.25 * columns - 5.0, 0.0 * rows])

    def expected(t: Array) -> Expected:
        closing, closed = _bounce(t, rate, speed, gap / speed)
        moved = t[:, None] * centre_velocity + closed[:, None] * shares
        velocity = centre_velocity + closing[:, None] * shares
        return {
            "position": _with_others(starts + moved[..., None] * along, far),
            "velocity": _with_others(velocity[..., None] * along, 0 * far),
        }

    others = [(2.0, 0.5)] * between
    sizes = [(masses[0], radii[0]), *others, (masses[1], radii[1])]
    return _of_spheres(
        name, "which spheres are looked at as neighbours, and when that is renewed", sizes, expected
    )


def _with_others(pair: Array, others: Array) -> Array:
    """Rows (T, 2 + N, 3): the first of a pair (T, 2, 3), then N others (N, 3), then its second."""
    constant = np.broadcast_to(others, (len(pair), *others.shape))
    return np.concatenate([pair[:, :1], constant, pair[:, 1:]], axis=1)


def _surrounded() -> Probe:
    """Equal spheres that come at one time from evenly spaced directions in a plane to a sphere at
    rest, which stays at rest.

    Each one moves as at a wall, w = sqrt(k/m).
    """
    mass = 2.0
    radii = (0.5, 0.25)
    gap = 0.25
    speed = 1.0
    centre = np.array([1.0, -0.5, 0.0])
    rate = float(np.sqrt(STIFFNESS / mass))
    angles = 0.25 + 2 * np.pi / AROUND * np.arange(AROUND)
    outwards = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])

    def expected(t: Array) -> Expected:
        closing, closed = _bounce(t, rate, speed, gap / speed)
        distance = sum(radii) + gap - closed
        ring = centre + distance[:, None, None] * outwards
        ring_velocity = -closing[:, None, None] * outwards
        at_rest = np.zeros((len(t), 1, 3))
        return {
            "position": np.concatenate([at_rest + centre, ring], axis=1),
            "velocity": np.concatenate([at_rest, ring_velocity], axis=1),
        }

    sizes = [(3.0, radii[0]), *[(mass, radii[1])] * AROUND]
    return _of_spheres(
        "surrounded", "a sphere in several contacts at once, and every one of them", sizes, expected
    )


def _across_boundary(name: str, crossed: Array, period: float) -> Probe:
    """Pairs that start apart in a periodic box and meet head-on across its boundary, along the axes
    that `crossed` (P, 3) has as 1 and not as 0.

    Each pair moves as one in empty space. Velocities alone are compared, since any image of a place
    is as good. A box from 0 to `period` [m] has all spheres at its start.
    """
    masses = np.array([2.0, 3.0])
    radii = np.array([0.5, 0.25])
    gap = 0.375
    speed = 1.0
    rate = float(np.sqrt(STIFFNESS * masses.sum() / masses.prod()))
    # The centre of mass is at rest, and sphere 1 has the part m2/(m1 + m2) of the closing speed.
    shares = masses[::-1] / masses.sum() * [1.0, -1.0]
    along = crossed * ACROSS
    along /= np.linalg.norm(along, axis=1)[:, None]
    # In the middle of a face or an edge, of which 0 is a point: period/2 along the other axes.
    middle = period / 2 * (1.0 - crossed)
    reach = radii.sum() + gap
    # (P, 2, 3): half of the distance to either side of the boundary.
    pairs = middle[:, None] + np.array([-0.5, 0.5])[:, None] * reach * along[:, None]
    inside = (pairs % period).reshape(-1, 3)
    # (2 P, 3): for each sphere the direction, times its part of the closing speed.
    directions = (shares[:, None] * along[:, None]).reshape(-1, 3)

    def expected(t: Array) -> Expected:
        closing, _ = _bounce(t, rate, speed, gap / speed)
        return {"velocity": closing[:, None, None] * directions}

    start = expected(np.zeros(1))["velocity"][0]
    sizes = list(zip(masses, radii, strict=True)) * len(crossed)
    bodies = [
        Body(
            mass=float(mass),
            position=tuple(position.tolist()),
            velocity=tuple(velocity.tolist()),
            shape=Sphere(radius=float(radius)),
        )
        for (mass, radius), position, velocity in zip(sizes, inside, start, strict=True)
    ]
    contact = Contact(law="linear", stiffness=STIFFNESS)
    return Probe(
        name=name,
        verifies="periodic images of spheres across the faces, edges and corners of the box",
        scene=Scene.of(bodies, [PeriodicBox(size=period), contact]),
        expected=expected,
    )


def _in_corner() -> Probe:
    """A sphere that flies into a corner of three walls at right angles, and presses all of them at
    one time.

    Along each normal n it moves as at that wall alone, w = sqrt(k/m). It touches one wall after
    another, and leaves the first after it has touched the last.
    """
    mass = 2.0
    radius = 0.5
    corner = np.array([1.0, -0.5, 0.25])
    normals = np.array([[2.0, 2.0, -1.0], [-1.0, 2.0, 2.0], [2.0, -1.0, 2.0]]) / 3.0
    speeds = np.array([1.0, 0.75, 1.25])
    touches = np.array([0.25, 0.3125, 0.375])
    rate = float(np.sqrt(STIFFNESS / mass))

    def expected(t: Array) -> Expected:
        bounces = [
            _bounce(t, rate, speed, touch) for speed, touch in zip(speeds, touches, strict=True)
        ]
        closing = np.stack([bounce[0] for bounce in bounces], axis=1)
        closed = np.stack([bounce[1] for bounce in bounces], axis=1)
        heights = radius + speeds * touches - closed
        return {
            "position": (corner + heights @ normals)[:, None],
            "velocity": (-closing @ normals)[:, None],
        }

    start = expected(np.zeros(1))
    body = Body(
        mass=mass,
        position=tuple(start["position"][0, 0].tolist()),
        velocity=tuple(start["velocity"][0, 0].tolist()),
        shape=Sphere(radius=radius),
    )
    walls = [
        Plane(point=tuple(corner.tolist()), normal=tuple(normal.tolist())) for normal in normals
    ]
    contact = Contact(law="linear", stiffness=STIFFNESS)
    return Probe(
        name="in a corner",
        verifies="contacts of one sphere with several walls at once",
        scene=Scene.of([body], [*walls, contact]),
        expected=expected,
    )


def _of_spheres(
    name: str,
    verifies: str,
    sizes: list[tuple[float, float]],
    expected: Callable[[Array], Expected],
) -> Probe:
    """The probe of spheres of these masses [kg] and radii [m] that start as `expected` does."""
    start = expected(np.zeros(1))
    bodies = [
        Body(
            mass=mass,
            position=tuple(position.tolist()),
            velocity=tuple(velocity.tolist()),
            shape=Sphere(radius=radius),
        )
        for (mass, radius), position, velocity in zip(
            sizes, start["position"][0], start["velocity"][0], strict=True
        )
    ]
    scene = Scene.of(bodies, [Contact(law="linear", stiffness=STIFFNESS)])
    return Probe(name=name, verifies=verifies, scene=scene, expected=expected)
