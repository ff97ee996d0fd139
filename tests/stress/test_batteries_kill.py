"""Every battery has a fault that it kills, at the point at which it begins to matter and not
before.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from refdem.core.engine import Engine
from refdem.faults.transparent import Transparent
from tests.stress.carried import (
    carrier,
    changed_bodies,
    changed_elements,
    changed_run,
    results,
    verdicts,
)


def single(values: Any) -> Any:
    return values.astype(np.float32).astype(float)


def flushed(values: Any) -> Any:
    return np.where(np.abs(values) < 1e-200, 0.0, values)


def clipped(columns: dict[str, Any]) -> dict[str, Any]:
    return {"omega": np.clip(columns["omega"], -5e3, 5e3)}


def light_ones_are_heavier(columns: dict[str, Any]) -> dict[str, Any]:
    return {"mass": np.maximum(columns["mass"], columns["mass"].max() * 1e-5)}


def fat_needles(columns: dict[str, Any]) -> dict[str, Any]:
    return {"inertia": np.maximum(columns["inertia"], 1e-3 * columns["inertia"].max())}


def small_spins_are_none(columns: dict[str, Any]) -> dict[str, Any]:
    return {"omega": np.where(np.abs(columns["omega"]) < 1e-5, 0.0, columns["omega"])}


def late_second(columns: dict[str, Any]) -> dict[str, Any]:
    columns["position"][1] *= 1.001
    return {"position": columns["position"]}


def pushed_apart(columns: dict[str, Any]) -> dict[str, Any]:
    return {
        "position": (
            np.sign(columns["position"])
            * np.maximum(np.abs(columns["position"]), np.abs(np.sign(columns["position"])) * 0.5)
        )
    }


def slow_pairs_stick(columns: dict[str, Any]) -> dict[str, Any]:
    closing = np.linalg.norm(columns["velocity"][1] - columns["velocity"][0])
    if closing >= 1e-3:
        return {}
    return {"velocity": np.zeros_like(columns["velocity"])}


def slow_ones_slide_not(columns: dict[str, Any]) -> dict[str, Any]:
    return {"velocity": np.where(np.abs(columns["velocity"]) < 1e-5, 0.0, columns["velocity"])}


Killed = tuple[str, str, str, tuple[str, str], Callable[[], Engine]]
FAULTS: list[Killed] = [
    (
        "frame",
        "far away: harmonic-oscillator",
        "exact-harmonic",
        ("1", "1e8"),
        lambda: carrier(
            "lost far away", after=changed_run(position=lambda r: r + 1e-3 * (np.abs(r) > 1e3))
        ),
    ),
    (
        "frame",
        "longer: harmonic-oscillator",
        "exact-harmonic",
        ("1e1", "1e12"),
        lambda: carrier(
            "a box of 1 km", after=changed_run(position=lambda r: np.clip(r, -1e3, 1e3))
        ),
    ),
    (
        "single-precision",
        "told apart: harmonic-oscillator",
        "exact-harmonic",
        ("1e-4", "1e-10"),
        lambda: carrier("single", after=changed_run(position=single, velocity=single)),
    ),
    (
        "denormals",
        "tiny: harmonic-oscillator",
        "exact-harmonic",
        ("1e100", "1e250"),
        lambda: carrier("flushed to zero", after=changed_run(position=flushed, velocity=flushed)),
    ),
    (
        "mass-ratio",
        "second sphere heavier",
        "contact-events",
        ("1e2", "1e6"),
        lambda: carrier("masses clipped", before=changed_bodies(light_ones_are_heavier)),
    ),
    (
        "inertia",
        "needle",
        "exact-free-body",
        ("1/128", f"1/{2**13}"),
        lambda: carrier("inertia bounded", before=changed_bodies(fat_needles)),
    ),
    (
        "separatrix",
        "off axis 2, towards axis 1",
        "exact-free-body",
        ("1e-3", "1e-6"),
        lambda: carrier("a dead zone of spin", before=changed_bodies(small_spins_are_none)),
    ),
    (
        "spin",
        "flying body for a second",
        "exact-free-body",
        ("1e3", "1e4"),
        lambda: carrier("spin clipped", before=changed_bodies(clipped)),
    ),
    (
        "friction",
        "less and less on a slope",
        "exact-slide",
        ("1e-1", "0"),
        lambda: carrier(
            "some friction always", before=changed_elements(friction=lambda mu: max(mu, 1e-3))
        ),
    ),
    (
        "friction",
        "less and less tangential speed",
        "contact-events",
        ("1e-3", "1e-6"),
        lambda: carrier("a threshold of speed", before=changed_bodies(slow_ones_slide_not)),
    ),
    (
        "restitution",
        "losing less and less",
        "contact-events",
        ("1e-1", "0"),
        lambda: carrier(
            "some damping always", before=changed_elements(damping=lambda c: max(c, 1e-3))
        ),
    ),
    (
        "stiffness",
        "harder springs",
        "exact-harmonic",
        ("1e6", "1e12"),
        lambda: carrier(
            "stiffness clipped", before=changed_elements(stiffness=lambda k: min(k, 1e9))
        ),
    ),
    (
        "soft-contacts",
        "elastic spheres, slower and slower",
        "contact-events",
        ("1e1", "1e6"),
        lambda: carrier("a threshold of speed", before=changed_bodies(slow_pairs_stick)),
    ),
    (
        "soft-contacts",
        "elastic spheres, harder and harder",
        "contact-events",
        ("1e6", "1e12"),
        lambda: carrier(
            "stiffness clipped", before=changed_elements(stiffness=lambda k: min(k, 1e9))
        ),
    ),
    (
        "impacts-in-sequence",
        "cradle that loses more and more",
        "impacts",
        ("1", "1/4"),
        lambda: carrier(
            "some rebound always", before=changed_elements(restitution=lambda e: max(e, 1 / 3))
        ),
    ),
    (
        "impacts-in-sequence",
        "bounces with more and more friction",
        "impacts",
        ("1e-3", "1/4"),
        lambda: carrier(
            "little friction", before=changed_elements(friction=lambda mu: min(mu, 1 / 64))
        ),
    ),
    (
        "impacts",
        "slower and slower impact",
        "impacts",
        ("1e2", "1e6"),
        lambda: carrier("a threshold of speed", before=changed_bodies(slow_pairs_stick)),
    ),
    (
        "impacts",
        "impact that loses more and more",
        "impacts",
        ("1/2", "0"),
        lambda: carrier(
            "some rebound always", before=changed_elements(restitution=lambda e: max(e, 1e-3))
        ),
    ),
    (
        "contacts",
        "deeper overlap",
        "contact-events",
        ("1/64", "1/2"),
        lambda: carrier(
            "deep ones moved apart",
            before=changed_bodies(
                lambda c: {
                    "position": np.where(
                        np.abs(c["position"]) < 0.3, np.sign(c["position"]) * 0.5, c["position"]
                    )
                }
            ),
        ),
    ),
]


@pytest.mark.parametrize(
    ("battery", "sweep", "method", "points", "engine"),
    FAULTS,
    ids=[f"{one[0]}-{one[1]}" for one in FAULTS],
)
def test_a_fault_is_killed_at_the_point_where_it_matters(
    battery: str,
    sweep: str,
    method: str,
    points: tuple[str, str],
    engine: Callable[[], Engine],
    tmp_path: Path,
) -> None:
    sound = results(tmp_path, battery, sweep, points, method=method, longest=1e9)
    assert verdicts(sound) == {method: ["pass", "pass"]}
    assert verdicts(results(tmp_path, battery, sweep, points, engine(), method, longest=1e9)) == {
        method: ["pass", "fail"]
    }


@pytest.mark.parametrize(
    ("change", "sweep", "points"),
    [
        (late_second, "hits at once", ("2", "4")),
        (pushed_apart, "shallower overlap", ("1e-4", "1e-12")),
    ],
)
def test_contacts_that_are_not_taken_as_they_are_are_seen_on_every_point(
    change: Any, sweep: str, points: tuple[str, str], tmp_path: Path
) -> None:
    found = results(
        tmp_path,
        "contacts",
        sweep,
        points,
        carrier("moved", before=changed_bodies(change)),
        "contact-events",
    )
    assert verdicts(found) == {"contact-events": ["fail", "fail"]}


def test_a_method_that_is_never_stable_breaks_on_the_first_point(tmp_path: Path) -> None:
    record = results(
        tmp_path,
        "step-limit",
        "step: harmonic-oscillator",
        ("1/8", "99/100"),
        Transparent(),
        "explicit-euler",
    )
    (result,) = record.results
    assert (result.holds, result.breaks) == (None, 0.125)


def test_a_contact_within_four_steps_gives_back_its_energy_and_within_two_does_not(
    tmp_path: Path,
) -> None:
    record = results(
        tmp_path,
        "soft-contacts",
        "step against contact time",
        ("1/20", "1/4", "1/2"),
        method="velocity-verlet",
    )
    (result,) = record.results
    assert (result.holds, result.breaks, result.kept) == (0.25, 0.5, True)


def test_verlet_breaks_at_two_over_omega(tmp_path: Path) -> None:
    record = results(
        tmp_path,
        "step-limit",
        "step: harmonic-oscillator",
        ("1/2", "99/100", "101/100", "2"),
        method="velocity-verlet",
    )
    (result,) = record.results
    assert (result.holds, result.breaks, result.kept) == (0.99, 1.01, True)


def test_a_clock_that_is_summed_in_single_precision_is_an_error(tmp_path: Path) -> None:
    def summed(t: Any) -> Any:
        return np.concatenate(
            [[0.0], np.cumsum(np.diff(t).astype(np.float32), dtype=np.float32)]
        ).astype(float)

    faulty = carrier("t += h", after=changed_run(t=lambda t: summed(t)))
    record = results(
        tmp_path, "many-steps", "harmonic oscillator", ("1024", "4096"), faulty, "velocity-verlet"
    )
    assert verdicts(record)["velocity-verlet"] == ["error", "error"]


@pytest.mark.parametrize("creep", [1e-9, -1e-9])
def test_energy_that_creeps_is_seen_below_the_wobble_of_truncation(
    creep: float, tmp_path: Path
) -> None:
    def grown(values: Any) -> Any:
        return values * (1 + creep * np.linspace(0, 1, len(values)))[:, None, None]

    faulty = carrier("creeping", after=changed_run(position=grown, velocity=grown))
    assert verdicts(
        results(tmp_path, "many-steps", "harmonic oscillator", ("1024",), method="velocity-verlet")
    ) == {"velocity-verlet": ["pass"]}
    record = results(
        tmp_path, "many-steps", "harmonic oscillator", ("1024",), faulty, "velocity-verlet"
    )
    assert verdicts(record) == {"velocity-verlet": ["fail"]}
    assert record.results[0].points[0].value == pytest.approx(2 * abs(creep), rel=0.3)


def test_a_point_that_was_forecast_to_take_too_long_is_not_run_and_not_a_pass(
    tmp_path: Path,
) -> None:
    record = results(
        tmp_path,
        "many-steps",
        "harmonic oscillator",
        ("1024", "4096", "16384"),
        method="velocity-verlet",
        longest=0.0,
    )
    assert verdicts(record) == {"velocity-verlet": ["pass", "not run", "not run"]}
    last = record.results[0].points[-1]
    assert last.forecast is not None
    assert last.forecast > 0
