"""Where a gas starts, and which law of contact gives back which part of the velocity."""

import json
import math
import tracemalloc

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.core.symmetry import NAMES, of
from refdem.core.truth import SampledTruth
from refdem.engines.reference import ENGINE
from refdem.errors import UsageError
from refdem.planning.sheets import LISTED, case_sheet
from refdem.scene.bodies_file import MOST_LISTED
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox

CASE = discovery.case("granular-gas")


@pytest.mark.parametrize(
    "given",
    [{}, {"n": "500", "t0": "3/7", "diameter": "1/10", "density": "100"}, {"boundary": "walls"}],
)
def test_the_start_has_its_temperature_no_momentum_and_no_overlap(given):
    instance = CASE.at(**given)
    b = instance.scene.bodies
    size = (instance.p.n / instance.p.density) ** (1 / 3)
    assert [math.fsum(b.velocity[:, k]) for k in range(3)] == [0.0, 0.0, 0.0]
    assert np.sum(b.velocity**2) / (3 * (len(b) - 1)) == pytest.approx(instance.p.t0, rel=1e-9)
    apart = b.position[:, None] - b.position
    if not given.get("boundary"):
        apart -= size * np.round(apart / size)
    distance = np.linalg.norm(apart, axis=-1) + 10 * instance.p.diameter * np.eye(len(b))
    assert distance.min() > instance.p.diameter
    assert b.position.min() >= 0
    assert b.position.max() <= size


def test_the_seed_is_the_start():
    first, again, other = (CASE.at(seed=seed).scene.bodies for seed in ("5", "5", "6"))
    assert np.array_equal(first.position, again.position)
    assert np.array_equal(first.velocity, again.velocity)
    assert not np.any(first.velocity == other.velocity)


@pytest.mark.parametrize("restitution", ["1/5", "9/10", "1"])
def test_two_spheres_part_with_the_restitution_asked_for_across_the_edge_of_the_box(restitution):
    scene = CASE.at(n="2", density="1/20", restitution=restitution).scene
    size = scene.all(PeriodicBox)[0].size
    scene = scene.with_state(
        position=np.array([[0.7, 1, 1], [size - 0.7, 1, 1]]),
        velocity=np.array([[-1.0, 0, 0], [1.0, 0, 0]]),
    )
    step = 2.0**-14
    run, _ = ENGINE.run(
        Request(
            problem=Motion(scene, np.array([0.0, 4096 * step, 8192 * step])),
            method="gas",
            step=step,
        )
    )
    assert run.velocity[-1, 0, 0] == pytest.approx(
        float(CASE.at(restitution=restitution).p.restitution), rel=2e-2
    )
    assert np.all(run.velocity[-1, 0] == -run.velocity[-1, 1])


def test_the_image_that_a_position_names_does_not_matter():
    instance = CASE.at(n="50", duration="4")
    size = instance.scene.all(PeriodicBox)[0].size
    moved = instance.scene.bodies.position + size * np.random.default_rng(1).integers(
        -2, 3, (50, 3)
    )
    law = instance.scene.all(Contact)[0]
    assert (
        law.potential(instance.scene, moved[None] * 0.6, instance.scene.bodies.attitude[None]) > 0
    )
    steps = instance.motion.interval / np.ceil(instance.motion.interval / instance.scales.tau * 10)
    times = instance.times[:3]
    plain, other = (
        ENGINE.run(Request(problem=Motion(scene, times), method="gas", step=steps))[0]
        for scene in (instance.scene, instance.scene.with_state(position=moved))
    )
    assert np.abs(plain.velocity - other.velocity).max() < 1e-8


@pytest.mark.parametrize("given", [{"density": "2"}, {"n": "2", "density": "1/4"}])
def test_what_is_not_a_gas_is_refused(given):
    with pytest.raises(UsageError, match="density"):
        CASE.at(**given)


def test_other_engines_and_methods_refuse_a_periodic_box():
    motion = CASE.at().motion
    for name in ("mujoco", "pymunk", "rebound"):
        engine = discovery.engine(name)
        if engine.missing() is None:
            assert all(engine.unsupported(motion, method) for method in engine.methods), name
    assert [m.name for m in ENGINE.methods if ENGINE.unsupported(motion, m) is None] == ["gas"]


def test_methods_decide_about_a_crowd_without_a_list_of_its_pairs():
    motion = CASE.at(n="3000", boundary="walls").motion
    tracemalloc.start()
    able = [m.name for m in ENGINE.methods if ENGINE.unsupported(motion, m) is None]
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert able == ["gas"]
    assert most < 1000 * 3000, "bytes; a list of 4.5e6 pairs has a hundred times as many"


@pytest.mark.parametrize("name", NAMES)
def test_a_crowd_travels_in_every_symmetry_that_it_is_shown_in(name):
    instance = CASE.at(n=str(MOST_LISTED + 1), boundary="walls")
    sent = of(instance, name).applied(instance.motion)
    step = abs(sent.interval) / 2**12
    read = Request.unpacked(Request(problem=sent, method="gas", step=step).packed())
    assert np.array_equal(read.problem.scene.bodies.position, sent.scene.bodies.position)
    assert np.array_equal(read.problem.scene.bodies.radius, sent.scene.bodies.radius)
    assert len(sent.scene.bodies.shapes) == 1


def test_a_report_shows_the_first_of_many_bodies_and_how_many_there_are():
    nothing = SampledTruth(
        t=[],
        values={},
        radii={},
        sensitivity=[],
        scalars={},
        method="",
        witness="",
        until=0,
        reason="",
    )
    shown = json.loads(case_sheet(CASE.at(n="100"), nothing).scene)
    whole = json.loads(case_sheet(CASE.at(n=str(LISTED)), nothing).scene)
    assert len(whole["bodies"]) == LISTED
    assert all("position" in body for body in shown["bodies"][:LISTED] + whole["bodies"])
    assert shown["bodies"][LISTED:] == [f"and {100 - LISTED} more"]


def test_a_gas_that_falls_freely_is_that_without_gravity_seen_from_its_centre():
    # Until impacts amplify roundings: seen 7e-12 after 150 impacts.
    asked = {"contact": "rigid", "n": "200", "duration": "4", "samples": "4"}
    runs = []
    for gravity in ("0", "2"):
        problem = CASE.at(**asked, gravity=gravity).problem
        runs.append(ENGINE.run(Request(problem=problem, method="impacts"))[0])
    still, falls = runs
    t = still.t[:, None, None]
    pull = np.array([0.0, 0.0, -2.0])
    assert falls.velocity == pytest.approx(still.velocity + pull * t, abs=1e-9)
    assert falls.position == pytest.approx(still.position + pull * t**2 / 2, abs=1e-9)
    changed = np.abs(still.velocity[-1] - still.velocity[0]).max(axis=1) > 1e-3
    assert np.count_nonzero(changed) > 100


@pytest.mark.parametrize(
    "given",
    [
        {"gravity": "1"},
        {"gravity": "1", "boundary": "walls"},
        {"gravity": "1", "contact": "rigid", "boundary": "walls"},
    ],
)
def test_gravity_on_a_gas_that_something_holds_up_is_refused(given):
    with pytest.raises(UsageError, match=r"parameter gravity: got 1 m/s\^2 .* falls freely"):
        CASE.at(**given)


def test_without_gravity_the_scene_has_none():
    assert "uniform_gravity" not in CASE.at().scene.features
    falling = CASE.at(contact="rigid", gravity="2").scene
    assert "uniform_gravity" in falling.features
