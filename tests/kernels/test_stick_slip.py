"""The kernel of the point on a belt: against a plain integration in Python, its section, its
tangents, and what it does at the edges.
"""

import numpy as np
import pytest

from refdem.kernels import load, pointer

FAMILY = "stick_slip"
LAW = {
    "mass": 1.0,
    "stiffness": 1.0,
    "normal_force": 10.0,
    "mu0": 0.4,
    "mu1": 0.1,
    "lambda0": 1.42,
    "lambda1": 0.01,
    "belt": 1.0,
    "amplitude": 0.5,
    "frequency": 1.2,
    "phase": 0.0,
    "linear": 0,
    "weight": 0.0,
}


def law(**changed):
    """The law as the kernel takes it."""
    return load(FAMILY).ffi.new("refdem_belt *", LAW | changed)


def run(t, x0=0.0, v0=0.0, most=100, **changed):
    """Rows (T, 3) and events."""
    t = np.asarray(t, float)
    out = np.full((len(t), 3), np.nan)
    event = np.zeros((most, 2))
    buffers = [pointer(FAMILY, array, output=True) for array in (event, out)]
    count = load(FAMILY).lib.refdem_stick_slip(
        law(**changed), x0, v0, t[0], len(t), pointer(FAMILY, t), most, *buffers
    )
    return out, event[:count]


def section(frequency, *, skip, keep, blocks=0, most=1000, origin=0.0, x0=0.0, **changed):
    """Counts, growths and places."""
    frequency = np.asarray(frequency, float)
    n = len(frequency)
    counts = np.zeros(n)
    sums = np.zeros((n, max(1, blocks)))
    out = np.zeros((n, most))
    buffers = [pointer(FAMILY, array, output=True) for array in (counts, sums, out)]
    call = load(FAMILY).lib.refdem_stick_slip_section
    assert (
        call(
            law(**changed),
            n,
            pointer(FAMILY, frequency),
            origin,
            x0,
            0.0,
            skip,
            keep,
            blocks,
            most,
            *buffers,
        )
        == 0
    )
    return counts.astype(int), sums, out


def plain(x, v, t, until, step=1e-4, **changed):
    """The same by midpoint steps of Stribeck's law as it is written, sticking by balance of forces:
    an independent, coarse witness.
    """
    p = LAW | changed

    def friction(u):
        last = p["lambda1"] * (u if p["linear"] else u * u)
        return p["normal_force"] * (
            (p["mu0"] - p["mu1"]) / (1 + p["lambda0"] * u) + p["mu1"] + last
        )

    def pull(s, place):
        return (
            p["amplitude"] * np.cos(p["frequency"] * s + p["phase"])
            + p["weight"]
            - p["stiffness"] * place
        )

    limit = friction(0.0)
    while t < until - step / 2:
        u = v - p["belt"]
        if u == 0 and abs(pull(t, x)) <= limit:
            x += p["belt"] * step
        else:
            side = np.sign(u) or np.sign(pull(t, x))
            rate = (pull(t, x) - side * friction(abs(u))) / p["mass"]
            middle = v + rate * step / 2
            half = (
                pull(t + step / 2, x + v * step / 2) - side * friction(abs(middle - p["belt"]))
            ) / p["mass"]
            x = x + middle * step
            after = v + half * step
            if (after - p["belt"]) * side < 0:
                v = p["belt"]
            else:
                v = after
        t += step
    return x, v


@pytest.mark.parametrize(
    "changed",
    [
        {},
        {"linear": 1, "amplitude": 2.0, "frequency": 1.25},
        {
            "mass": 2.0,
            "stiffness": 3.0,
            "weight": -1.5,
            "belt": -0.5,
            "phase": 0.75,
            "normal_force": 6.0,
        },
        {"belt": 0.0, "amplitude": 5.0, "weight": -2.0},
        {"mu1": 0.4, "lambda0": 0.0, "lambda1": 0.0},
    ],
    ids=str,
)
def test_states_are_those_of_a_plain_integration(changed):
    rows, events = run([0.0, 3.0, 6.5, 9.0], x0=0.5, v0=0.25, **changed)
    x = 0.5
    v = 0.25
    t = 0.0
    for row, until in zip(rows[1:], (3.0, 6.5, 9.0), strict=True):
        x, v = plain(x, v, t, until, **changed)
        t = until
        assert row[0] == pytest.approx(x, abs=3e-3)
        assert row[1] == pytest.approx(v, abs=6e-3)
    assert np.all(np.diff(events[:, 0]) > 0)


def test_velocity_is_exactly_the_belts_between_stick_and_slip():
    t = np.linspace(0, 40, 4001)
    rows, events = run(t)
    sticks = events[events[:, 1] == 1, 0]
    slips = events[events[:, 1] == 2, 0]
    inside = np.zeros(len(t), bool)
    for begin, end in zip(sticks, [*slips, np.inf], strict=False):
        inside |= (t >= begin) & (t <= end)
    assert inside.sum() > 1000
    assert np.all(rows[inside, 1] == 1.0)
    assert np.all(rows[~inside, 1] != 1.0)


def test_samples_change_nothing():
    coarse = run([0.0, 10.0, 30.0])[0]
    dense = run(np.arange(0, 30.5, 0.5))[0]
    np.testing.assert_array_equal(coarse[1], dense[20])
    np.testing.assert_array_equal(coarse[2], dense[60])


def test_energy_and_work_add_up():
    rows, _ = run(np.linspace(0, 60, 601), weight=-2.0)
    x, v, work = rows.T
    energy = v * v / 2 + x * x / 2 + 2.0 * x + work
    np.testing.assert_allclose(energy, energy[0], atol=3e-13)


def test_a_drive_too_weak_never_releases_and_sticks_for_ever():
    rows, events = run([0.0, 1.0, 1e9], x0=1.0, belt=0.0, amplitude=1.0)
    assert len(events) == 0
    np.testing.assert_array_equal(rows[:, :2], [[1.0, 0.0]] * 3)
    assert section([1.2], skip=1, keep=2, belt=0.0, amplitude=1.0, x0=1.0)[0].tolist() == [0]


def test_events_beyond_the_room_are_left_out():
    assert len(run([0.0, 100.0], most=3)[1]) == 3


def test_a_section_is_that_of_dense_samples():
    counts, _, places = section([1.2], skip=3, keep=6)
    t = np.arange(0, 9 * 2 * np.pi / 1.2, 1e-3)
    rows, _ = run(t)
    begin = 3 * 2 * np.pi / 1.2
    crosses = np.flatnonzero((rows[1:, 1] > 0) != (rows[:-1, 1] > 0))
    at = [
        crosses[i] for i in range(len(crosses)) if t[crosses[i]] > begin and rows[crosses[i], 0] > 0
    ]
    np.testing.assert_allclose(places[0, : counts[0]], rows[at, 0], atol=1e-5)
    shifted = section([1.2], skip=3, keep=6, weight=2.0, x0=2.0, origin=-2.0)
    np.testing.assert_allclose(shifted[2][0, : counts[0]], places[0, : counts[0]], atol=1e-9)


def test_growth_of_a_tangent_is_that_of_a_displaced_start():
    """Up to what it grows in the last stretch, which may end a little after the fifth period."""
    small = 2.0**-30
    until = 5 * 2 * np.pi / 1.2
    _, sums, _ = section([1.2], skip=0, keep=5, blocks=1)
    a = run([0.0, until])[0][1]
    b = run([0.0, until], x0=small)[0][1]
    assert sums[0, 0] == pytest.approx(np.log(np.hypot(*(b[:2] - a[:2])) / small), abs=0.35)


def test_windows_have_negative_exponents_and_chaos_a_positive_one():
    _, sums, _ = section([1.15, 1.5], skip=100, keep=200, blocks=4)
    assert np.all(sums.sum(axis=1) < -10)
    _, sums, _ = section([1.2558], skip=100, keep=300, blocks=4, amplitude=0.7)
    assert sums.sum() > 30
