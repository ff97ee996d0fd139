"""Slip that ends, or begins, out of any plane, without a tangential spring: no reference method is
accused there, faults are.
"""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from refdem.core import discovery
from refdem.engines.reference import ENGINE
from refdem.faults.change import of_elements, scaled
from refdem.faults.fault import Fault
from refdem.kills.trials import WITHHELD
from refdem.planning.in_process import record_of, task_of
from refdem.scene.elements.contact import Contact

SETTINGS = 64
ASKED = {"damping": "1", "friction": "1/2", "angle": "2/5", "spins": "1,0,0,0,2,0"}


def drawn(seed):
    """Two unequal spheres with spins about any axes that rub so much that most slips end."""
    rng = np.random.default_rng(seed)

    def some(low, high):
        return str(Fraction(int(rng.integers(32 * low, 32 * high)), 32))

    return {
        **{
            "friction": some(0.1, 1),
            "angle": some(0.1, 0.8),
            "damping": some(0, 2),
            "masses": f"1,{some(1, 3)}",
        },
        **{"radii": f"1/2,{some(0.25, 1)}", "spins": ",".join(some(-2, 2) for _ in range(6))},
        **{
            "branch": str(rng.choice(["R", "R-d", "R-d/2"])),
            "cutoff": str(rng.choice(["zero_overlap", "zero_force"])),
        },
    }


def findings(engine, given, *checks):
    """What all of its methods that do not refuse are told."""
    instance = discovery.case("two-spheres").at(**given)
    methods = [
        method.name
        for method in engine.methods
        if engine.unsupported(instance.problem, method) is None
    ]
    assert methods
    records = [
        record_of(task_of(engine, method, instance, WITHHELD, 3, checks)) for method in methods
    ]
    return [(record.id(f), f) for record in records for f in record.findings]


@pytest.mark.parametrize("first", range(0, SETTINGS, 16))
def test_no_method_of_the_reference_is_accused(first):
    held = set()
    for seed in range(first, first + 16):
        found = findings(ENGINE, drawn(seed))
        assert [
            f"{name}: {f.sentence}" for name, f in found if f.outcome in ("fail", "error")
        ] == []
        passed = {f"{f.check}/{f.quantity}" for _, f in found if f.outcome == "pass"}
        assert {"symmetry/shifted", "symmetry/rotated", "momentum/total"} <= passed
        held |= passed
    assert {"convergence", "energy"} <= {name.split("/")[0] for name in held}


def test_velocity_verlet_answers_where_steps_that_look_for_a_zero_of_the_slip_refuse():
    problem = discovery.case("two-spheres").at(**ASKED).problem
    refused = {method.name: ENGINE.unsupported(problem, method) for method in ENGINE.methods}
    assert refused["velocity-verlet"] is None
    assert "leaves its plane" in refused["rk4"]
    assert "leaves its plane" in refused["contact-events"]


@pytest.mark.parametrize(
    "plane",
    [
        {"spins": "0,0,1,0,0,-2", "angle": "2/5"},  # across the plane of the motion
        {"spins": "0,1,0,0,2,0"},  # head-on: spins across one plane
        {"spins": "1,0,0,-2,0,0"},  # head-on: spins about the normal never slip
        {
            "spins": "1,0,0,0,2,0",
            "tangential_stiffness": "64",
        },  # the spring has a direction of its own
    ],
)
def test_slip_that_keeps_to_a_plane_is_for_all(plane):
    problem = discovery.case("two-spheres").at(damping="1", friction="1/2", **plane).problem
    assert ENGINE.unsupported(problem, ENGINE.method("rk4")) is None


def test_slip_that_has_ended_stays_ended():
    """Arms R: slip = w - (w n) n + (R1 o1 + R2 o2) x n; zero while they stick."""
    instance = discovery.case("two-spheres").at(**ASKED, branch="R")
    run = record_free(instance, instance.problem.interval / 64)
    apart = run.position[:, 1] - run.position[:, 0]
    normal = apart / np.linalg.norm(apart, axis=1, keepdims=True)
    across = run.velocity[:, 0] - run.velocity[:, 1]
    turning = np.einsum("b,tbx->tx", instance.scene.bodies.radius, run.omega)
    slip = (
        across - np.sum(across * normal, axis=1, keepdims=True) * normal + np.cross(turning, normal)
    )
    speed = np.linalg.norm(slip, axis=1)
    stuck = (run.t > run.t[14]) & (run.t < run.t[26])
    assert speed[0] > 1
    assert np.max(speed[stuck]) < 1e-7


def record_free(instance, step):
    """The trajectory of velocity Verlet."""
    from refdem.core.problem import Request

    return ENGINE.run(Request(problem=instance.motion, method="velocity-verlet", step=step))[0]


def _knows_the_place(request):
    """Friction that is a millionth larger beyond y = -0.1."""
    here = request.problem.scene.bodies.position[0, 1] < -0.1
    return of_elements(Contact, friction=scaled(1 + 1e-6 * here))(request)


def _turned_in_axes(request, run):
    """Spins about z are a millionth too large."""
    return replace(
        run, omega=run.omega * np.array([1.0, 1.0, 1.0 + 1e-6 * (run.omega[0, 0, 0] != 1.0)])
    )


PLANTED = {
    "shifted": Fault(
        name="place",
        kind="frames",
        sentence="",
        on=("spinner",),
        sees=("symmetry", "shifted"),
        before=_knows_the_place,
    ),
    "rotated": Fault(
        name="axes",
        kind="frames",
        sentence="",
        on=("spinner",),
        sees=("symmetry", "rotated"),
        after=_turned_in_axes,
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_faults_of_a_millionth_are_seen_there(name):
    found = findings(PLANTED[name].carrier(ENGINE), ASKED, "symmetry")
    failed = {f.quantity for _, f in found if f.outcome == "fail"}
    assert name in failed
