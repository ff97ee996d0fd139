"""Faults that codes for many particles have, each on the reference's own run of a gas, and the
checks that see them.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from refdem.checks.roughness import _inertia
from refdem.core import discovery
from refdem.core.check import CompletedRun, Subject
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.bodies import Bodies
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.truth.sampled import sampled

SMOOTH = {"n": "4000", "duration": "8", "restitution": "4/5", "samples": "8"}
ROUGH = {"n": "4000", "duration": "4", "restitution": "1", "friction": "1000", "samples": "8"}
REBUILT = 50
SELDOM = 400
"""Steps from one list of neighbours to the next, and from one piece to the next where that is not
the fault.
"""


def right(request: Request) -> Trajectory:
    return ENGINE.run(request)[0]


def wrong_restitution(request: Request) -> Trajectory:
    """The dashpot acts twice."""
    scene = request.problem.scene
    elements = tuple(
        replace_field(e, damping=2 * e.damping) if isinstance(e, Contact) else e
        for e in scene.elements
    )
    return right(request.with_scene(Scene(scene.bodies, elements)))


def no_images(request: Request) -> Trajectory:
    """Spheres do not meet across the edges of the box."""
    scene = request.problem.scene
    size = scene.all(PeriodicBox)[0].size
    return in_pieces(request, lambda x: np.floor(x / size) @ (1, 1000, 1000_000))


def wrong_images(request: Request) -> Trajectory:
    """Images along x are a diameter too near."""
    scene = request.problem.scene
    elements = tuple(
        replace_field(e, size=e.size - 1.0) if isinstance(e, PeriodicBox) else e
        for e in scene.elements
    )
    return right(request.with_scene(Scene(scene.bodies, elements)))


def lost_momentum(request: Request) -> Trajectory:
    """A sphere that leaves the box comes back a little slower."""
    run = right(request)
    size = request.problem.scene.all(PeriodicBox)[0].size
    left = np.abs(np.floor(run.position / size))
    return replace(run, velocity=run.velocity * (1 - 1e-9 * left))


def missed_at_the_edges_of_cells(request: Request) -> Trajectory:
    """Spheres meet those of their own cell alone, and cells are 5 diameters wide."""
    return in_pieces(request, lambda x: np.floor(x[:, 0] / 5.0))


def history_lost(request: Request) -> Trajectory:
    """Tangential springs are slack after every list of neighbours that is rebuilt."""
    return in_pieces(request, lambda x: np.zeros(len(x)), REBUILT)


FAULTS = {
    wrong_restitution: (SMOOTH, "cooling", {"temperature", "loss"}),
    no_images: (SMOOTH, "cooling", {"collisions"}),
    wrong_images: (SMOOTH, "cooling", {"temperature", "loss"}),
    lost_momentum: (SMOOTH, "momentum", {"total"}),
    missed_at_the_edges_of_cells: (SMOOTH, "cooling", {"collisions"}),
    history_lost: (ROUGH, "roughness", {"energy"}),
}


def replace_field(element, **values):
    return type(element)(
        **{name: getattr(element, name) for name in element.__struct_fields__} | values
    )


def in_pieces(request: Request, group, most: int = SELDOM) -> Trajectory:
    """The motion in pieces between two lists; in each, spheres meet only those of their group, at
    positions (N, 3) in the first piece.
    """
    scene = request.problem.scene
    h = request.signed_step
    t = request.problem.times
    rows = [scene.bodies]
    events = []
    work = [0.0]
    for _ in t[1:]:
        bodies = rows[-1]
        left = request.stride
        lost = work[-1]
        while left:
            steps = min(left, most)
            bodies, begun, gone = piece(
                Scene(bodies, scene.elements), steps, h, group(bodies.position), request.method
            )
            events = events + begun
            left = left - steps
            lost = lost + gone
        rows = [*rows, bodies]
        work = [*work, lost]
    columns = {
        name: np.stack([getattr(b, name) for b in rows])
        for name in ("position", "velocity", "attitude", "omega")
    }
    return Trajectory(
        t=t, channels={"dissipated_work": np.array(work)}, events=tuple(events), **columns
    )


def piece(scene: Scene, steps: int, h: float, groups, method: str):
    """Bodies after some steps, contacts that began, work; a group by itself has no images of its
    own spheres but in a single group.
    """
    ends = {
        name: np.array(getattr(scene.bodies, name))
        for name in ("position", "velocity", "attitude", "omega")
    }
    events = []
    work = 0.0
    alone = len(np.unique(groups)) == 1
    for name in np.unique(groups):
        own = np.flatnonzero(groups == name)
        if len(own) < 8:  # too few for this method: they fly on and meet nothing
            ends["position"][own] += steps * h * ends["velocity"][own]
            continue
        part = {n: getattr(scene.bodies, n)[own] for n in ("mass", "inertia", "fixed", *ends)}
        if alone:
            elements = scene.elements
        else:
            elements = tuple(scene.all(Contact))
        small = Scene(Bodies(shape=tuple(scene.bodies.shape[k] for k in own), **part), elements)
        run = right(
            Request(problem=Motion(small, np.array([0.0, steps * h])), method=method, step=h)
        )
        for n in ends:
            ends[n][own] = getattr(run, n)[-1]
        events = events + list(run.events)
        work = work + float(run.channels["dissipated_work"][-1])
    return scene.bodies.with_state(**ends), events, work


@cache
def findings(name: str, made=right, **given: str):
    """What a check finds of a run."""
    instance = discovery.case("granular-gas").at(**given)
    check = discovery.check(name)
    step = instance.motion.interval / np.ceil(instance.motion.interval / (instance.scales.tau / 5))
    subject = Subject(
        instance, ENGINE.method("gas"), (step,), sampled(instance.truth(), instance.times.tolist())
    )
    assert check.applies(subject) is None
    run = made(Request(problem=instance.motion, method="gas", step=step))
    return {
        f.quantity: f
        for f in check.judge(
            subject, dict.fromkeys(check.needs(subject), CompletedRun(run, Cost(seconds=0.0)))
        )
    }


@pytest.mark.parametrize("made", list(FAULTS), ids=lambda made: made.__name__)
def test_a_fault_of_many_particle_codes_is_seen_where_it_should_be(made):
    given, check, seen = FAULTS[made]
    right = {quantity: f.outcome for quantity, f in findings(check, **given).items()}
    # A temperature that hardly falls in so short a time decides nothing, except where it is beyond
    # its bound.
    undecided = {quantity for quantity, outcome in right.items() if outcome == "undecided"}
    assert undecided <= {"temperature"}
    assert set(right.values()) <= {"pass", "undecided"}
    assert seen <= {
        quantity for quantity, f in findings(check, made, **given).items() if f.outcome == "fail"
    }


@pytest.mark.parametrize("seed", ["2", "3"])
def test_a_rough_elastic_gas_keeps_its_energy_and_spins_as_kinetic_theory_says(seed):
    found = findings("roughness", **ROUGH, seed=seed)
    assert {name: f.outcome for name, f in found.items()} == {"energy": "pass", "spin": "pass"}
    assert found["energy"].bound < 0.03
    assert found["spin"].bound < 0.1


@pytest.mark.parametrize(
    "given", [{"friction": "1/2", "restitution": "1"}, {"friction": "1000"}, {"boundary": "walls"}]
)
def test_only_perfectly_rough_elastic_gases_are_judged(given):
    instance = discovery.case("granular-gas").at(n="30", **given)
    subject = Subject(
        instance, ENGINE.method("gas"), (1e-3,), sampled(instance.truth(), instance.times.tolist())
    )
    assert discovery.check("roughness").applies(subject)


def test_the_moment_of_inertia_that_theory_wants_is_two_fifths_for_homogeneous_spheres():
    mass = 3.0
    radius = 0.25
    body = Body(mass=mass, inertia=(0.4 * mass * radius**2,) * 3, shape=Sphere(radius=radius))
    assert _inertia(Scene.of([body])) == pytest.approx(0.4, rel=1e-15)
