"""Peers between events: heyoka's collision against certified truth, both peers' section of a belt
against the reference's.
"""

import numpy as np
import pytest

from refdem.bench.entrant import Entrant
from refdem.bench.peers._belt import Belt, by_heyoka, by_scipy
from refdem.bench.peers._oblique import oblique
from refdem.bench.peers.heyoka import PEER
from refdem.bench.session import sampled_truth
from refdem.core import discovery
from refdem.engines.reference import ENGINE

RUBS = {"damping": "1", "angle": "0.6", "friction": "1/4", "tangential_stiffness": "96"}
PUSHES = {"damping": "1", "cutoff": "zero_force"}


@pytest.mark.parametrize(
    "given",
    [
        RUBS | {"masses": "1,2", "spins": "0,0,1,0,0,-2"},
        RUBS | {"damping": "0"},
        {"damping": "1", "angle": "0.6"},
    ],
)
def test_heyoka_holds_slips_and_parts_as_truth_does(given: dict[str, str]) -> None:
    instance = discovery.case("two-spheres").at(**given, samples="16")
    assert PEER.unsupported(instance.motion, PEER.method("taylor-events")) is None
    entrant = Entrant(instance, PEER, PEER.method("taylor-events"), (), is_peer=True)
    errors = entrant.errors(entrant.run(1e-12)[0], sampled_truth(instance, []), 1e-12)
    assert max(errors.values()) < 1e-11


def test_pairs_that_are_pulled_no_more_or_leave_the_plane_are_not_said() -> None:
    for given in (PUSHES, {"friction": "1/4"}, RUBS | {"spins": "0,1,0,0,0,0"}):
        assert oblique(discovery.case("two-spheres").at(**given).motion.scene) is None
    assert oblique(discovery.case("hertz-spheres").at().motion.scene) is None


def by_small_steps(belt: Belt, tolerance: float):
    """Slip and stick by Euler's midpoint rule in steps of `tolerance`, events on straight lines:
    without a package.
    """

    def slip(t, x, u, side, end, frequency):
        passed = []
        speed = belt.slider.belt_velocity

        def rate(t, x, u):
            return belt.pull(t, frequency, x) - side * belt.friction(side * u)

        while t < end:
            du = rate(t, x, u) * tolerance / 2
            a = u + du
            b = rate(t + tolerance / 2, x + (u + speed) * tolerance / 2, u + du)
            before = (t, x, u)
            t = t + tolerance
            x = x + (a + speed) * tolerance
            u = u + b * tolerance
            if (before[2] + speed) * (u + speed) < 0:
                passed.append((t, x + belt.anchor))
            if side * u < 0:
                break
        return t, x, passed

    def stick(t, pull, end, frequency):
        while t < end and abs(pull) <= belt.limit:
            pull -= (
                belt.amplitude * frequency * np.sin(frequency * t) + belt.slider.belt_velocity
            ) * tolerance
            t += tolerance
        return t

    return slip, stick


MAKERS = {"small steps": by_small_steps, "heyoka": by_heyoka, "scipy": by_scipy}


@pytest.mark.parametrize("name", MAKERS)
def test_a_section_of_a_peer_is_that_of_the_reference(name: str) -> None:
    level, bound = (1e-3, 3e-2) if name == "small steps" else (1e-11, 5e-8)
    problem = discovery.case("stick-slip").at().motion
    belt = Belt.of(problem.scene)
    frequency = np.array([0.9, 2.0])
    places = [belt.walked(float(w), 12, 4, *MAKERS[name](belt, level)) for w in frequency]
    exact = ENGINE.section(problem, frequency, skip=4, keep=8).places
    assert [len(row) for row in places] == [len(row) for row in exact]
    assert max(np.abs(np.array(a) - b).max() for a, b in zip(places, exact, strict=True)) < bound
