"""Every known fault is killed by the quantity named for it, and nothing is said against the engine
without any.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.finding import Finding, Record
from refdem.errors import UsageError
from refdem.faults.catalogue import chosen, faults
from refdem.faults.change import of_elements, scaled
from refdem.faults.fault import Fault
from refdem.faults.settings import SETTINGS
from refdem.faults.transparent import Transparent
from refdem.kills.trials import ORDERS, FaultTrial, engine_of
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene.elements.spring import Spring

SEED = 1
SLOW = (
    ("chaotic-chain", "suzuki"),
    ("cycle-and-drive", "euler"),
    ("middle", "euler"),
    ("mixing", "euler"),
)
"""Long settings and the methods of most steps in them, which are judged there by the checks that
the setting is for: all checks judge these methods in other settings of the case, and other methods
in these settings.
"""
LEVELS = 3
"""Refinement levels of the correct engine; an order needs as many."""
LEVELS_OF_SLOW = 2
"""Those of SLOW: the third one takes more than half of their time, and the checks that judge them
there find no order.
"""


@pytest.fixture(scope="module")
def trial():
    return FaultTrial(seeds=1, whole=False)


@pytest.mark.parametrize("fault", faults(), ids=lambda fault: fault.name)
def test_a_fault_is_killed_by_the_quantity_named_for_it(trial, fault):
    kill = trial.kill(fault, SEED)
    assert kill.killed, f"{kill.label}: {kill.check}/{kill.quantity}: {kill.sentence}"


def judging_checks(setting, method):
    """The checks by which the correct engine is judged; none for all."""
    if (setting, method) not in SLOW:
        return ()
    return tuple(sorted({fault.sees[0] for fault in faults() if setting in fault.on}))


@pytest.mark.parametrize("setting", SETTINGS)
def test_nothing_is_said_against_the_correct_engine(trial, setting):
    instance, truth = trial.instance(setting, SEED)
    for method in SETTINGS[setting].methods:
        checks = judging_checks(setting, method)
        levels = LEVELS_OF_SLOW if (setting, method) in SLOW else LEVELS
        record = record_of(task_of(engine_of(setting), method, instance, truth, levels, checks))
        assert record.findings
        assert [
            f"{record.id(f)}: {f.sentence}"
            for f in record.findings
            if f.outcome in ("fail", "error")
        ] == []


@pytest.mark.parametrize(("setting", "method"), SLOW)
def test_a_slow_method_is_judged_by_all_checks_in_another_setting_of_the_case(setting, method):
    case = SETTINGS[setting].case
    methods = [
        (name, judged)
        for name, other in SETTINGS.items()
        if other.case == case
        for judged in other.methods
        if (name, judged) not in SLOW
    ]
    assert method in {judged for name, judged in methods if name != setting}
    assert setting in {name for name, _ in methods}
    checks = judging_checks(setting, method)
    assert checks
    assert not set(checks) & set(ORDERS)


def test_there_are_faults_of_many_kinds_with_names_of_their_own():
    every = faults()
    assert len(every) >= 60
    assert len({fault.name for fault in every}) == len(every)
    assert len({fault.kind for fault in every}) >= 10
    assert {setting for fault in every for setting in fault.on} <= set(SETTINGS)


def test_parameters_are_the_same_for_the_same_seed_and_others_for_another():
    for name, setting in SETTINGS.items():
        assert setting.parameters(name, 3) == setting.parameters(name, 3)
        assert setting.parameters(name, 3) != setting.parameters(name, 4)


def test_a_fault_that_changes_nothing_survives():
    idle = Fault(
        name="idle",
        kind="none",
        sentence="Nothing.",
        on=("oscillator",),
        sees=("error", "x"),
        before=lambda request: request,
    )
    matrix = FaultTrial(seeds=1, chosen=(idle,)).matrix()
    assert [kill.fault for kill in matrix.survivors()] == ["idle"]
    assert "error" in matrix.idle()
    assert matrix.alarms == ()


def test_a_fault_seen_by_another_quantity_alone_survives():
    (late,) = chosen(["rod-force-late"])
    moved = Fault(
        name="moved",
        kind="none",
        sentence="",
        on=late.on,
        sees=("constraint", "length"),
        inside=late.inside,
    )
    kill = FaultTrial(seeds=1, chosen=(moved,)).kill(moved, 0)
    assert not kill.killed
    assert "error/rod_force" in kill.also


def test_an_engine_that_is_wrong_by_itself_alarms(monkeypatch):
    broken = Fault(
        name="broken",
        kind="none",
        sentence="",
        on=("oscillator",),
        sees=("error", "x"),
        after=chosen(["sample-late"])[0].after,
    )
    engine = broken.carrier()
    matrix = FaultTrial(seeds=1, engine=engine, chosen=(broken,)).matrix()
    assert any("error/x" in alarm.id for alarm in matrix.alarms)


def _other_cover(request, run):
    """Every third attitude by the other quaternion of the same rotation."""
    return replace(
        run, attitude=run.attitude * np.where(np.arange(len(run.t)) % 3, 1.0, -1.0)[:, None, None]
    )


@pytest.mark.parametrize(
    ("setting", "method"), [("tumbler", "rk4"), ("tumbling-spheres", "verlet"), ("top", "verlet")]
)
def test_the_double_cover_of_rotations_is_no_fault(trial, setting, method):
    flips = Fault(
        name="flips",
        kind="none",
        sentence="",
        on=(setting,),
        sees=("error", "attitude"),
        after=_other_cover,
    )
    record = record_of(task_of(flips.carrier(), method, *trial.instance(setting, SEED), 3))
    assert [
        f"{record.id(f)}: {f.sentence}" for f in record.findings if f.outcome in ("fail", "error")
    ] == []


def test_faults_before_and_after_are_seen_in_the_reference_too():
    matrix = FaultTrial(
        seeds=1,
        engine=discovery.engine("reference"),
        chosen=chosen(["grams", "sample-late", "velocity-not-held"]),
    ).matrix()
    assert [(kill.fault, kill.killed) for kill in matrix.kills] == [
        ("sample-late", True),
        ("grams", True),
    ]
    assert matrix.alarms == ()


def test_an_unknown_fault_is_named_with_the_nearest():
    with pytest.raises(UsageError, match="no-gyroscopic-term"):
        chosen(["no-gyroscopic-terms"])


def test_a_fault_acts_in_exactly_one_way():
    with pytest.raises(ValueError, match="exactly one"):
        Fault(
            name="both",
            kind="none",
            sentence="",
            on=("swing",),
            sees=("error", "x"),
            before=lambda r: r,
            after=lambda r, t: t,
        )


def test_truth_is_withheld_where_a_setting_says_so(trial):
    assert trial.instance("unproved", 0)[1].until == 0
    assert trial.instance("cycle", 0)[1].until == 25


@pytest.mark.parametrize(("size", "levels"), [(1.5, 1), (1.0, 5)])
def test_a_fault_is_refined_no_further_than_it_takes_to_kill_it(size, levels):
    asked = []

    def before(request):
        asked.append(request.step)
        return of_elements(Spring, stiffness=scaled(size))(request)

    fault = Fault(
        name="spring",
        kind="none",
        sentence="",
        on=("oscillator",),
        sees=("error", "x"),
        before=before,
        levels=5,
    )
    assert FaultTrial(seeds=1, whole=False).kill(fault, 1).killed == (size > 1)
    assert len(asked) == len(set(asked)) == levels


def test_records_and_findings_are_those_of_a_campaign():
    instance = discovery.case("harmonic-oscillator").at(duration="4", samples="16")
    record = record_of(
        task_of(Transparent(), "verlet", instance, truth_of(instance), 3, ("error",))
    )
    assert isinstance(record, Record)
    assert {type(finding) for finding in record.findings} == {Finding}
    assert {finding.check for finding in record.findings} == {"error"}
