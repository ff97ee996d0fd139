"""Energy where it is lost, where springs hold some of it, and where the zero of a potential is
anybody's choice.
"""

from dataclasses import replace

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import energy_scale
from refdem.core.check import Subject
from refdem.core.engine import Method
from refdem.core.judgement import worst
from refdem.faults.change import of_elements, scaled
from refdem.faults.transparent import Transparent
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring


class Spoiled(Transparent):
    """The transparent engine with its trajectory changed."""

    def __init__(self, change):
        super().__init__()
        self.change = change

    def run(self, request):
        run, cost = super().run(request)
        return self.change(run), cost


def findings(case, change=lambda run: run, **given):
    instance = discovery.case(case).at(**given)
    record = record_of(
        task_of(Spoiled(change), "verlet", instance, truth_of(instance), 3, ("energy",))
    )
    return {finding.quantity: finding.outcome for finding in record.findings}


def negative_work(run):
    return replace(
        run, channels=run.channels | {"dissipated_work": -run.channels["dissipated_work"]}
    )


def test_work_that_comes_back_from_friction_is_a_fault_even_if_the_balance_holds():
    assert findings("coulomb-oscillator")["dissipation"] == "pass"
    assert findings("coulomb-oscillator", negative_work)["dissipation"] == "fail"


def of_reference(method, change=lambda run: run, case="driven-oscillator", **given):
    """Findings on energy of a method of the reference, its trajectory changed."""
    engine = discovery.engine("reference")

    class Changed(type(engine)):
        def run(self, request):
            run, cost = super().run(request)
            return change(run), cost

    instance = discovery.case(case).at(**given)
    record = record_of(task_of(Changed(), method, instance, truth_of(instance), 3, ("energy",)))
    return {finding.quantity: finding.outcome for finding in record.findings}


def test_what_a_drive_brings_in_is_counted_and_may_come_and_go():
    found = of_reference("taylor-oscillator", x0="0", f0="2", delta="0")
    assert found == {"balance": "pass"}
    scaled = {"dissipated_work": 1 + 1e-9}
    wrong = of_reference(
        "taylor-oscillator",
        lambda run: replace(
            run, channels={name: run.channels[name] * factor for name, factor in scaled.items()}
        ),
        x0="0",
        f0="2",
        delta="0",
    )
    assert wrong == {"balance": "fail"}


def test_a_closed_form_that_does_not_count_what_a_drive_brings_in_is_not_judged_by_it():
    assert "pass" not in of_reference("exact-linear").values()
    assert "undecided" not in of_reference("exact-linear").values()


DRIVEN = [
    ("driven-oscillator", {}),
    ("driven-oscillator", {"delta": "0", "drive": "3/4", "f0": "2"}),
    ("driven-oscillator", {"x0": "0", "v0": "1", "drive": "5/4", "mass": "3"}),
    ("driven-duffing", {"samples": "64", "duration": "12"}),
    ("quadratic-response", {"eps": "1/16"}),
    ("van-der-pol", {"samples": "128"}),
    ("viscous-oscillator", {}),
    ("whirling-shaft", {}),
]
"""Settings with a drive, or with a dashpot, which may bring energy in."""


def driven(case, given, change=lambda request: request, method="rk4"):
    """Findings on energy of a run whose request is changed and which does not report work."""

    class Changed(Transparent):
        def run(self, request):
            return super().run(change(request))

    instance = discovery.case(case).at(**given)
    record = record_of(task_of(Changed(), method, instance, truth_of(instance), 4, ("energy",)))
    return {finding.quantity: finding for finding in record.findings}


@pytest.mark.parametrize(("case", "given"), DRIVEN)
def test_the_work_of_a_drive_is_integrated_between_samples_where_a_run_does_not_report_it(
    case, given
):
    found = driven(case, given)
    assert found["finest"].outcome == "pass"
    assert "integrated between samples" in found["finest"].sentence


SPOILED = {
    "a drive two per cent too strong": of_elements(Force, amplitude=scaled(1.02)),
    "a drive that is late by 0.02": of_elements(Force, phase=lambda phase: phase - 0.02),
    "damping two per cent too small": of_elements(
        Dashpot, damping=scaled(0.98), van_der_pol=scaled(0.98)
    ),
    "damping of the other sign": of_elements(Dashpot, damping=scaled(-1), van_der_pol=scaled(-1)),
    "a spring two per cent too stiff": of_elements(Spring, stiffness=scaled(1.02)),
}


@pytest.mark.parametrize("name", SPOILED)
@pytest.mark.parametrize(("case", "given"), DRIVEN)
def test_work_that_the_declared_forces_did_not_do_is_a_fault(case, given, name):
    scene = discovery.case(case).at(**given).scene
    changed = {"drive": Force, "damping": Dashpot, "spring": Spring}
    kind = next(kind for word, kind in changed.items() if word in name)
    has_any = bool(scene.all(kind))
    is_damped = any(pot.damping or pot.van_der_pol for pot in scene.all(Dashpot))
    acts = has_any and (kind is not Dashpot or is_damped)
    expected = "pass"
    if acts:
        expected = "fail"
    assert driven(case, given, SPOILED[name])["finest"].outcome == expected


def test_samples_too_far_apart_to_integrate_a_drive_decide_nothing_and_say_so():
    found = driven("driven-oscillator", {"drive": "16", "samples": "16"})
    assert found["finest"].outcome == "undecided"
    assert "rad of the fastest motion apart" in found["finest"].sentence


@pytest.mark.parametrize(
    ("case", "given"),
    [
        ("driven-oscillator", {"x0": "0"}),
        ("duffing", {"alpha": "-1", "beta": "2"}),
        ("duffing", {"alpha": "-1", "amplitude": "1e-3"}),
    ],
)
def test_the_scale_of_energy_does_not_vanish_where_terms_cancel_or_nothing_moves_yet(case, given):
    instance = discovery.case(case).at(**given)
    assert energy_scale(instance) > 0.05 * instance.scales.energy


STICKING = {
    "damping": "1",
    "angle": "1/2",
    "friction": "1/4",
    "tangential_stiffness": "96",
    "spins": "0,0,1,0,0,-2",
    "masses": "1,3",
}


def test_a_contact_with_tangential_springs_never_gains_energy():
    assert findings("two-spheres", **STICKING)["balance"] == "pass"
    faster = findings(
        "two-spheres",
        lambda run: replace(
            run, velocity=run.velocity * np.linspace(1, 1.5, len(run.t))[:, None, None]
        ),
        **STICKING,
    )
    assert faster["balance"] == "fail"


SLIDING = {"damping": "1", "angle": "1", "friction": "1/16", "masses": "1,3"}


@pytest.mark.parametrize("rubbing", [STICKING, SLIDING], ids=["spring", "sliding"])
def test_nothing_is_said_of_energy_where_slip_and_torque_have_levers_of_their_own(rubbing):
    """The power of such a law is not force times slip: energy may rise, and nobody is accused."""
    given = rubbing | {"branch": "slip-R"}
    found = findings(
        "two-spheres",
        lambda run: replace(
            run,
            channels={},
            velocity=run.velocity * np.linspace(1, 1.5, len(run.t))[:, None, None],
        ),
        **given,
    )
    assert found == {"finest": "undecided"}


@pytest.mark.parametrize("theta0", ["1.5703125", "1.5", "3"])
def test_the_scale_of_a_pendulums_energy_does_not_vanish_where_its_potential_does(theta0):
    instance = discovery.case("pendulum").at(theta0=theta0)
    assert energy_scale(instance) > 0.4 * 9.8125


def test_a_number_that_is_none_is_the_worst_of_all():
    values = np.array([0.0, np.nan, 0.5])
    finding = worst(
        check="c",
        quantity="q",
        t=np.arange(3.0),
        values=values,
        allowed=1.0,
        unit="1",
        basis="b",
        what="w",
    )
    assert finding.outcome == "fail"


def test_of_two_terms_each_may_be_off_by_the_bound_on_the_state(judge):
    found = judge("energy", "harmonic-oscillator", "exact")["balance"]
    instance = discovery.case("harmonic-oscillator").at()
    method = Method(name="exact", summary="", control="exact", conserves=frozenset({"energy"}))
    assert found.bound == pytest.approx(
        2 * Subject(instance, method, (0.0,), None).round_off(0.0), rel=1e-12
    )


def test_the_bound_of_a_balance_is_two_errors_of_the_state():
    """Kinetic and potential energy each err by what the state may: the bound at a sample is twice
    that, and no more, where no other level says how much is needed.
    """
    instance = discovery.case("harmonic-oscillator").at()
    task = task_of(Transparent(), "verlet", instance, truth_of(instance), 1, ("energy",))
    found = {finding.quantity: finding for finding in record_of(task).findings}
    allowed, _ = task.subject.kept("energy", task.subject.levels[0])
    assert np.isclose(2.0 * allowed, found["balance"].bound, rtol=1e-12, atol=0.0).sum() == 1


ESCAPES = {
    "beta": "-0.0796",
    "delta": "0.123",
    "f0": "14.4",
    "x0": "0.0619",
    "duration": "1.481",
    "samples": "16",
}
"""A drive takes the point out of the well of a spring that yields: it ends at 3 L with 3 V."""


@pytest.mark.parametrize("method", ["verlet", "euler", "rk4"])
def test_the_energy_of_a_motion_that_leaves_its_scales_is_known_to_what_it_has_become(method):
    instance = discovery.case("driven-duffing").at(**ESCAPES)
    task = task_of(Transparent(), method, instance, truth_of(instance), 3, ("energy",))
    outcomes = {f.quantity: f.outcome for f in record_of(task).findings}
    assert outcomes["finest"] == "pass"
    assert set(outcomes.values()) == {"pass"}


@pytest.mark.parametrize("method", ["verlet", "euler", "rk4"])
@pytest.mark.parametrize("turning", ["20", "-40"])
def test_what_grows_in_proportion_to_itself_is_off_by_as_much_twice(method, turning):
    """A shaft that whirls 3000 times as wide has 1e7 times the energy, and a sound method is off by
    a part of that.
    """
    instance = discovery.case("whirling-shaft").at(turning=turning)
    task = task_of(Transparent(), method, instance, truth_of(instance), 3, ("energy",))
    outcomes = {f.quantity: f.outcome for f in record_of(task).findings}
    assert outcomes["finest"] == "pass"
    assert set(outcomes.values()) == {"pass"}


def test_a_field_that_lends_energy_to_a_slow_point_lends_it_a_drift():
    """The kinetic energy grows to six times that of the start within the run, and with it the part
    of the energy by which a symplectic method is off.
    """
    given = {
        "mass": "1.32",
        "k1": "0.0122",
        "x1": "-0.935",
        "x2": "0.404",
        "x0": "-1.05",
        "v0": "0.0272",
        "duration": "20.51",
        "samples": "16",
    }
    instance = discovery.case("asymmetric-field").at(**given)
    engine = discovery.engine("pymunk")
    task = task_of(engine, "semi-implicit-euler", instance, truth_of(instance), 3, ("energy",))
    drift = next(f for f in record_of(task).findings if f.quantity == "drift")
    assert drift.outcome == "pass", drift.sentence
