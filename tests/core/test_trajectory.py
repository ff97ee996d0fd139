"""Trajectories are validated when they are made and survive the store to the last bit."""

import numpy as np
import pytest

from refdem.core.trajectory import Event, Trajectory
from refdem.errors import EngineError


def trajectory(**more):
    t = np.linspace(0, 1, 5)
    position = np.arange(15.0).reshape(5, 1, 3)
    return Trajectory.of_points(t, position, position / 7, **more)


def test_bytes_read_back_to_the_last_bit():
    run = trajectory(channels={"overlap": np.full((5, 1), 1 / 3)}, events=(Event(0.5, "stop", 0),))
    again = Trajectory.from_bytes(run.to_bytes())
    for name in ("t", "position", "velocity", "attitude", "omega"):
        assert np.array_equal(getattr(run, name), getattr(again, name))
    assert np.array_equal(again.channels["overlap"], run.channels["overlap"])
    assert again.events == run.events


@pytest.mark.parametrize("name", ["t", "position", "velocity", "attitude", "omega"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_number_that_is_not_finite_is_refused_with_its_place(name, bad):
    columns = {
        n: np.array(getattr(trajectory(), n))
        for n in ("t", "position", "velocity", "attitude", "omega")
    }
    columns[name].reshape(-1)[2] = bad
    with pytest.raises(EngineError, match=rf"trajectory\.{name}\["):
        Trajectory(**columns)


def test_wrong_shapes_and_unknown_channels_are_refused():
    good = trajectory()
    with pytest.raises(EngineError, match="expected float64"):
        Trajectory(
            t=good.t,
            position=good.position,
            velocity=good.velocity[:4],
            attitude=good.attitude,
            omega=good.omega,
        )
    with pytest.raises(EngineError, match="closeness"):
        trajectory(channels={"closeness": np.zeros(5)})


def test_one_row_that_stands_for_all_is_packed_once_and_read_back():
    still = np.array([[0.6, 0.0, 0.8, 0.0]] * 50)
    rows = {
        "position": np.random.default_rng(1).normal(size=(9, 50, 3)),
        "velocity": np.zeros((9, 50, 3)),
    }
    made = Trajectory(
        t=np.arange(9.0),
        attitude=np.broadcast_to(still, (9, 50, 4)),
        omega=np.broadcast_to(np.zeros((50, 3)), (9, 50, 3)),
        **rows,
    )
    again = Trajectory.from_bytes(made.to_bytes())
    assert all(
        np.array_equal(value, again.columns()[name]) for name, value in made.columns().items()
    )
    assert len(made.to_bytes()) < 0.6 * sum(value.nbytes for value in made.columns().values())
