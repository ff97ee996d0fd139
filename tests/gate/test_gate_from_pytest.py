"""A refdem.toml is a test file where the project says so, and an engine object has its gate in a
fixture.
"""

import os
import subprocess
import sys
from importlib.metadata import entry_points

PLUGIN = (
    []
    if any(point.name == "refdem" for point in entry_points(group="pytest11"))
    else ["-p", "refdem.pytest_plugin"]
)

IN_PROCESS = """
import numpy as np
from refdem.core.engine import Engine, Method
from refdem.core.trajectory import Cost, Trajectory


class Mine(Engine):
    name = title = "mine"
    methods = (Method(name="leapfrog", summary="", control="step", order=2),)

    def missing(self):
        return None

    def version(self):
        return "1"

    def fingerprint(self, method):
        return "1"

    def unsupported_motion(self, problem, method):
        if problem.scene.features <= {"spring", "dimension:1"}:
            return None
        return "springs on a line only"

    def run(self, request):
        scene = request.problem.scene
        origin = scene.elements[0].anchor_b[0]
        rate, h = scene.elements[0].stiffness / scene.bodies.mass[0] * FACTOR, request.signed_step
        x, v, rows = scene.bodies.position[0, 0], scene.bodies.velocity[0, 0], []
        for n in range(len(request.problem.times)):
            for _ in range(request.stride if n else 0):
                v -= h / 2 * rate * (x - origin)
                x += h * v
                v -= h / 2 * rate * (x - origin)
            rows.append((x, 0, 0, v, 0, 0))
        rows = np.array(rows)
        positions = rows[:, None, :3]
        velocities = rows[:, None, 3:]
        run = Trajectory.of_points(request.problem.times, positions, velocities)
        return run, Cost(seconds=0.0)


def test_mine(refdem_gate):
    assert refdem_gate(Mine(), ["harmonic-oscillator"], levels=3)
"""


def pytest_run(folder, *arguments):
    environment = os.environ | {"REFDEM_STORE": str(folder / "store.sqlite")}
    environment.pop("PYTEST_XDIST_TESTRUNUID", None)
    environment.pop("PYTEST_XDIST_WORKER", None)
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "no:cacheprovider",
        "-c",
        os.devnull,
        "--rootdir",
        ".",
        *PLUGIN,
        *arguments,
    ]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300
    )


def test_a_refdem_toml_is_collected_only_where_it_is_asked_for(program):
    program.bless()
    assert "no tests ran" in pytest_run(program.folder, ".").stdout
    done = pytest_run(program.folder, "--refdem", "-v", ".")
    assert done.returncode == 0, done.stdout
    assert "harmonic-oscillator/spring/leapfrog/order PASSED" in done.stdout


def test_items_have_stable_names_that_k_and_n_work_with(program):
    program.bless()
    done = pytest_run(program.folder, "--refdem", "-n", "2", "-k", "order or energy", "-v", ".")
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout


def test_a_spoiled_program_fails_in_the_item_of_the_check_with_its_sentence(program):
    program.bless()
    program.spoil("x += h * v", "x -= h * v")
    done = pytest_run(program.folder, "--refdem", ".")
    assert done.returncode == 1
    assert "above the bound" in done.stdout
    assert "harmonic-oscillator/spring/leapfrog/error" in done.stdout


def test_a_missing_baseline_is_a_collection_error_that_says_how_to_bless(program):
    done = pytest_run(program.folder, "--refdem", ".")
    assert done.returncode == 2
    assert "refdem gate --bless --why" in done.stdout


def test_an_engine_object_is_judged_in_process(tmp_path):
    (tmp_path / "test_mine.py").write_text(IN_PROCESS.replace("FACTOR", "1"))
    assert "1 passed" in pytest_run(tmp_path, ".").stdout
    (tmp_path / "test_mine.py").write_text(IN_PROCESS.replace("FACTOR", "1.01"))
    done = pytest_run(tmp_path, ".")
    assert "1 failed" in done.stdout
    assert "mine/leapfrog/error/x" in done.stdout
