"""A fault planted in a copy of an adapter turns the real run red, in the quantity that is wrong."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import refdem
from refdem.core import discovery
from refdem.core.parameters import labelled

PACKAGE = Path(refdem.__file__).parent


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A copy of the installed package that a test may spoil; the store is the copy's own."""
    site = tmp_path_factory.mktemp("site")
    shutil.copytree(PACKAGE, site / "refdem", ignore=shutil.ignore_patterns("__pycache__"))
    beside = PACKAGE.parent / "validation"
    if not (PACKAGE / "validation").is_dir():
        shutil.copytree(beside, site / "validation")
    return site


def run(site, *arguments):
    environment = os.environ | {"PYTHONPATH": str(site), "REFDEM_STORE": str(site / "store.sqlite")}
    command = [
        sys.executable,
        "-c",
        "from refdem.cli import main; main()",
        "run",
        *arguments,
        # Another worker would cost more than it does.
        "--jobs",
        "1",
        "--out",
        str(site / "report"),
    ]
    return subprocess.run(
        command, env=environment, cwd=site, capture_output=True, text=True, timeout=300
    )


FAULTS = [
    (
        "a wrong inertia axis",
        "engines/mujoco/turning.py",
        ("inertia=body.inertia, explicit", "inertia=body.inertia[::-1], explicit"),
        ("free-rigid-body", "mujoco", "rk4"),
        ["error/omega_body.x", "error/attitude"],
    ),
    (
        "no gyroscopic term: a body that is turned as if it were a sphere",
        "engines/mujoco/turning.py",
        (
            "inertia=body.inertia, explicit",
            "inertia=(sum(body.inertia) / 3,) * 3, explicit",
        ),
        ("intermediate-axis[duration=60]", "mujoco", "rk4"),
        ["flips/flips", "angular-momentum/total"],
    ),
    (
        "frequency for angular frequency",
        "engines/mujoco/turning.py",
        ("*body.velocity, *body_omega]", "*body.velocity, *(body_omega / (2 * np.pi))]"),
        ("free-rigid-body", "mujoco", "rk4"),
        ["error/omega_body.x"],
    ),
    (
        "friction that pushes",
        "engines/pymunk/space.py",
        (
            "    joint.max_force = link.normal_force * link.coefficient(0.0)\n",
            (
                "    joint.max_force = 0.0\n    push = link.normal_force * link.coefficient(0.0)\n"
                "    joint.a.velocity_func = lambda b, g, d, dt: setattr(\n"
                "        b, 'velocity', (b.velocity[0] + (push if b.velocity[0] > 0 else -push) /"
                " b.mass * dt, 0.0))\n"
            ),
        ),
        ("coulomb-oscillator", "pymunk", "semi-implicit-euler"),
        ["stop/stop_position", "energy/balance"],
    ),
    (
        "one step late",
        "engines/pymunk/run.py",
        (
            "return _trajectory(request, t, rows)",
            "return _trajectory(request, t, np.concatenate([rows[:1], rows[:-1]]))",
        ),
        ("harmonic-oscillator", "pymunk", "semi-implicit-euler"),
        ["error/x", "error/v"],
    ),
]
PAIR = "hard-spheres[friction=1/4 spins=0,0,1,0,0,-2 masses=1,3 radii=1/2,3/4]"
PYMUNK = (PAIR, "pymunk", "semi-implicit-euler")
PLAIN_PAIR = ("hard-spheres", "pymunk", "semi-implicit-euler")
ELASTICITY = '("elasticity", law.restitution)'
MOMENT = "moment = float(column.inertia[number, 2])"
REBOUND_RESTITUTION = "_always(float(law.restitution))"
# Two spheres that meet are decided after their impact: numbers are misread by a per cent or five.
FAULTS += [
    (
        "friction of a pair misread",
        "engines/pymunk/shapes.py",
        ('("friction", law.friction)', '("friction", 1.025 * law.friction)'),
        PYMUNK,
        ["error/omega1.z", "error/omega2.z"],
    ),
    (
        "restitution of a pair with friction misread",
        "engines/pymunk/shapes.py",
        (ELASTICITY, ELASTICITY.replace("law.", "0.99 * law.")),
        PYMUNK,
        ["error/v1.x", "rigid-impact/restitution"],
    ),
    (
        "inertia of a pair misread",
        "engines/pymunk/space.py",
        (MOMENT, MOMENT.replace("float(", "1.05 * float(")),
        PYMUNK,
        ["angular-momentum/total", "error/omega1.z"],
    ),
    (
        "restitution of a pair misread",
        "engines/pymunk/shapes.py",
        (ELASTICITY, ELASTICITY.replace("law.", "0.99 * law.")),
        PLAIN_PAIR,
        ["error/v1.x", "rigid-impact/restitution"],
    ),
    (
        "restitution of a pair misread in REBOUND",
        "engines/rebound/simulation.py",
        (REBOUND_RESTITUTION, "_always(0.99 * float(law.restitution))"),
        ("hard-spheres", "rebound", "leapfrog"),
        ["error/v1.x", "rigid-impact/restitution"],
    ),
]


def planted(site, where, file, change):
    """A run of (case, engine, method) while `change`, a pair of texts, is made in a file."""
    path = site / "refdem" / file
    sound = path.read_text()
    assert sound.count(change[0]) == 1
    path.write_text(sound.replace(*change))
    try:
        case, _, setting = where[0].partition("[")
        given = [word for part in setting.rstrip("]").split() for word in ("--set", part)]
        return run(site, case, *given, "--engine", where[1], "--method", where[2])
    finally:
        path.write_text(sound)


@pytest.mark.parametrize(("name", "file", "change", "where", "named"), FAULTS)
def test_a_planted_fault_turns_the_run_red_and_is_named(copy, name, file, change, where, named):
    done = planted(copy, where, file, change)
    assert done.returncode == 1, done.stdout + done.stderr
    for quantity in named:
        title = rf"FAIL +{re.escape(where[0].split('[')[0])}.*/{where[1]}/{where[2]}/{quantity}"
        assert re.search(title + r"\n +\S.*above the bound", done.stdout)


def test_the_copy_is_green_when_nothing_is_planted_and_runs_again_only_what_changed(copy):
    first = run(copy, "harmonic-oscillator", "--engine", "pymunk", "--engine", "reference")
    assert first.returncode == 0, first.stdout + first.stderr
    made = int(re.search(r"(\d+) runs made", first.stdout)[1])
    assert (
        "0 runs made"
        in run(copy, "harmonic-oscillator", "--engine", "pymunk", "--engine", "reference").stdout
    )
    adapter = copy / "refdem" / "engines" / "pymunk" / "run.py"
    adapter.write_text(adapter.read_text() + "\n# a comment\n")
    again = int(
        re.search(
            r"(\d+) runs made",
            run(copy, "harmonic-oscillator", "--engine", "pymunk", "--engine", "reference").stdout,
        )[1]
    )
    assert 0 < again < made


RESOLUTION = Path(__file__).parents[2] / "reports" / "resolution.jsonl"
HERTZ = ("hertz-spheres[duration=1/20 samples=8]", "pymunk", "semi-implicit-euler")
FIELD = ("asymmetric-field[x0=-1/4 v0=1]", "mujoco", "euler")
SPUN = ("free-rigid-body[omega_body=0,0,1 duration=5 samples=16]", "rebound", "bs")
UNEQUAL = ("hard-spheres[restitution=1 offset=0,0 masses=1,1000000]", *PYMUNK[1:])
SOFT = ("engines/pymunk/callbacks.py", "law.stiffness, law.exponent, law.damping")
SLIDING = ("engines/mujoco/joints.py", "self.body.mass")
MOMENTS = ("engines/rebound/fields.py", "scene.bodies.inertia[rotors]")
OMEGA = ("engines/rebound/simulation.py", "scene.bodies.omega[rotors]")
MISREAD = [
    (HERTZ, "stiffness of the contact", 1.01, SOFT),
    (HERTZ, "stiffness of the contact", 1.05, SOFT),
    (FIELD, "mass", 1.01, SLIDING),
    (FIELD, "mass", 1.05, SLIDING),
    (SPUN, "moment of inertia 3", 1.05, MOMENTS),
    (SPUN, "spin", 1.01, OMEGA),
]


def smallest_of(where, name):
    """What reports/resolution.jsonl says of a number: its smallest misreading that is seen."""
    case, given = labelled(where[0])
    place = (discovery.case(case).at(**given).label, *where[1:])
    for line in RESOLUTION.read_text().splitlines():
        row = json.loads(line)
        if (row["label"], row["engine"], row["method"]) == place:
            (number,) = [one for one in row["numbers"] if one["number"] == name]
            return number.get("smallest", float("inf"))
    raise AssertionError(f"no row of {place}")


@pytest.mark.parametrize(("where", "number", "factor", "read"), MISREAD)
def test_what_a_copy_misreads_is_seen_as_the_page_of_resolution_says(
    copy, where, number, factor, read
):
    file, words = read
    done = planted(copy, where, file, (words, f"{factor} * {words}"))
    assert done.returncode == int(smallest_of(where, number) <= factor - 1), done.stdout


def test_a_run_may_see_a_misread_start_that_its_own_runs_do_not_show(copy):
    """Body 1 is a million times heavier and stands still but for a millionth of its motion."""
    words = "column.position[number, :2]"
    assert smallest_of(UNEQUAL, "position of body 1") == float("inf")
    change = (words, f"({words} * (1.05 if number == 1 else 1.0))")
    done = planted(copy, UNEQUAL, "engines/pymunk/space.py", change)
    assert done.returncode == 1, done.stdout + done.stderr
    failed = set(re.findall(r"FAIL +\S.*/semi-implicit-euler/(\S+/\S+)", done.stdout))
    assert failed == {"symmetry/shifted", "symmetry/relabelled"}
