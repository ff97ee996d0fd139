"""Derivatives of a driver that puts dual numbers into a scene of `served`, here numbers of a class
of its own; a driver runs as a program, since `served` leads standard output elsewhere.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

CODES = Path(__file__).resolve().parents[3] / "validation/codes"
DRIVER = """
import sys
sys.path.insert(0, sys.argv.pop(1))
import served

class Dual:
    def __init__(self, value, slopes=()):
        self.value, self.slopes = value, slopes

    def __float__(self):
        return self.value

    def __radd__(self, constant):
        return Dual(constant + self.value, self.slopes)

    def __mul__(self, step):
        return Dual(self.value * step, [slope * step for slope in self.slopes])

SIZES = {"position": 3, "velocity": 3, "gravity": 3, "attitude": 4, "omega": 3}

def add(a, b):
    return Dual(a.value + b.value, [x + y for x, y in zip(a.slopes, b.slopes)])

def fall(scene, number):
    body = scene.bodies[0]
    r = [number(x) for x in body["position"]]
    v = [number(x) for x in body["velocity"]]
    g = [number(x) for x in scene.gravity]

    def advance():
        v[:] = [add(a, b * scene.step) for a, b in zip(v, g)]
        r[:] = [add(a, b * scene.step) for a, b in zip(r, v)]

    scene.sampled(advance, lambda: [(list(r), list(v), body["attitude"], body["omega"])])

def differentiate(scene):
    fall(scene, Dual)
    beside = scene.with_numbers(lambda value, k: value)
    rates = [change.bodies[0] | {"gravity": change.gravity} for change in scene.changes()]
    r, v, g, q, w = (
        [[rate[name][axis] for rate in rates] for axis in range(size)]
        for name, size in SIZES.items()
    )

    def add(x, y, step):
        return [[a + step * b for a, b in zip(*pair)] for pair in zip(x, y)]

    def advance():
        v[:] = add(v, g, scene.step)
        r[:] = add(r, v, scene.step)

    beside.sampled(advance, lambda: [(list(r), list(v), q, w)])
    scene.differentiated(beside, lambda x: x)

def solve(scene):
    if scene.method == "linear":
        differentiate(scene)
        return
    count = len(scene.sensitivities)
    units = [[float(i == k) for i in range(count)] for k in range(count)]

    def number(x):
        return x if isinstance(x, Dual) else Dual(x, [0.0] * count)

    fall(scene, number)
    if count:
        dual = scene.with_numbers(lambda value, k: Dual(value, units[k]))
        fall(dual, number)
        scene.differentiated(dual, lambda x: getattr(x, "slopes", ()))

served.run(solve, "uniform_gravity")
"""
STEP = 0.25
TIMES = (0.0, 0.5, 1.0)


def answers(folder: Path, sensitivities: list[str], method: str = "") -> tuple[list[str], Path]:
    """The lines of a trajectory of a point that falls, and where its derivatives would be."""
    body = {
        "mass": 2.0,
        "inertia": [0.0, 0.0, 0.0],
        "shape": {"kind": "point"},
        "position": [1.0, 2.0, 3.0],
        "velocity": [4.0, 5.0, 6.0],
        "attitude": [1.0, 0.0, 0.0, 0.0],
        "omega": [0.0, 0.0, 0.0],
        "fixed": False,
    }
    request = {
        "method": method,
        "step": STEP,
        "stride": 2,
        "times": TIMES,
        "scene": {
            "bodies": [body],
            "elements": [{"kind": "uniform_gravity", "g": [0.0, 0.0, -8.0]}],
        },
        "sensitivities": sensitivities,
    }
    (folder / "driver.py").write_text(DRIVER)
    (folder / "request.json").write_text(json.dumps(request))
    slopes = folder / "sensitivities.csv"
    files = ["request.json", "trajectory.csv", slopes.name]
    subprocess.run(
        [sys.executable, "driver.py", str(CODES), *files], cwd=folder, check=True, timeout=60
    )
    return (folder / "trajectory.csv").read_text().splitlines(), slopes


@pytest.mark.parametrize("method", ["dual numbers", "linear"])
def test_derivatives_by_each_asked_number_follow_the_rows_of_the_trajectory(tmp_path, method):
    keys = ["scene.elements.0.g.2", "scene.bodies.0.velocity.1", "scene.bodies.0.omega.0"]
    trajectory, path = answers(tmp_path, keys, method)
    header, *rows = path.read_text().splitlines()
    assert header == f"number,{trajectory[0]}"
    found = [row.split(",") for row in rows]
    assert [(key, float(t), body) for key, t, body, *_ in found] == [
        (key, t, "0") for key in keys for t in TIMES
    ]
    for key, word, _, *cells in found:
        t = float(word)
        expected = [0.0] * 13
        if key == keys[0]:
            # After n steps v = g n h, and z = g h^2 n (n + 1)/2 = g t (t + h)/2.
            expected[2] = t * (t + STEP) / 2
            expected[5] = t
        if key == keys[1]:
            expected[1] = t
            expected[4] = 1.0
        if key == keys[2]:
            expected[10] = 1.0
        assert [float(cell) for cell in cells] == pytest.approx(expected, abs=1e-15)


def test_a_trajectory_is_the_same_with_derivatives_and_without(tmp_path):
    without, path = answers(tmp_path, [])
    assert not path.exists()
    beside, path = answers(tmp_path, ["scene.bodies.0.mass"])
    assert path.exists()
    assert beside == without
