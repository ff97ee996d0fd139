"""Contacts that part before their overlap has ended, since their force would pull: energy and work
add up at every moment, whether they press again within the overlap or leave it first.
"""

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

STIFFNESS = 100.0
DAMPING = 4.0
MASS = 1.0
GRAVITY = 10.0
STEP = 2.0**-11


def ball(depth: float) -> Scene:
    """A ball at rest, pressed into the ground by `depth` [m]."""
    body = Body(
        mass=MASS,
        inertia=(0.5, 0.5, 0.5),
        position=(0.0, 1.0 - depth, 0.0),
        shape=Sphere(radius=1.0),
    )
    law = Contact(law="linear", stiffness=STIFFNESS, damping=DAMPING, cutoff="zero_force")
    return Scene.of(
        [body], [law, Plane(normal=(0.0, 1.0, 0.0)), UniformGravity(g=(0.0, -GRAVITY, 0.0))]
    )


@pytest.mark.parametrize(
    ("method", "step", "allowed"),
    [
        ("contact-events", None, 1e-12),
        ("rk4", STEP, 1e-7),
        ("velocity-verlet", STEP, 1e-3),
    ],
)
@pytest.mark.parametrize(("depth", "leaves"), [(0.28, False), (0.3, True)])
def test_energy_and_work_add_up_while_a_contact_is_parted_and_presses_again(
    method: str, step: float | None, allowed: float, depth: float, leaves: bool
) -> None:
    times = np.arange(193) / 128
    request = Request(problem=Motion(ball(depth), times), method=method, step=step)
    run, _ = ENGINE.run(request)
    height = run.position[:, 0, 1]
    speed = run.velocity[:, 0, 1]
    overlap = np.maximum(0.0, 1.0 - height)
    kinetic = MASS * speed**2 / 2
    potential = MASS * GRAVITY * height + STIFFNESS * overlap**2 / 2
    balance = kinetic + potential + run.channels["dissipated_work"]
    assert np.abs(balance - balance[0]).max() < allowed
    # It parts within its overlap, and comes back within it unless it leaves.
    is_parted = (overlap > 0) & (run.channels["contacts"] == 0)
    assert is_parted.any()
    assert (overlap == 0).any() == leaves
    assert run.channels["contacts"][-1] == 1
    assert [event.kind for event in run.events][:2] == ["release", "contact"]
