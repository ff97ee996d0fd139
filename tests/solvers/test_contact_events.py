"""Collisions to round-off: closed forms of head-on contact, certified truth of oblique contact."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE

STATE = tuple(f"{kind}{i}.{axis}" for i in (1, 2) for kind in ("r", "v", "omega") for axis in "xyz")


def solved(**given: str) -> Trajectory:
    """The case two-spheres by extrapolation."""
    problem = discovery.case("two-spheres").at(**given).problem
    return ENGINE.run(Request(problem=problem, method="contact-events"))[0]


@pytest.mark.parametrize("cutoff", ["zero_overlap", "zero_force"])
@pytest.mark.parametrize("damping", [0.0, 1.0, 6.0, 10.0])
def test_duration_and_restitution_are_those_of_the_damped_sine(cutoff, damping):
    """t = pi/w or 2 arccos(b/w0)/w and exp(-b t), with b = c/(2 m_eff), w0^2 = k/m_eff; m_eff = 1/2, k = 128 (Schwager 2007)."""
    b, w0 = damping, 16.0
    w = np.sqrt(w0 * w0 - b * b)
    duration = np.pi / w if cutoff == "zero_overlap" else 2 * np.arccos(b / w0) / w
    seen = solved(damping=str(damping), cutoff=cutoff)
    assert [event.kind for event in seen.events] == ["release"]
    assert seen.events[0].time == pytest.approx(duration, rel=2e-15)
    restitution = seen.velocity[-1, 1, 0] - seen.velocity[-1, 0, 0]
    assert restitution == pytest.approx(np.exp(-b * duration), rel=4e-15)


def test_overlap_and_force_are_those_of_the_damped_sine():
    """d = sin(w t) exp(-b t)/w and F = k d + c d' while it lasts, nothing afterwards."""
    seen = solved(damping="6")
    b, w = 6.0, np.sqrt(16.0**2 - 36.0)
    t = np.minimum(seen.t, np.pi / w)
    overlap = np.sin(w * t) * np.exp(-b * t) / w
    force = 128.0 * overlap + 6.0 * np.exp(-b * t) * (np.cos(w * t) - b / w * np.sin(w * t))
    during = seen.t < np.pi / w
    assert np.abs(seen.channels["overlap"] - overlap).max() < 4e-16
    assert np.abs(seen.channels["contact_force"] - np.where(during, force, 0.0))[seen.t != 0].max() < 1e-13
    assert np.array_equal(seen.channels["contacts"], during.astype(float))


@pytest.mark.parametrize("given", [
    {"angle": "1", "friction": "0.1"},
    {"angle": "1", "friction": "0.1", "damping": "0", "branch": "R"},
    {"angle": "1.2", "friction": "0.1", "cutoff": "zero_force", "spins": "0,0,2,0,0,-5", "masses": "1,3", "radii": "1/2,4/5"},
], ids=["damped", "elastic, arm R", "spinning, zero force"])  # fmt: skip
def test_gross_sliding_agrees_with_certified_truth(given, largest_error):
    assert largest_error("two-spheres", solved(**given), STATE, **given) < 8e-15


@pytest.mark.parametrize("stiffness", [1e6, 1e8])
def test_friction_impulse_is_mu_times_the_normal_impulse_in_gross_sliding(stiffness):
    """Law-free but for the angle by which the normal turns meanwhile, v_t t/(R1 + R2), t = pi sqrt(m_eff/k)."""
    seen = solved(angle="1", friction="0.05", damping="0", stiffness=str(stiffness))
    impulse = seen.velocity[-1, 0] - seen.velocity[0, 0]
    turned = np.sin(1.0) * np.pi * np.sqrt(0.5 / stiffness)
    assert impulse[1] / impulse[0] == pytest.approx(0.05, abs=turned)


def test_a_collision_turned_in_space_is_the_same_collision_turned():
    """Out of the plane too: axes permuted cyclically, the motion is permuted, to round-off."""
    given = {"angle": "0.6", "friction": "0.3", "tangential_stiffness": "100", "spins": "1,3,2,4,-2,-5"}
    instance = discovery.case("two-spheres").at(**given)
    bodies = instance.scene.bodies
    cycled = {name: np.roll(getattr(bodies, name), 1, axis=1) for name in ("position", "velocity", "omega")}
    plain = Request(problem=instance.problem, method="contact-events")
    turned = ENGINE.run(plain.with_scene(instance.scene.with_state(**cycled)))[0]
    for name in cycled:
        assert np.abs(np.roll(getattr(turned, name), -1, axis=2) - getattr(ENGINE.run(plain)[0], name)).max() < 3e-14


def test_it_is_the_cheapest_method_for_an_oblique_collision_and_refuses_what_cannot_touch():
    oblique = discovery.case("two-spheres").at(angle="1", friction="0.3").problem
    assert ENGINE.best(oblique).name == "contact-events"
    assert ENGINE.refusal(discovery.case("harmonic-oscillator").at().problem, ENGINE.method("contact-events"))
