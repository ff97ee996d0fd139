"""Oblique collisions by series: certified truth, the extrapolating method, and what it leaves to
others.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import mechanical
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.scene import Scene
from refdem.solvers.oblique_contact import METHOD

STATE = tuple(f"{kind}{i}.{axis}" for i in (1, 2) for kind in ("r", "v", "omega") for axis in "xyz")
RUBS = {"damping": "1", "angle": "0.6", "friction": "1/4", "tangential_stiffness": "96"}
SETS = {
    "holds, slips, is pulled": RUBS,
    "elastic": RUBS | {"damping": "0"},
    "spins, unequal": RUBS | {"masses": "1,2", "spins": "0,0,1,0,0,-2"},
    "slips at once": RUBS | {"angle": "1.2", "friction": "0.1", "damping": "0", "branch": "R-d"},
    "force that must not pull": (
        RUBS
        | {
            "masses": "1,3",
            "radii": "1/2,4/5",
            "spins": "0,0,2,0,0,-5",
            "cutoff": "zero_force",
            "branch": "R",
        }
    ),
    "smooth": {"damping": "1", "angle": "0.6"},
    "rough": RUBS | {"friction": "2"},
    "never parts": RUBS | {"damping": "20"},
}


def solved(scene: Scene, times: np.ndarray, method: str = "oblique-contact") -> Trajectory:
    return ENGINE.run(Request(problem=Motion(scene, times), method=method))[0]


def refused(**given: str) -> str | None:
    return METHOD.unsupported(discovery.case("two-spheres").at(**given).motion)


@pytest.mark.parametrize("given", SETS.values(), ids=SETS)
def test_it_agrees_with_certified_truth_to_an_ulp_or_two_of_the_place(given, largest_error):
    problem = discovery.case("two-spheres").at(**given).motion
    assert (
        largest_error("two-spheres", solved(problem.scene, problem.times), STATE, **given) < 4e-14
    )


@pytest.mark.parametrize("given", SETS.values(), ids=SETS)
def test_channels_and_release_are_those_of_the_extrapolating_method(given):
    problem = discovery.case("two-spheres").at(**given).motion
    seen, other = (
        solved(problem.scene, problem.times, method)
        for method in ("oblique-contact", "contact-events")
    )
    for name, size in (("overlap", 1.0), ("contact_force", 20.0), ("dissipated_work", 1.0)):
        assert np.abs(seen.channels[name] - other.channels[name])[1:].max() < 1e-13 * size, name
    assert np.array_equal(seen.channels["contacts"][1:], other.channels["contacts"][1:])
    assert [event.kind for event in seen.events] == [event.kind for event in other.events]
    assert [event.time for event in seen.events] == pytest.approx(
        [event.time for event in other.events], rel=4e-15
    )
    assert np.abs(seen.attitude - other.attitude).max() < 1e-14


@pytest.mark.parametrize(
    "given",
    [
        {"damping": "8"},
        {"damping": "15.84"},
        {"damping": "1", "stiffness": "100"},
        {"damping": "1e4", "cutoff": "zero_force"},
        RUBS | {"friction": "2", "tangential_stiffness": "1e4"},
    ],
)
def test_the_work_lost_is_as_exact_as_the_motion_over_steps_as_long(given):
    instance = discovery.case("two-spheres").at(**given)
    run = solved(instance.scene, instance.times)
    scene = instance.scene
    inner = run.channels["contacts"] == 0  # while the tangential spring is bent it holds energy
    energy = mechanical(scene, run) + run.channels["dissipated_work"].reshape(len(run.t), -1).sum(
        axis=1
    )
    if "friction" not in given:
        seen = slice(None)
    else:
        seen = inner
    assert (
        np.abs(energy[seen] / energy[0] - 1.0).max() < 2e-14
    )  # 3e-13 where the work's series ends with the motion's


def test_a_plane_turned_in_space_turns_the_motion():
    problem = discovery.case("two-spheres").at(**SETS["spins, unequal"]).motion
    turn = np.linalg.qr(np.array([[1.0, 2.0, 3.0], [2.0, -1.0, 1.0], [0.5, 1.0, -2.0]]))[0]
    turn *= np.linalg.det(turn)
    bodies = problem.scene.bodies
    turned = [body_at(bodies, number, turn) for number in range(2)]
    seen, plain = (
        solved(scene, problem.times)
        for scene in (Scene.of(turned, problem.scene.elements), problem.scene)
    )
    assert np.abs(seen.position - plain.position @ turn.T).max() < 6e-15
    assert np.abs(seen.omega - plain.omega @ turn.T).max() < 1e-14


def body_at(bodies, number: int, turn: np.ndarray):
    from refdem.scene import Body

    vectors = {
        name: tuple(turn @ getattr(bodies, name)[number])
        for name in ("position", "velocity", "omega")
    }
    return Body(
        mass=bodies.mass[number],
        inertia=tuple(bodies.inertia[number]),
        shape=bodies.shape[number],
        **vectors,
    )


def test_what_it_cannot_say_is_refused_by_name():
    assert refused(**RUBS) is None
    assert "without a tangential spring" in (
        refused(damping="1", angle="0.6", friction="1/4") or ""
    )
    assert "out of its plane" in (refused(**RUBS, spins="0,1,0,0,0,0") or "")
    problem = discovery.case("two-spheres").at(**RUBS).motion
    assert "backwards" in (METHOD.unsupported(Motion(problem.scene, -problem.times)) or "")
    parting = [body_at(problem.scene.bodies, 1 - number, np.eye(3)) for number in range(2)]
    scene = Scene.of(parting, problem.scene.elements)
    assert (
        METHOD.unsupported(Motion(scene, problem.times)) is None
    )  # the same pair, named the other way round
