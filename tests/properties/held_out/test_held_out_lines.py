"""Certified lines against lines.txt, which lines_by_mpmath.py has made: no code is shared."""

import json
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from refdem.checks.spectrum import lines_of
from refdem.core import discovery
from refdem.truth.sampled import sampled

CYCLE_FOUND = 1e-6
"""Part of a motion's size by which a line may be off whose frequency w is found where the least is
left: a square is flat there to 1e-8 of w, and w acts for 100 s.
"""
MAP_ROUNDINGS = 200
"""Roundings of 1e-16 of a line by its map from samples, which are some ten times larger in all."""


def questions():
    """(case, parameters as JSON): {line: complex amplitude}."""
    found = defaultdict(dict)
    for text in (Path(__file__).parent / "lines.txt").read_text().splitlines():
        case, given, name, real, imaginary = json.loads(text)
        found[case, json.dumps(given)][name] = complex(float(real), float(imaginary))
    return dict(found)


@pytest.mark.parametrize(("case", "given"), questions())
def test_certified_lines_are_those_of_eighty_digits(case: str, given: str) -> None:
    expected = questions()[case, given]
    instance = discovery.case(case).at(**json.loads(given))
    truth = sampled(instance.truth(), instance.times.tolist())
    found = lines_of(instance.scene, instance.times, truth.value("x"))
    assert found is not None
    names = [line.name for line in found.lines]
    radius = found.amplified(truth.radius("x"))
    amplitudes = found.rows @ truth.value("x")
    part = MAP_ROUNDINGS * 2.0**-53
    if case == "van-der-pol":
        assert set(expected) <= set(names)
        part = CYCLE_FOUND
    else:
        assert list(expected) == names
    size = np.max(np.abs(truth.value("x")))
    for name, value in expected.items():
        k = names.index(name)
        assert abs(amplitudes[k] - value) <= radius[k] + part * size
