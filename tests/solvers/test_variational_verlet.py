"""Velocity Verlet with its equations of first variation: derivatives of a fall by hand, those of
the steps themselves, right at random settings, and seen where they are wrong.
"""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.core.scene_numbers import numbers_in
from refdem.core.trajectory import STATE
from refdem.engines.reference import ENGINE, Reference
from refdem.errors import UnsupportedError
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene import Body, Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.random_settings import SETTINGS, first_accepted, settings, shortened

NAME = "variational-verlet"
METHOD = ENGINE.method(NAME)
SMOOTH = ("harmonic-oscillator", "duffing", "two-body-orbit")
TIMES = np.arange(9) * 0.125
MANY = Scene.of(
    [
        Body(mass=2.0, position=(1.0, 0.25, 0.0), velocity=(0.0, 1.0, 0.5)),
        Body(mass=0.5, position=(-1.0, 0.5, 0.25), velocity=(0.25, -1.0, 0.0)),
    ],
    [
        Spring(a=0, b=1, stiffness=3.0, length=1.5, cubic=0.5),
        Spring(a=1, stiffness=2.0, cubic=0.25, anchor_b=(0.5, 0.0, 0.0)),
        UniformGravity(g=(0.0, -1.0, 0.5)),
        CentralField(gm=0.75),
    ],
)


def run(scene, keys=(), step=2.0**-6):
    """A run of a scene with the derivatives by these numbers."""
    problem = Motion(scene, TIMES)
    assert ENGINE.unsupported(problem, METHOD) is None
    request = Request(problem=problem, method=NAME, step=step, sensitivities=keys)
    return ENGINE.run(request)[0]


def test_the_derivatives_of_a_fall_are_those_of_its_formula():
    # r = r0 + v0 t + g t^2/2, which Verlet's steps have without error.
    scene = Scene.of(
        [Body(mass=2.0, velocity=(1.0, 0.0, 0.0))], [UniformGravity(g=(0.0, -2.0, 0.0))]
    )
    keys = (
        "scene.bodies.0.position.0",
        "scene.bodies.0.velocity.2",
        "scene.elements.0.g.1",
        "scene.bodies.0.mass",
    )
    slopes = run(scene, keys).derivatives
    by_hand = {
        keys[0]: {0: np.ones(9)},
        keys[1]: {2: TIMES, 5: np.ones(9)},
        keys[2]: {1: TIMES**2 / 2, 4: TIMES},
        keys[3]: {},
    }
    for key, columns in by_hand.items():
        expected = np.zeros((9, 13))
        for column, values in columns.items():
            expected[:, column] = values
        np.testing.assert_allclose(slopes[key][:, 0], expected, atol=1e-14)


KEYS = tuple(
    key
    for key in numbers_in(MANY)
    if key.split(".")[3]
    in ("mass", "position", "velocity", "stiffness", "length", "cubic", "g", "gm")
    or key.startswith("scene.elements.1.anchor_b")
)


@pytest.mark.parametrize("key", [key for key in KEYS if key != "scene.elements.1.length"])
def test_derivatives_are_those_of_the_steps_themselves(key):
    distance = 2.0**-14

    def moved(by):
        """The states of a run whose scene has another number at the key."""
        document = msgspec.json.decode(MANY.to_json())
        *way, last = [int(word) if word.isdigit() else word for word in key.split(".")[1:]]
        holder = document
        for word in way:
            holder = holder[word]
        holder[last] += by
        states = run(Scene.from_json(msgspec.json.encode(document)))
        return np.concatenate([getattr(states, name) for name in STATE], axis=-1)

    difference = (moved(distance) - moved(-distance)) / (2 * distance)
    slopes = run(MANY, (key,)).derivatives[key]
    np.testing.assert_allclose(slopes, difference, atol=3e-7 * max(1.0, np.max(np.abs(slopes))))
    assert np.any(slopes)


def found(instance, engine=ENGINE):
    """The findings of the check by quantity."""
    task = task_of(engine, NAME, instance, truth_of(instance), 3, ["gradient"])
    return {finding.quantity: finding for finding in record_of(task).findings}


@pytest.mark.parametrize("case", SMOOTH)
@pytest.mark.parametrize("number", range(SETTINGS))
def test_derivatives_are_right_at_random_settings(case, number):
    def made(rng):
        instance = shortened(case, settings(rng, case))
        if reason := ENGINE.unsupported(instance.problem, METHOD):
            raise UnsupportedError(reason)
        return instance

    findings = found(first_accepted(case, number, made))
    assert findings["matrix"].outcome == "pass", findings["matrix"].sentence
    assert all(finding.outcome == "pass" for finding in findings.values())


def transposed(request, slopes):
    """The derivatives by the place and the velocity along x, as rows for columns."""
    place = "scene.bodies.0.position.0"
    speed = "scene.bodies.0.velocity.0"
    changed = {key: np.array(of) for key, of in slopes.items()}
    changed[place][:, 0, 3] = slopes[speed][:, 0, 0]
    changed[speed][:, 0, 0] = slopes[place][:, 0, 3]
    return changed


def without_last_drift(request, slopes):
    """The derivatives of places before the last drift, R - h V."""
    changed = {key: np.array(of) for key, of in slopes.items()}
    for of in changed.values():
        of[1:, :, 0:3] -= request.signed_step * of[1:, :, 3:6]
    return changed


@pytest.mark.parametrize("error", [transposed, without_last_drift])
def test_a_wrong_derivative_fails(error):
    class Wrong(Reference):
        """The reference, whose derivatives have an error."""

        def run(self, request):
            trajectory, cost = super().run(request)
            if not request.sensitivities:
                return trajectory, cost
            return replace(trajectory, derivatives=error(request, trajectory.derivatives)), cost

    given = {"v0": "1/2", "stiffness": "3", "duration": "4", "samples": "16"}
    findings = found(discovery.case("harmonic-oscillator").at(**given), Wrong())
    assert "fail" in {finding.outcome for finding in findings.values()}


def test_springs_of_other_powers_are_refused():
    body = Body(mass=1.0, position=(1.0, 0.0, 0.0))
    for spring in (
        Spring(a=0, stiffness=1.0, exponent=3.0),
        Spring(a=0, stiffness=1.0, quadratic=1.0),
    ):
        assert "power" in ENGINE.unsupported(Motion(Scene.of([body], [spring]), TIMES), METHOD)


def test_a_scene_gets_the_method_by_its_name_only():
    assert NAME not in {method.name for method in ENGINE.chosen_methods()}
    assert ENGINE.best(Motion(MANY, TIMES)).name == "velocity-verlet"
