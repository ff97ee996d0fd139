"""What an adapter makes of other numbers so that a law always holds is declared, and no check of
that law applies to it.
"""

import re
from pathlib import Path

import pytest

import refdem
from refdem.core import discovery
from refdem.core.check import Subject
from refdem.core.refinement import levels

ROOT = Path(refdem.__file__).parent
NORMALISED = re.compile(r"/ np\.linalg\.norm\((turned|states|out)\[|np\.cos\(half_angle")
"""How a source makes unit quaternions of what a kernel or an engine has written."""


def subject(engine, method, case, **given):
    instance = discovery.case(case).at(**given)
    found = discovery.engine(engine).method(method)
    steps = levels(instance, found, 3, 3e5)
    return Subject(instance=instance, method=found, levels=steps, truth=None)


@pytest.mark.parametrize(
    ("check", "engine", "method", "case"),
    [
        ("quaternion-norm", "rebound", "bs", "free-rigid-body"),
        ("quaternion-norm", "reference", "spinning-top", "heavy-top"),
        ("quaternion-norm", "reference", "dissipating-body", "dissipating-body"),
        ("constraint", "mujoco", "euler", "pendulum"),
    ],
)
def test_a_check_that_could_not_fail_does_not_apply(check, engine, method, case):
    assert discovery.check(check).left_out(subject(engine, method, case)) is not None


@pytest.mark.parametrize(
    ("check", "engine", "method", "case"),
    [
        ("quaternion-norm", "mujoco", "euler", "free-rigid-body"),
        ("quaternion-norm", "reference", "exact-free-body", "free-rigid-body"),
        ("constraint", "pymunk", "semi-implicit-euler", "pendulum"),
        ("constraint", "reference", "rattle", "pendulum"),
    ],
)
def test_a_check_that_can_fail_applies(check, engine, method, case):
    assert discovery.check(check).left_out(subject(engine, method, case)) is None


def test_attitudes_of_pymunk_are_made_of_angles():
    assert "attitude" in discovery.engine("pymunk").method("semi-implicit-euler").derived


def test_every_source_that_makes_unit_quaternions_says_so():
    sources = [*ROOT.glob("solvers/*.py"), *ROOT.glob("engines/*/*.py")]
    making = [path for path in sources if NORMALISED.search(path.read_text())]
    assert len(making) >= 5
    for path in making:
        if path.parent.parent.name == "engines":
            beside = path.parent.glob("*.py")
        else:
            beside = [path]
        assert any('"attitude":' in other.read_text() for other in beside), (
            f"{path.name} makes unit quaternions and declares nothing"
        )


def test_work_that_is_told_as_what_the_energy_lacks_is_no_evidence_of_a_balance():
    engine = discovery.engine("reference")
    assert "dissipated_work" in engine.method("dissipating-body").derived
