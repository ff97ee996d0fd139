"""Every check passes the true motion and is failed, in the quantity that is wrong, by the fault
that it is there for.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from refdem.core import discovery
from refdem.faults.catalogue import faults


def scaled(column, factor, body=0, axis=0):
    """One component of one body is wrong by a factor."""

    def fault(run, level):
        values = np.array(getattr(run, column))
        values[:, body, axis] *= factor
        return replace(run, **{column: values})

    return fault


def late(run, level):
    """Everything is one step old: the clock is off by one."""
    return replace(
        run,
        **{
            name: np.concatenate([getattr(run, name)[:1], getattr(run, name)[:-1]])
            for name in ("position", "velocity")
        },
    )


def growing(column, rate):
    """One component drifts in proportion to time and to the step, whatever the order."""

    def fault(run, level):
        values = np.array(getattr(run, column))
        values[:, 0, 0] += rate * max(level, 1e-3) * run.t
        return replace(run, **{column: values})

    return fault


def inverted_attitude(run, level):
    """Space to body instead of body to space."""
    return replace(run, attitude=run.attitude * np.array([1.0, -1, -1, -1]))


def unnormalised(run, level):
    return replace(run, attitude=run.attitude * (1 + 1e-9 * np.arange(len(run.t)))[:, None, None])


def body_omega(run, level):
    """Omega in body axes where space axes are asked for."""
    from refdem.mechanics.quaternion import conjugate, rotated

    return replace(run, omega=rotated(conjugate(run.attitude), run.omega))


def longer_rod(run, level):
    return replace(run, position=run.position * 1.001)


def stopped_elsewhere(run, level):
    position = np.array(run.position)
    position[run.t > 9, 0, 0] += 1e-9
    return replace(run, position=position)


def creeping(run, level):
    position = np.array(run.position)
    position[:, 0, 0] += 1e-9 * np.maximum(0, run.t - 9.6)
    return replace(run, position=position)


def jittering(run, level):
    position = np.array(run.position)
    position[:, 0, 2] += 1e-12 * np.sin(50 * run.t)
    return replace(run, position=position)


def never_flips(run, level):
    return replace(
        run,
        omega=np.abs(run.omega),
        attitude=np.broadcast_to([1.0, 0, 0, 0], run.attitude.shape).copy(),
    )


def drawn_in(run, level):
    """After the catch the line is shortened a little, at the same speed."""
    position = np.array(run.position)
    position[run.t > 2] *= 1 - 1e-9
    return replace(run, position=position)


def braked(run, level):
    velocity = np.array(run.velocity)
    velocity[run.t > 2] *= 1 - 1e-9
    return replace(run, velocity=velocity)


def turned_faster(run, level):
    """After the catch it goes round a little too fast for its speed."""
    angle = 1e-9 * np.maximum(0.0, run.t - 2)[:, None]
    x = run.position[..., 0]
    y = run.position[..., 1]
    position = np.stack([x - angle * y, y + angle * x, run.position[..., 2]], axis=-1)
    return replace(run, position=position)


def sliding_on(run, level):
    """It stops a second and a half too late."""
    velocity = np.array(run.velocity)
    velocity[run.t < 11, 0, 0] += 1e-9
    return replace(run, velocity=velocity)


DAMPED = {"damping": "1"}
RUBBING = DAMPED | {
    "angle": "1/2",
    "friction": "1/4",
    "tangential_stiffness": "96",
    "branch": "R",
}
KILLS = [
    ("error", "x", "harmonic-oscillator", "exact", scaled("position", 1 + 1e-11), {}),
    ("error", "v", "harmonic-oscillator", "second", scaled("velocity", 1.05), {}),
    ("error", "x", "harmonic-oscillator", "exact", late, {}),
    ("error", "x", "two-body-orbit", "fourth", late, {}),
    ("error", "attitude", "free-rigid-body", "exact", inverted_attitude, {}),
    ("error", "omega.x", "free-rigid-body", "fourth", body_omega, {}),
    ("error", "y", "pendulum", "exact", longer_rod, {}),
    ("error", "v1.x", "two-spheres", "exact", scaled("velocity", 1 + 1e-9), DAMPED),
    ("order", "state", "harmonic-oscillator", "second", growing("position", 1e-3), {}),
    ("order", "state", "free-rigid-body", "fourth", growing("omega", 1e-4), {}),
    ("energy", "balance", "harmonic-oscillator", "exact", scaled("velocity", 1 + 1e-10), {}),
    ("energy", "drift", "harmonic-oscillator", "second", growing("position", 1.0), {}),
    ("energy", "balance", "free-rigid-body", "exact", scaled("omega", 1.0001), {}),
    ("momentum", "total", "two-spheres", "second", scaled("velocity", 1 + 1e-9), DAMPED),
    ("angular-momentum", "total", "free-rigid-body", "exact", body_omega, {}),
    ("angular-momentum", "spin", "free-rigid-body", "exact", inverted_attitude, {}),
    ("angular-momentum", "total", "two-body-orbit", "exact", scaled("velocity", 1.001, axis=1), {}),
    ("angular-momentum", "law", "two-spheres", "exact", scaled("omega", 1 + 1e-9, axis=2), RUBBING),
    ("energy-return", "gain", "asymmetric-field", "exact", scaled("velocity", 1 + 1e-9), {}),
    ("energy-return", "return", "wedge-collision", "exact", growing("velocity", 1e-6), {}),
    ("constraint", "length", "pendulum", "exact", longer_rod, {}),
    ("constraint", "velocity", "pendulum", "exact", scaled("velocity", 1.001), {}),
    ("flight", "way", "two-spheres", "exact", scaled("position", 1 + 1e-9), DAMPED),
    (
        "equilibrium",
        "swing",
        "pendulum-equilibria",
        "exact",
        late,
        {"delta": "1e-3", "position": "bottom"},
    ),
    ("quaternion-norm", "norm", "free-rigid-body", "exact", unnormalised, {}),
    ("rest", "displacement", "newtons-first-law", "exact", jittering, {"member": "block"}),
    ("stop", "stop_position", "coulomb-oscillator", "exact", stopped_elsewhere, {}),
    ("stop", "creep", "coulomb-oscillator", "exact", creeping, {}),
    ("stop", "stop_time", "coulomb-oscillator", "exact", sliding_on, {}),
    ("capture", "speed", "captured-mass", "exact", drawn_in, {}),
    ("capture", "inertia", "captured-mass", "exact", braked, {}),
    ("capture", "omega", "captured-mass", "exact", turned_faster, {}),
    (
        "equilibrium",
        "departure",
        "pendulum-equilibria",
        "exact",
        scaled("position", 1.001),
        {"delta": "1e-4"},
    ),
    (
        "equilibrium",
        "departure",
        "pendulum-equilibria",
        "exact",
        growing("position", 1e-9),
        {"delta": "0"},
    ),
    (
        "equilibrium",
        "bounded",
        "pendulum-equilibria",
        "exact",
        growing("position", 1.0),
        {"delta": "1e-3", "position": "bottom"},
    ),
    ("flips", "flips", "intermediate-axis", "exact", never_flips, {}),
    ("reversal", "reversed", "harmonic-oscillator", "exact", growing("velocity", 1e-6), {}),
    ("determinism", "repeated", "harmonic-oscillator", "exact", scaled("position", 1 + 1e-15), {}),
]


@pytest.mark.parametrize(("check", "quantity", "case", "method", "fault", "given"), KILLS)
def test_a_check_is_failed_by_its_fault_in_the_quantity_that_is_wrong(
    judge, check, quantity, case, method, fault, given
):
    clean = judge(check, case, method, **given)
    assert {name: f.sentence for name, f in clean.items() if f.outcome != "pass"} == {}
    spoiled = judge(check, case, method, fault, **given)[quantity]
    assert spoiled.outcome == "fail"
    assert spoiled.margin < 0


ELSEWHERE = {"roughness"}
"""Killed in test_gas_faults.py."""


def test_every_check_has_a_fault_that_it_kills():
    """One above, one of the catalogue that names it, or one in a file of tests named for it."""
    killing = {check for check, *_ in KILLS} | {fault.sees[0] for fault in faults()}
    for name in set(discovery.names("checks")) - killing - ELSEWHERE:
        own = Path(__file__).with_name(f"test_{name.replace('-', '_')}.py")
        assert own.is_file(), f"check {name} kills no fault: {own} is not there"
