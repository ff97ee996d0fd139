"""Replays: frames of truth are its certified values, frames of engines those of their runs."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.finding import Record
from refdem.core.replay import STEPS, Replay
from refdem.core.store import Store
from refdem.mechanics.quaternion import angle_between
from refdem.planning.campaign import Campaign
from refdem.planning.in_process import truth_of
from refdem.planning.runs import checked_reply
from refdem.planning.specification import Entry, Specification

CASES = (
    Entry("pendulum", {"samples": "16", "duration": "2"}),
    Entry("free-rigid-body", {"samples": "16", "duration": "2"}),
    Entry("rolling", {"samples": "8", "duration": "0.25"}),
    Entry("newtons-cradle", {"samples": "16"}),
    Entry("moments-of-inertia"),
)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("replays") / "store.sqlite")


@pytest.fixture(scope="module")
def sheets(store):
    specification = Specification(
        name="replays", case=list(CASES), engines=["reference"], levels=2, checks=["error"]
    )
    return Campaign(specification, store, jobs=0, use_store=False).sheets()


@pytest.fixture(scope="module")
def replays(sheets):
    return {s.label.partition("[")[0]: s for s in sheets if isinstance(s, Replay)}


def trajectories(sheets, store, label, track):
    """The trajectories that were kept of the method of a track."""
    (record,) = [
        sheet
        for sheet in sheets
        if isinstance(sheet, Record) and (sheet.label, sheet.method) == (label, track.method)
    ]
    return [store.read("run", key, checked_reply).unpacked() for key in record.runs]


def places(replay):
    """Places (F, N, 3) of truth."""
    count = len(replay.bodies)
    moved = replay.place.values(len(replay.t), 3 * count).reshape(-1, count, 3)
    return np.array([body.position for body in replay.bodies]) + moved


def test_only_motions_are_replayed(replays):
    assert set(replays) == {entry.id for entry in CASES[:4]}


def test_frames_of_truth_are_its_certified_values(replays):
    replay = replays["pendulum"]
    instance = discovery.case("pendulum").at(samples="16", duration="2")
    assert replay.certified == ("x", "y")
    truth = truth_of(instance)
    shown = places(replay)[:, 0]
    step = replay.place.scale / STEPS
    for axis, name in enumerate(replay.certified):
        # Half of a step of the grid, and roundings of binary64.
        assert np.abs(shown[:, axis] - truth.value(name)).max() <= 0.501 * step
    assert np.allclose(replay.t, instance.times, rtol=1e-5, atol=0)


@pytest.mark.parametrize("case", [entry.id for entry in CASES[:4]])
def test_frames_of_a_method_are_those_of_its_run(replays, sheets, store, case):
    replay = replays[case]
    count = len(replay.bodies)
    assert replay.tracks
    for track in replay.tracks:
        away = track.place.values(len(replay.t), 3 * count).reshape(-1, count, 3)
        shown = places(replay) + away
        off = [
            np.abs(run.position - shown).max()
            for run in trajectories(sheets, store, replay.label, track)
            if run.position.shape == shown.shape
        ]
        step = (replay.place.scale + track.place.scale) / STEPS
        assert min(off) <= 0.51 * step + 1e-13, track.method
        longest = np.linalg.norm(away, axis=-1).max()
        # The largest distance has three digits, each coordinate half a step.
        assert abs(longest - track.largest) <= 0.005 * track.largest + track.place.scale / STEPS


def test_the_turns_of_a_body_are_those_of_its_run(replays, sheets, store):
    replay = replays["free-rigid-body"]
    frames = len(replay.t)
    start = np.array(replay.bodies[0].attitude)
    truth = start + replay.turn.values(frames, 4)
    (exact,) = [track for track in replay.tracks if track.method == replay.anchor]
    run = trajectories(sheets, store, replay.label, exact)[0]
    # Four parts of a quaternion, each off by half a step, turn by at most 2 sqrt(4) times that.
    most = 2.01 * replay.turn.scale / STEPS
    assert angle_between(truth, run.attitude[:, 0]).max() <= most
    coarse = max(replay.tracks, key=lambda track: track.largest_turn)
    runs = trajectories(sheets, store, replay.label, coarse)
    angles = [angle_between(run.attitude[:, 0], truth).max() for run in runs]
    assert any(abs(angle - coarse.largest_turn) <= 0.01 * angle + 2 * most for angle in angles)


def test_spins_of_a_case_that_compares_no_attitude_are_summed(replays):
    replay = replays["rolling"]
    truth = replay.turn.values(len(replay.t), 4) + np.array(replay.bodies[0].attitude)
    # A ball that rolls to the right turns clockwise about z.
    assert truth[-1, 3] < -0.01
    assert np.allclose(np.linalg.norm(truth, axis=1), 1, rtol=0, atol=1e-3)


def test_contacts_are_told_at_the_first_frame_after_them(replays):
    replay = replays["newtons-cradle"]
    assert replay.contacts
    assert replay.touches
    frames = [frame for frame, _ in replay.contacts]
    assert frames == sorted(frames)
    assert 0 < frames[0] < len(replay.t)
