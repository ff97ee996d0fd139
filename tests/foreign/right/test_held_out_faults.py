"""Faults in right programs that show in space alone or on later bodies, named by probes."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from refdem.engines.external import load
from refdem.smoke.battery import smoke
from tests.foreign.right.programs import HERE, PROGRAMS

VERLET = ("soft", "verlet-predicted")
CLOSING = "*closing = 0;\n    for (int k = 0; k < {};"
FALL = "b->v[k] += h * gravity[k];"
PROBED = {
    "the speed of drag is that in a plane": (
        (*VERLET, "drag in space: velocity"),
        ("forces.h", "* size_of(velocity)", "* hypot(velocity[0], velocity[1])"),
    ),
    "the closing speed has two components": (
        (*VERLET, "damped knock in space: velocity"),
        ("forces.h", CLOSING.format(3), CLOSING.format(2)),
    ),
    "only two bodies fall along z": (
        ("turning", "splitting", "three points fall in space: velocity"),
        ("turning.c", FALL, f"if (i < 2 || k < 2) {FALL}"),
    ),
    "only one sphere falls": (
        ("rigid", "event-driven", "three spheres fall: velocity"),
        ("rigid.c", f"{FALL}\n        }}\n        turn", f"if (b == body) {FALL} }} turn"),
    ),
}


def planted(folder: Path, name: str, method: str, change: tuple[str, str, str]):
    """The engine of a right program with one method and one change of its sources."""
    sources = folder / "right"
    shutil.copytree(HERE, sources, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    shutil.copytree(HERE.parent / "c", folder / "c")
    file, text, other = change
    right = (sources / file).read_text()
    assert right.count(text) == 1
    (sources / file).write_text(right.replace(text, other))
    (program,) = [program for program in PROGRAMS if program.name == name]
    (claim,) = [claim for claim in program.methods if claim["name"] == method]
    return load(replace(program, methods=(claim,)).built(folder, sources))


@pytest.mark.parametrize("name", PROBED)
def test_a_probe_names_the_force_that_is_wrong_in_space_or_on_later_bodies(name, tmp_path):
    (program, method, seen), change = PROBED[name]
    findings = smoke(planted(tmp_path, program, method, change))
    failed = {finding.quantity for finding in findings if finding.outcome == "fail"}
    assert seen in failed
