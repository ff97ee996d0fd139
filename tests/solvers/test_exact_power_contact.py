"""Contacts of a power of the overlap in closed form: against certified truth, from any start, and
through the wedge's turn.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.reference import ENGINE
from refdem.kernels import load, pointer

STATE = ("overlap", "v")


def solved(case, method, **given):
    problem = discovery.case(case).at(**given).problem
    return ENGINE.run(Request(problem=problem, method=method))[0]


@pytest.mark.parametrize(
    ("case", "method", "given"),
    [
        ("hertz-spheres", "exact-hertz", {}),
        (
            "hertz-spheres",
            "exact-hertz",
            {"closing_speed": "1000", "stiffness": "1e9", "effective_mass": "1/1000"},
        ),
        ("hertz-spheres", "exact-hertz", {"closing_speed": "1e-6", "samples": "300"}),
        ("wedge-collision", "exact-wedge", {}),
        ("wedge-collision", "exact-wedge", {"k1": "20", "closing_speed": "7", "samples": "300"}),
    ],
)
def test_it_agrees_with_certified_truth(case, method, given, largest_error):
    assert largest_error(case, solved(case, method, **given), STATE, **given) < 3e-14


def pressed(overlap, rate, times, inward=(7.0, 1.5), outward=(7.0, 1.5), mass=0.5):
    """Rows of overlap and rate, and when it touches, turns and parts."""
    out = np.zeros((len(times), 2))
    touch = np.zeros(3)
    arrays = [pointer("power_contact", np.array(law)) for law in (inward, outward)]
    buffers = [pointer("power_contact", array, output=True) for array in (touch, out)]
    numbers = (overlap, rate, len(times), pointer("power_contact", np.asarray(times, float)))
    load("power_contact").lib.refdem_power_contact(mass, *arrays, *numbers, *buffers)
    return out, touch


@pytest.mark.parametrize("part", [0.02, 0.3, 0.499, 0.501, 0.8, 0.99])
def test_a_start_in_the_middle_of_a_contact_goes_on_as_the_whole_does(part):
    whole, touch = pressed(-0.1, 2.0, np.linspace(0.0, 1.0, 9))
    begin = touch[0] + part * (touch[2] - touch[0])
    (start,), _ = pressed(-0.1, 2.0, [begin])
    again, _ = pressed(*start, np.linspace(0.0, 1.0, 9) - begin)
    assert np.abs(again - whole).max() < 2e-14


def test_what_does_not_close_never_touches():
    out, touch = pressed(-0.5, -1.0, [0.0, 2.0])
    assert np.array_equal(out, [[-0.5, -1.0], [-2.5, -1.0]])
    assert np.isinf(touch).all()


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 3.0])
def test_it_is_what_velocity_verlet_tends_to(exponent):
    def verlet(n):
        d = 0.0
        v = 1.0
        h = 0.5 / n
        for _ in range(n):
            v -= h / 2 * 8.0 * max(d, 0.0) ** exponent
            d += h * v
            v -= h / 2 * 8.0 * max(d, 0.0) ** exponent
        return np.array([d, v])

    law = (8.0, exponent)
    limit = (4 * verlet(4000) - verlet(2000)) / 3
    assert np.abs(pressed(0.0, 1.0, [0.5], law, law, mass=1.0)[0][0] - limit).max() < 1e-7


def test_a_wedge_run_back_comes_in_flat_side_first_and_gets_its_energy_back():
    instance = discovery.case("wedge-collision").at()
    there = solved("wedge-collision", "exact-wedge")
    end = {name: getattr(there, name)[-1] for name in ("position", "attitude", "omega")}
    scene = instance.scene.with_state(velocity=-there.velocity[-1], **end)
    back = ENGINE.run(Request(problem=Motion(scene, instance.times), method="exact-wedge"))[0]
    assert there.velocity[-1, 0, 0] == pytest.approx(-np.sqrt(0.5), rel=1e-14)
    assert back.velocity[-1, 0, 0] == pytest.approx(-1.0, rel=1e-13)
    assert np.abs(np.abs(np.sum(back.attitude[-1] * instance.scene.bodies.attitude)) - 1) < 1e-14
    assert there.channels["dissipated_work"][-1] == pytest.approx(0.25, rel=1e-14)
    assert back.channels["dissipated_work"][-1] == pytest.approx(-0.25, rel=1e-13)
    assert [event.kind for event in there.events] == ["turn", "release"]


def test_other_laws_and_other_ways_are_refused():
    hertz, linear = (discovery.case(name).at().problem for name in ("hertz-spheres", "two-spheres"))
    assert ENGINE.best(hertz).name == "exact-hertz"
    assert ENGINE.unsupported_motion(linear, ENGINE.method("exact-hertz"))
    assert ENGINE.unsupported_motion(hertz, ENGINE.method("exact-head-on"))
    assert "not smooth" in ENGINE.unsupported_motion(hertz, ENGINE.method("contact-events"))
    sideways = hertz.scene.with_state(
        velocity=hertz.scene.bodies.velocity + np.array([[0.0, 0.1, 0.0], [0.0, 0.0, 0.0]])
    )
    assert ENGINE.unsupported_motion(Motion(sideways, hertz.times), ENGINE.method("exact-hertz"))


@pytest.mark.parametrize(("method", "order"), [("velocity-verlet", 2.0), ("rk4", 2.5)])
def test_particles_under_hertz_converge_as_the_onset_allows(method, order):
    instance = discovery.case("hertz-spheres").at(samples="16")
    exact = solved("hertz-spheres", "exact-hertz", samples="16").velocity
    step = float(instance.problem.interval) / 8
    runs = [
        ENGINE.run(Request(problem=instance.problem, method=method, step=step / 2**k))[0].velocity
        for k in (0, 1)
    ]
    coarse, fine = (np.abs(run - exact).max() for run in runs)
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.25)
