"""Parameter sets drawn at random at which a scale, a bound or a closed form was once wrong, judged
in the reference.
"""

import pytest

from refdem.core import discovery
from refdem.errors import UsageError
from refdem.planning import in_process, plan
from refdem.planning.specification import Specification

SPECIFICATION = Specification(name="held out", case=[], levels=3, most_steps=3e4)


def outcomes(case, given, checks=()):
    """Every finding that is not a pass, of the methods that run the scene."""
    instance = discovery.case(case).at(**given)
    truth = in_process.truth_of(instance)
    assert truth.reason == ""
    tasks = plan.tasks(SPECIFICATION, instance, (), discovery.engine("reference"), truth, "")
    runs = [in_process.record_of(task) for task in tasks if task.unsupported is None]
    assert runs
    found = [f for record in runs for f in record.findings if not checks or f.check in checks]
    assert found
    return [
        f"{f.check} {f.quantity}: {f.sentence}" for f in found if f.outcome in ("fail", "error")
    ]


@pytest.mark.parametrize(
    ("case", "given"),
    [
        ("moments-of-inertia", {"density": "703/500", "a": "439/1000", "c": "3000"}),
        ("quaternions", {"vector": "-1/2,1,2"}),
        ("quaternions", {"omega": "0,0,0", "vector": "0,0,0"}),
        ("two-spheres", {"damping": "1", "friction": "1", "samples": "16"}),
        (
            "two-spheres",
            {
                **{
                    "masses": "0.785,0.853",
                    "radii": "0.627,0.558",
                    "stiffness": "104",
                    "damping": "1.08",
                },
                **{
                    "closing_speed": "1.39",
                    "angle": "0.365",
                    "duration": "0.2508",
                    "samples": "16",
                },
            },
        ),
        (
            "two-spheres",
            {"friction": "3", "damping": "0.663", "closing_speed": "0.7", "samples": "16"},
        ),
    ],
)
def test_nothing_fails_where_it_once_did(case, given):
    assert outcomes(case, given) == []


def test_rounding_of_a_rate_that_starts_at_zero_is_no_flip():
    given = {
        "omega_body": "0.9,1.1,0",
        "attitude": "-4/125,0,1/1000,0",
        "inertia": "1,3,2",
        "samples": "7",
        "duration": "1.407",
    }
    assert outcomes("free-rigid-body", given, ("flips",)) == []


@pytest.mark.parametrize(
    ("case", "given"),
    [
        (
            "two-body-orbit",
            {
                "eccentricity": "0.999999",
                "gm": "10",
                "stiffness": "100",
                "samples": "7",
                "duration": "0.005657",
            },
        ),
        (
            "two-spheres",
            {
                "damping": "1",
                "spins": ",".join(["2.293"] * 6),
                "masses": "2,0.1",
                "samples": "2",
                "duration": "3e-5",
            },
        ),
    ],
)
def test_a_start_far_beyond_the_scale_is_rounded_as_it_is_rotated(case, given):
    assert outcomes(case, given, ("symmetry",)) == []


def test_a_contact_that_slips_to_its_end_is_released_in_the_same_step_wherever_it_stands():
    given = {"member": "co-4", "samples": "16", "duration": "2.441e-05"}
    assert outcomes("impact-benchmarks", given, ("symmetry",)) == []


def test_a_cluster_that_needs_more_bits_to_know_its_axis_is_certified():
    places = "1,3963/1000,0,0,1,0,7/10,1/3,1000,-1,-0.0005,0"
    truth = in_process.truth_of(
        discovery.case("rigid-cluster").at(positions=places, samples="2", duration="0.2619")
    )
    assert truth.reason == ""
    assert "Jacobi" in truth.method


@pytest.mark.parametrize(
    ("case", "given", "parameter"),
    [
        ("heavy-top", {"inertia": "1/6,1/4"}, "inertia"),
        ("heavy-top", {"inertia": "1/2,250"}, "inertia"),
        ("pendulum-wheel-mass", {"wheel_radius": "0"}, "wheel_inertia"),
    ],
)
def test_values_that_do_not_go_together_are_refused_by_the_name_of_a_parameter(
    case, given, parameter
):
    with pytest.raises(UsageError, match=f"parameter {parameter}: "):
        discovery.case(case).at(**given)


def test_a_wheel_of_no_size_without_inertia_is_accepted():
    assert discovery.case("pendulum-wheel-mass").at(
        wheel_radius="0", wheel_inertia="0"
    ).scene.bodies.mass.tolist() == [1.0, 1.5]
