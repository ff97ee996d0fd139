"""Figure 1.36: angular momentum of a free body on Poinsot's ellipsoid of constant kinetic energy
(1.137), (1.138).
"""

from collections.abc import Iterator

import numpy as np

from refdem.core.figure import GREY, Axis, Figure, Panel, Series
from refdem.gallery.runs import Array, observed, observed_at
from refdem.gallery.space import axis, projected

INERTIA = np.array([1.0, 2.0, 3.0])
ENERGY = 1.0
"""Kinetic energy [J]. Another one scales the picture alone."""
VIEW_HALF_WIDTH = 3.4
"""Half of the width of the picture in units of the ellipsoid, whose longest half axis is 2.45."""
BEYOND = (2.2, 1.5, 0.7)
"""What the picture shows, and how far the axes stick out of the ellipsoid."""
HALF_AXES = np.sqrt(2 * ENERGY * INERTIA)
ANGLES = (0.25, 0.5, 0.75)
"""From axes 1 and 3 on the ellipsoid made round [rad]."""


def figure() -> Figure:
    """Closed curves about axes 1 and 3, the separatrix through axis 2 (dashed), and the border of
    the ellipsoid.
    """
    series = [border()]
    changes = []
    for first, ink in ((0, 0), (2, 1)):
        for curve in closed_curves(first):
            series += [drawn(curve, ink, is_front=False), drawn(curve, ink, is_front=True)]
            changes.append(float(np.ptp(np.linalg.norm(curve, axis=1))))
    for curve in separatrices():
        series.append(drawn(curve, GREY, is_front=True, dashed=True))
    for n, name in enumerate(("L1", "L2", "L3")):
        unit = np.eye(3)[n]
        begin = HALF_AXES[n] * unit
        end = (HALF_AXES[n] + BEYOND[n]) * unit
        series += axis(begin, end, name)
    hidden = Axis(ends=(-VIEW_HALF_WIDTH, VIEW_HALF_WIDTH), is_hidden=True)
    panel = Panel(series=tuple(series), size=(540, 540), x=hidden, y=hidden)
    caption = (
        "J = (1, 2, 3), kinetic energy 1. The angular momentum in body axes, as the reference's"
        " runs have it, runs along closed curves about axis 1 (blue) and axis 3 (orange), thin"
        " behind; the dashed separatrix leads from axis 2 to its opposite."
    )
    numbers = {"largest change of |L| of all": max(changes)}
    return Figure(
        id="1.36", title="Poinsot's ellipsoid", caption=caption, panels=(panel,), numbers=numbers
    )


def closed_curves(first: int) -> Iterator[Array]:
    """The momenta (T, 3) of runs that start ANGLES off either end of axis number `first`, 0 or 2,
    towards the other one.
    """
    for angle in ANGLES:
        for sign in (1, -1):
            direction = np.zeros(3)
            direction[first] = sign * np.cos(angle)
            direction[2 - first] = np.sin(angle)
            yield momentum(direction)


def separatrices() -> Iterator[Array]:
    """The momenta (T, 3) of runs forwards and backwards from the plane of axes 1 and 3, which come
    to rest on axis 2.
    """
    j1, j2, j3 = INERTIA
    # J1 (J2 - J1) w1^2 = J3 (J3 - J2) w3^2 with w = L/J on the ellipsoid: L/HALF_AXES = n, so that
    # n1^2 (J2 - J1) = n3^2 (J3 - J2).
    ratio = np.sqrt(j2 * (j3 - j2) / (j2 * (j2 - j1)))
    for n1, n3 in ((ratio, 1.0), (-ratio, 1.0), (ratio, -1.0), (-ratio, -1.0)):
        direction = np.array([n1, 0.0, n3]) / np.hypot(n1, n3)
        for forward in (True, False):
            yield momentum(direction, forward=forward)


def momentum(direction: Array, *, forward: bool = True) -> Array:
    """L (T, 3) in body axes of a run whose start is the point HALF_AXES n of the ellipsoid, for a
    unit vector n (3,), the `direction`.
    """
    # w = L/J.
    omega = tuple(f"{w:.12g}" for w in HALF_AXES * direction / INERTIA)
    if forward:
        run = observed("free-rigid-body", omega_body=omega, duration="24", samples=480)
    else:
        run = observed_at("free-rigid-body", -np.linspace(0.0, 24.0, 481), omega_body=omega)
    return INERTIA * np.stack([run[f"omega_body.{axis}"] for axis in "xyz"], axis=1)


def drawn(points: Array, ink: int, *, is_front: bool, dashed: bool = False) -> Series:
    """The part of a curve on the front of the ellipsoid, towards the eye, or the part behind."""
    right, up, _ = projected(points)
    # omega = L/J is normal to the ellipsoid.
    *_, towards = projected(points / INERTIA)
    is_left_out = (towards >= 0) != is_front
    # What is behind is thin.
    width = 0.5
    if is_front:
        width = 1.8
    return Series(
        x=np.where(is_left_out, np.nan, right),
        y=np.where(is_left_out, np.nan, up),
        ink=ink,
        width=width,
        dashed=dashed,
    )


def border() -> Series:
    """The outline of the ellipsoid: where its normal is at right angles to the view."""
    # The direction to the eye: how much each axis points towards it.
    *_, eye = projected(np.eye(3))
    # The ellipsoid is the unit sphere stretched along its axes. The outline is the image of the
    # great circle across this direction.
    pole = eye / HALF_AXES
    pole /= np.linalg.norm(pole)
    first = np.cross(pole, [1.0, 0.0, 0.0])
    first /= np.linalg.norm(first)
    second = np.cross(pole, first)
    angle = np.linspace(0, 2 * np.pi, 181)[:, None]
    circle = np.cos(angle) * first + np.sin(angle) * second
    right, up, _ = projected(HALF_AXES * circle)
    return Series(x=right, y=up, ink=GREY, width=1)
