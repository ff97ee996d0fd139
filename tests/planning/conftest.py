"""Engines that lie, crash and hang, installed for the session the way another package would install
one.
"""

import sys

import pytest

ENGINE = '''
import os
import time

import numpy as np

from refdem.core.engine import Engine, Method
from refdem.core.trajectory import Cost, Trajectory
from refdem.scene.elements.spring import Spring

LEAPFROG = {
    "control": "step",
    "order": 2,
    "symplectic": True,
    "reversible": True,
    "backward": True,
    "summary": "leapfrog",
}
METHODS = "good crash nan short late raises refuses wrong-force drag forgetful"


class Played(Engine):
    """A harmonic oscillator by leapfrog in plain Python, with one misbehaviour a method."""

    name = "played"
    title = "Played"
    methods = tuple(Method(name=name, **LEAPFROG) for name in METHODS.split())

    def missing(self):
        return None

    def version(self):
        return "1.0"

    def fingerprint(self, method):
        return "played 1"

    def unsupported_motion(self, problem, method):
        if method.name == "refuses":
            return "no <b>springs</b> today"
        if problem.scene.features <= {"spring", "dimension:1"}:
            return None
        return "only springs in one dimension"

    def run(self, request):
        (spring,), bodies = request.problem.scene.all(Spring), request.problem.scene.bodies
        name, h, stride = request.method, request.signed_step, request.stride
        if name == "crash":
            os._exit(7)
        while name == "hang":
            pass
        if name == "raises":
            raise ZeroDivisionError("a bug")
        rate = spring.stiffness / bodies.mass[0] * (1.001 if name == "wrong-force" else 1.0)
        drag = 1e-4 if name == "drag" else 0.0
        origin = float(spring.anchor_b[0])
        x, v = float(bodies.position[0, 0]), float(bodies.velocity[0, 0])
        if name == "forgetful":
            v += 1e-7 * os.getpid() / 4e6 + 1e-9 * time.perf_counter()
        rows = [(x, v)]
        for _ in range(len(request.problem.times) - 1):
            for _ in range(stride):
                v -= 0.5 * h * (rate * (x - origin) + drag * v)
                x += h * v
                v -= 0.5 * h * (rate * (x - origin) + drag * v)
            rows.append((x, v))
        x, v = np.array(rows).T
        t = request.problem.times * (1.01 if name == "late" else 1.0)
        if name == "nan":
            x[5] = np.nan
        position, velocity = np.zeros((2, len(t), 1, 3))
        position[:, 0, 0], velocity[:, 0, 0] = x, v
        if name == "short":
            t, position, velocity = t[:-3], position[:-3], velocity[:-3]
        cost = Cost(seconds=0.0, steps=stride * (len(t) - 1))
        return Trajectory.of_points(t, position, velocity), cost


class Stuck(Played):
    """An engine of its own for what hangs: its campaign has a short time limit, and no other method
    comes near one.
    """

    name = "stuck"
    title = "Stuck"
    methods = (Method(name="hang", **LEAPFROG),)


ENGINE = Played()
STUCK = Stuck()
'''


@pytest.fixture(scope="session")
def played(tmp_path_factory):
    """The engines `played` and `stuck` through entry points; spawned workers see it because they
    inherit sys.path.
    """
    from refdem.core import discovery

    folder = tmp_path_factory.mktemp("site")
    (folder / "played_engine.py").write_text(ENGINE)
    info = folder / "played_engine-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: played-engine\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[refdem.engines]\nplayed = played_engine:ENGINE\nstuck = played_engine:STUCK\n"
    )
    sys.path.insert(0, str(folder))
    discovery._others.cache_clear()
    yield "played"
    sys.path.remove(str(folder))
    discovery._others.cache_clear()
