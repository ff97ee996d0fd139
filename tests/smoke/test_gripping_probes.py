"""The probe of a tangential spring against a sphere in numpy: right with a spring that is 0 at each
touch, wrong with one that is kept, and within its bound for the simplest first-order method.
"""

import numpy as np
import pytest

from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.smoke.battery import BOUND, STEP
from refdem.smoke.diagnosis import distance
from refdem.smoke.gripping_probes import gripping_probe

PROBE = gripping_probe()


def simulated(*, forgets, forward):
    """Position, velocity and omega (T, 1, 3) by symplectic or forward Euler, with springs that
    forget their stretch where a contact ends or keep it.
    """
    bodies = PROBE.scene.bodies
    law = PROBE.scene.all(Contact)[0]
    walls = PROBE.scene.all(Plane)
    radius = bodies.radius[0]
    r, v, omega = (a[0].copy() for a in (bodies.position, bodies.velocity, bodies.omega))
    springs = np.zeros((len(walls), 3))
    rows = [(r, v, omega)]
    per_sample = round((PROBE.times[1] - PROBE.times[0]) / STEP)
    for step in range(per_sample * (len(PROBE.times) - 1)):
        force = np.zeros(3)
        torque = np.zeros(3)
        for number, wall in enumerate(walls):
            normal = np.array(wall.normal)
            overlap = radius - (r - np.array(wall.point)) @ normal
            if overlap <= 0:
                if forgets:
                    springs[number] = 0.0
                continue
            slip = v - (v @ normal) * normal + np.cross(omega, -radius * normal)
            springs[number] += STEP * slip
            rub = -law.tangential_stiffness * springs[number]
            force += law.stiffness * overlap * normal + rub
            torque += np.cross(-radius * normal, rub)
        before = v
        v = v + STEP * force / bodies.mass[0]
        omega = omega + STEP * torque / bodies.inertia[0]
        r = r + STEP * (before if forward else v)
        if (step + 1) % per_sample == 0:
            rows.append((r, v, omega))
    columns = (np.array(column)[:, None] for column in zip(*rows, strict=True))
    return dict(zip(("position", "velocity", "omega"), columns, strict=True))


def errors(**rules):
    seen = simulated(**rules)
    return {name: distance(seen[name], PROBE.expected_values[name], name) for name in seen}


@pytest.mark.parametrize("forward", [False, True])
def test_first_order_methods_are_within_the_bound(forward):
    assert max(errors(forgets=True, forward=forward).values()) < 0.75 * BOUND


def test_a_spring_that_is_kept_after_a_contact_is_seen():
    assert max(errors(forgets=False, forward=False).values()) > 5 * BOUND
