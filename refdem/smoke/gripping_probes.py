"""The probe of a sphere with a tangential contact spring, which touches two walls alternately.

A tangential spring has no stretch at the beginning of each contact. A program that keeps the
stretch of an earlier contact shows it only when the same two bodies touch again.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.smoke.probes import Expected, Probe

Array = NDArray[np.float64]

STIFFNESS = 200.0
"""Normal stiffness [N/m]. It is soft because forward Euler increases a velocity by the factor
1 + pi w h/2 in each contact.
"""
TANGENTIAL_STIFFNESS = 16.0
"""Tangential stiffness [N/m], with which the stretch is largest near the end of a contact."""
GRIP = 1e4
"""Coefficient of friction: the spring slips only in the last 1e-4 of a contact."""
CONTACTS = 3
"""Contacts that begin before the last sample; the third is with the first wall again."""


def gripping_probe() -> Probe:
    """A spinning sphere between a floor and a ceiling, without weight, which grips them.

    With w = sqrt(k/m) a contact lasts pi/w. Its spring stretches by the slip s, and s'' = -W^2 s
    with W^2 = kt (1/m + R^2/J). A floor below, at n = 1, has s = vx + R omega_z, and a ceiling, at
    n = -1, has s = vx - R omega_z. A change of s changes vx by its share mu/m and omega_z by n R
    mu/J, mu = 1/(1/m + R^2/J). The spin about the normal stays.
    """
    mass = 2.0
    radius = 0.5
    inertia = 0.25
    speed = 1.5
    gap = 0.1
    start_vx = 0.75
    start_omega = np.array([0.0, 2.0, 1.5])
    rate = float(np.sqrt(STIFFNESS / mass))
    duration = np.pi / rate
    tangential_mass = 1.0 / (1.0 / mass + radius**2 / inertia)
    tangential_rate = float(np.sqrt(TANGENTIAL_STIFFNESS / tangential_mass))

    def expected(t: Array) -> Expected:
        # Before the first contact changes anything.
        x = start_vx * t
        vx = start_vx + 0 * t
        y = radius - speed * t
        vy = -speed + 0 * t
        omega_z = start_omega[2] + 0 * t
        vx_before = start_vx
        omega_before = float(start_omega[2])
        for number in range(CONTACTS):
            side = (-1.0) ** number
            touch = number * (duration + gap / speed)
            within = np.clip(t - touch, 0.0, duration)
            after = np.maximum(t - touch - duration, 0.0)
            # Normal: the velocity -n v cos(w t) during the contact.
            vy += side * speed * (1 - np.cos(rate * within))
            y += side * speed * (within - np.sin(rate * within) / rate + 2 * after)
            # Tangential: s (cos(W t) - 1) is the change of the slip since the touch.
            slip = vx_before + side * radius * omega_before
            change = slip * (np.cos(tangential_rate * within) - 1)
            last_change = slip * (np.cos(tangential_rate * duration) - 1)
            travelled = slip * (np.sin(tangential_rate * within) / tangential_rate - within)
            share = tangential_mass / mass
            turning_share = side * radius * tangential_mass / inertia
            vx += share * change
            x += share * (travelled + last_change * after)
            omega_z += turning_share * change
            vx_before += share * last_change
            omega_before += turning_share * last_change
        zero = 0 * t
        return {
            "position": np.column_stack([x, y, zero])[:, None],
            "velocity": np.column_stack([vx, vy, zero])[:, None],
            "omega": np.column_stack([zero, zero + start_omega[1], omega_z])[:, None],
        }

    body = Body(
        mass=mass,
        inertia=(inertia, inertia, inertia),
        position=(0.0, radius, 0.0),
        velocity=(start_vx, -speed, 0.0),
        omega=tuple(start_omega.tolist()),
        shape=Sphere(radius=radius),
    )
    contact = Contact(
        law="linear",
        stiffness=STIFFNESS,
        tangential_stiffness=TANGENTIAL_STIFFNESS,
        friction=GRIP,
        branch="R",
    )
    floor = Plane(point=(0.0, 0.0, 0.0), normal=(0.0, 1.0, 0.0))
    ceiling = Plane(point=(0.0, 2 * radius + gap, 0.0), normal=(0.0, -1.0, 0.0))
    return Probe(
        name="gripping two walls",
        verifies=(
            "the tangential spring of a contact (0 at first touch), its lever arm and its torque"
        ),
        scene=Scene.of([body], [floor, ceiling, contact]),
        expected=expected,
    )
