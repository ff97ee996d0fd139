"""What a gate runs of a program that names no cases shows every fault of the catalogue that the
program can have: said of each of the programs in tests/foreign.

A program can have a fault if it supports a setting on which the fault acts. The fault is planted in
the transparent engine, which runs the instances that the gate of that program has.
"""

from functools import cache
from pathlib import Path

import pytest

from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.engines.external import load
from refdem.faults.catalogue import chosen, faults
from refdem.gate.gate import supported
from refdem.kills.trials import ORDERS, WRONG, instance_at
from refdem.planning.in_process import record_of, task_of, truth_of
from tests.foreign.right.programs import PROGRAMS

FOREIGN = Path(__file__).parents[1] / "foreign"
SEED = 1
LEVELS = 3
"""One less than a gate has, unless its refdem.toml has others: what shows at these shows there."""
CROWDS = ("granular-gas",)
"""Cases of so many bodies that a step in plain Python takes too long."""
RIGHT = {program.name: program for program in PROGRAMS if "-" not in program.name}
"""The programs of tests/foreign/right, one of each source: their variants support the same."""
OTHERS = ("c", "cpp", "fortran", "solids", "staggered", "tangent")


@pytest.fixture(scope="module", params=[*RIGHT, *OTHERS])
def program(request, tmp_path_factory):
    """The engine that a refdem.toml describes; its program need not be built."""
    name = request.param
    if name in OTHERS:
        return load(FOREIGN / name / "refdem.toml")
    path = tmp_path_factory.mktemp(name) / "refdem.toml"
    path.write_text(RIGHT[name].description())
    return load(path)


def can_run(engine: Engine, problem):
    """True if some method of the engine supports the problem."""
    return any(engine.unsupported(problem, method) is None for method in engine.methods)


def possible_faults(engine: Engine):
    """The faults that the engine can have: those of derivatives only if it differentiates."""
    has_derivatives = any(method.differentiates for method in engine.methods)
    possible = []
    for fault in faults():
        if fault.sees[0] == "gradient" and not has_derivatives:
            continue
        if any(can_run(engine, instance_at(name, SEED).problem) for name in fault.on):
            possible.append(fault)
    return possible


@cache
def instance_of(case, given):
    """An instance and its truth, both shared by all programs."""
    instance = discovery.case(case).at(**dict(given))
    return instance, truth_of(instance)


@cache
def shows(name, case, given, checks):
    """True if some finding of these checks (none: of all) is wrong in an engine with the fault.

    Most faults show at one level. What the checks of ORDERS say of one level does not count: more
    levels may say otherwise.
    """
    (fault,) = chosen([name])
    instance, truth = instance_of(case, given)
    carrier = fault.carrier()
    if carrier.unsupported(instance.problem, carrier.method(fault.method)) is not None:
        return False
    # Runs of one level are used again with more of them.
    known = {}
    if not set(checks) & set(ORDERS):
        task = task_of(carrier, fault.method, instance, truth, 1, checks)
        wrong = wrong_checks(record_of(task, known))
        if wrong - set(ORDERS):
            return True
    task = task_of(carrier, fault.method, instance, truth, LEVELS, checks)
    return bool(wrong_checks(record_of(task, known)))


def wrong_checks(record):
    """The checks that find something wrong in a record."""
    return {finding.check for finding in record.findings if finding.outcome in WRONG}


def is_seen(fault, entries):
    """True if some entry shows the fault; the likeliest are tried first, by the check that is named
    for the fault.
    """
    cases = {instance_at(name, SEED).case.id for name in fault.on}
    tried = [(entry.id, tuple(sorted(entry.set.items()))) for entry in entries]
    tried = [entry for entry in tried if entry[0] not in CROWDS]
    likely = [entry for entry in reversed(tried) if entry[0] in cases]
    others = [entry for entry in tried if entry[0] not in cases]
    check, _ = fault.sees
    named = (check,)
    if check == "run":
        named = ("error",)
    asked = [(*entry, named) for entry in likely]
    asked += [(*entry, ()) for entry in (*likely, *others)]
    return any(shows(fault.name, *question) for question in asked)


def survivors(engine: Engine, entries):
    """The names of the faults that the engine can have and that no entry shows."""
    return [fault.name for fault in possible_faults(engine) if not is_seen(fault, entries)]


def test_the_gate_of_a_program_shows_every_fault_that_it_can_have(program):
    assert survivors(program, supported(program)) == []


def test_every_program_of_motions_can_have_many_faults(program):
    is_of_motions = program.name != "solids-c"
    assert (len(possible_faults(program)) >= 25) == is_of_motions


def test_defaults_alone_hide_a_fault():
    """Spheres that are alike may be taken for each other."""
    engine = load(FOREIGN / "staggered" / "refdem.toml")
    every = supported(engine)
    defaults = [entry for entry in every if not entry.set]
    (swapped,) = chosen(["masses-swapped"])
    assert not is_seen(swapped, defaults)
    assert is_seen(swapped, every)
