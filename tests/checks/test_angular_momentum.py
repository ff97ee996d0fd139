"""A right program keeps L to round-off however many steps a flight takes, and a lever arm that is
off by a millionth is seen.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import torque_reason
from refdem.core.check import CompletedRun, Subject
from refdem.core.engine import Method
from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.variant import Variant
from refdem.planning.in_process import record_of, task_of, truth_of

CHECK = discovery.check("angular-momentum")
METHOD = Method(
    name="symplectic-euler",
    summary="",
    control="step",
    order=1,
    conserves=frozenset({"momentum", "angular-momentum"}),
)
SPHERES = {"damping": "0", "angle": "1/2", "samples": "8"}


def stepped(instance, stride, *, lever=0.0):
    """The run of symplectic Euler in plain doubles: r += h v, then v += h f/m, with f = k d n.

    `lever` is the part of the second sphere's velocity across x that every step in contact adds, as
    a force off the line of centres does.
    """
    scene = instance.scene
    (contact,) = scene.elements
    # Both spheres touch at the start.
    reach = float(np.linalg.norm(scene.bodies.position[1] - scene.bodies.position[0]))
    mass = scene.bodies.mass
    position = scene.bodies.position.copy()
    velocity = scene.bodies.velocity.copy()
    h = (instance.times[1] - instance.times[0]) / stride
    positions = [position.copy()]
    velocities = [velocity.copy()]
    for _ in instance.times[1:]:
        for _ in range(stride):
            position += h * velocity
            branch = position[1] - position[0]
            distance = float(np.sqrt(branch @ branch))
            if distance < reach:
                force = contact.stiffness * (reach - distance) * branch / distance
                velocity[0] -= h / mass[0] * force
                velocity[1] += h / mass[1] * force
                velocity[1, 1] *= 1.0 + lever
        positions.append(position.copy())
        velocities.append(velocity.copy())
    count = len(instance.times)
    attitude = np.repeat(scene.bodies.attitude[None], count, axis=0)
    return Trajectory(
        t=instance.times,
        position=np.array(positions),
        velocity=np.array(velocities),
        attitude=attitude,
        omega=np.zeros((count, 2, 3)),
    )


def outcomes(stride, **fault):
    """What the check says of that run, by quantity."""
    instance = discovery.case("two-spheres").at(**SPHERES)
    level = float(instance.times[1] - instance.times[0]) / stride
    subject = Subject(instance, METHOD, (level,), truth_of(instance))
    run = stepped(instance, stride, **fault)
    found = CHECK.judge(subject, {Variant(level): CompletedRun(run, Cost(seconds=0.0))})
    return {finding.quantity: finding.outcome for finding in found}


@pytest.mark.parametrize("stride", [64, 256, 1024, 8192])
def test_a_long_flight_rounds_alike_at_every_step_and_is_no_loss(stride):
    assert set(outcomes(stride).values()) == {"pass"}


def test_a_force_a_little_aside_of_the_line_of_centres_is_seen():
    assert "fail" in outcomes(64, lever=1e-9).values()


def break_with_rounded_places(stride, part):
    """What the check says of a break whose places are off by the part of u |r| that each of the
    steps so far may have added, all of them so that they change L alike.
    """
    instance = discovery.case("billiard-break").at(rows="3", distance="5/4")
    reference = discovery.engine("reference")
    request = Request(problem=instance.problem, method="impacts", step=None)
    run = reference.run(request)[0]
    steps = stride * np.arange(len(run.t))[:, None, None]
    speed = np.linalg.norm(run.velocity, axis=-1, keepdims=True)
    distance = np.linalg.norm(run.position, axis=-1, keepdims=True)
    across = np.cross(run.velocity, [0.0, 0.0, 1.0]) / np.where(speed > 0, speed, 1.0)
    off = part * steps * METHOD.round_off * distance * across
    rounded = replace(run, position=run.position + off)
    level = float(instance.times[1] - instance.times[0]) / stride
    subject = Subject(instance, METHOD, (level,), truth_of(instance))
    (finding,) = CHECK.judge(subject, {Variant(level): CompletedRun(rounded, Cost(seconds=0.0))})
    return finding.outcome


def test_bodies_that_are_hit_from_rest_are_rounded_where_they_fly_to():
    """The cue ball has all of m |r| |v| at the start; the rack has several times it at last."""
    assert break_with_rounded_places(4096, 0.5) == "pass"
    assert break_with_rounded_places(4096, 20.0) == "fail"


def sentences(engine, case, **given):
    """What the check says, a sentence a method, of a run at two levels of refinement or more."""
    instance = discovery.case(case).at(**given)
    found = {}
    for method in engine.chosen_methods():
        if method.answers != instance.problem.kind or engine.unsupported(instance.problem, method):
            continue
        task = task_of(engine, method.name, instance, truth_of(instance), 3, ("angular-momentum",))
        for finding in record_of(task).findings:
            found[method.name] = finding.sentence
    return found


def test_what_a_method_does_not_claim_is_judged_by_physics_beside_its_claim():
    """Chipmunk's correction of the overlap moves discs aside of their line of centres."""
    rough = {"friction": "1/4", "spins": "0,0,1,0,0,2"}
    (sentence,) = sentences(discovery.engine("pymunk"), "hard-spheres", **rough).values()
    assert "No torque acts from outside, and yet it changes by" in sentence
    assert "the method does not claim to keep it" in sentence


def test_a_law_that_changes_the_total_says_so_and_one_that_does_not_is_silent():
    rubbing = {"damping": "1", "friction": "1/4", "angle": "1/2", "tangential_stiffness": "0"}
    reference = discovery.engine("reference")
    changed = sentences(reference, "two-spheres", **rubbing, branch="R")
    kept = sentences(reference, "two-spheres", **rubbing)
    assert all("a property of the law" in sentence for sentence in changed.values())
    assert not any("property of the law" in sentence for sentence in kept.values())
    assert not any("No torque" in sentence for sentence in kept.values())


def test_the_lever_of_the_torque_decides_what_the_law_does_to_the_total():
    """With slip at R and torque at R - d/2 the total stays; one lever R for both changes it."""
    rubbing = {"damping": "1", "friction": "1/4", "angle": "1/2", "tangential_stiffness": "96"}
    instance = discovery.case("two-spheres").at(**rubbing, branch="slip-R")
    assert torque_reason(instance.scene) is None
    reference = discovery.engine("reference")
    kept = sentences(reference, "two-spheres", **rubbing, branch="slip-R")
    assert kept.keys() == {"contact-events", "rk4", "velocity-verlet"}
    assert not any("property of the law" in sentence for sentence in kept.values())


def test_all_spheres_of_a_law_that_changes_the_total_are_compared_with_truth():
    """Three of them, where the check knew of two and broke."""
    given = {"member": "three-spheres", "branch": "R", "friction": "3/10", "samples": "8"}
    instance = discovery.case("impact-benchmarks").at(**given)
    reference = discovery.engine("reference")
    truth = truth_of(instance)
    task = task_of(reference, "velocity-verlet", instance, truth, 1, ["angular-momentum"])
    (found,) = record_of(task).findings
    assert (found.quantity, found.outcome) == ("law", "pass"), found.sentence
