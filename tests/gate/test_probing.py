"""A gate that names no cases runs the probes of `refdem smoke` as well, which see what no case of
the catalogue shows.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

from refdem.faults.transparent import Transparent
from refdem.gate.probing import probe_records
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact

SKIN = 0.25
"""Distance [m] between surfaces up to which spheres are in the list that is made at the start."""
FEW = 10
"""Bodies, in plain Python."""
CASES = 'cases = ["harmonic-oscillator"]\n'


class Verlet(Transparent):
    """Velocity Verlet of a few bodies."""

    methods = tuple(method for method in Transparent.methods if method.name == "verlet")

    def unsupported_motion(self, problem, method):
        if len(problem.scene.bodies.mass) > FEW:
            return f"more than {FEW} bodies"
        return super().unsupported_motion(problem, method)


class NeverRenewed(Verlet):
    """Spheres of a list that is made at the start and never again."""

    def run(self, request):
        scene = request.problem.scene
        if scene.all(Contact) and len(scene.bodies.mass) == 2 and gap(scene) > SKIN:
            kept = [element for element in scene.elements if not isinstance(element, Contact)]
            alone = Scene(scene.bodies, tuple(kept))
            request = replace(request, problem=replace(request.problem, scene=alone))
        return super().run(request)


def gap(scene):
    """The distance [m] between the surfaces of two spheres."""
    bodies = scene.bodies
    return np.linalg.norm(bodies.position[0] - bodies.position[1]) - bodies.radius.sum()


def failed(engine):
    """The quantities of the probes that fail."""
    (record,) = probe_records(engine)
    return {finding.quantity for finding in record.findings if finding.outcome != "pass"}


@pytest.fixture(scope="module")
def sound():
    (record,) = probe_records(Verlet())
    return record


def test_a_correct_engine_passes_every_probe_and_refusals_are_left_out(sound):
    assert {finding.outcome for finding in sound.findings} == {"pass"}
    assert len({finding.quantity.partition(":")[0] for finding in sound.findings}) > 20


def test_a_list_that_is_never_renewed_is_seen_by_the_probes():
    assert failed(NeverRenewed()) >= {"meeting later: position", "meeting later: velocity"}


def names_of_baseline(program):
    """The ids of the accepted findings."""
    lines = (program.folder / "refdem-baseline.jsonl").read_text().splitlines()
    return {json.loads(line).get("id", "") for line in lines}


def leave_out_cases(program):
    """Names no cases in the refdem.toml, and refuses scenes without a spring."""
    toml = program.folder / "refdem.toml"
    assert CASES in toml.read_text()
    toml.write_text(toml.read_text().replace(CASES, ""))
    refusal = 'if not request["scene"]["elements"]:\n    sys.exit(77)\nbody, spring ='
    program.spoil("body, spring =", refusal)


def test_a_gate_without_cases_runs_the_probes_and_one_with_cases_does_not(program):
    program.bless()
    assert not any(name.startswith("smoke/") for name in names_of_baseline(program))
    leave_out_cases(program)
    program.bless()
    assert "smoke/spring/all/smoke/spring: position" in names_of_baseline(program)
    assert program.gate().returncode == 0


def test_a_probe_that_fails_closes_the_gate_and_is_repeated_by_smoke(program):
    leave_out_cases(program)
    program.bless()
    program.spoil("x += h * v", "x -= h * v")
    done = program.gate("--markdown", "gate.md")
    assert done.returncode == 1
    assert "smoke/spring/all/smoke/spring: position" in done.stdout
    assert "refdem smoke refdem.toml" in (program.folder / "gate.md").read_text()
