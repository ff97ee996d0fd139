"""The smoke test against a transparent engine in numpy: silent when it is right, and it names what is wrong when it lies."""

from functools import cache

import numpy as np
import pytest

from refdem.campaign.probes import probes
from refdem.campaign.smoke import smoke
from refdem.core.engine import Engine, Method
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import EngineError, UnsupportedError
from refdem.mechanics.quaternion import conjugate, product, rotated
from refdem.scene import Scene
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

SUBSTEPS = 4


def derivative(scene, r, v, q, w):
    """Rates of position, velocity, attitude and body omega for gravity, springs to the origin and Euler's equations."""
    force = sum((np.array(e.g) for e in scene.all(UniformGravity)), np.zeros(3)) + 0 * r
    for spring in scene.all(Spring):
        force[spring.a] -= spring.stiffness * r[spring.a] / scene.bodies.mass[spring.a]
    inertia = np.where(scene.bodies.inertia > 0, scene.bodies.inertia, 1.0)
    turn = product(q, np.pad(w, ((0, 0), (1, 0)))) / 2
    return [v, force, turn, np.cross(inertia * w, w) / inertia]


@cache
def honest(scene_json, interval, count):
    """Columns of the right trajectory, by classical Runge-Kutta."""
    scene, h = Scene.from_json(scene_json), interval / SUBSTEPS
    b = scene.bodies
    state = [b.position, b.velocity, b.attitude, rotated(conjugate(b.attitude), b.omega)]
    rows = [state]
    for step in range((count - 1) * SUBSTEPS):
        k1 = derivative(scene, *state)
        k2 = derivative(scene, *(s + h / 2 * k for s, k in zip(state, k1, strict=True)))
        k3 = derivative(scene, *(s + h / 2 * k for s, k in zip(state, k2, strict=True)))
        k4 = derivative(scene, *(s + h * k for s, k in zip(state, k3, strict=True)))
        state = [s + h / 6 * (a + 2 * b + 2 * c + d) for s, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)]
        if step % SUBSTEPS == SUBSTEPS - 1:
            rows.append(state)
    position, velocity, attitude, body_omega = (np.array(column) for column in zip(*rows, strict=True))
    return {"position": position, "velocity": velocity, "attitude": attitude, "omega": rotated(attitude, body_omega)}


class Plain(Engine):
    """The right trajectory; `lie` changes it before it is handed back."""

    name = "plain"
    title = "Plain"
    methods = (Method(name="best", summary="Runge-Kutta", control="exact"), Method(name="never", summary="none", control="exact"))

    def __init__(self, lie=lambda request, columns: columns):
        self.lie = lie

    def missing(self):
        return None

    def version(self):
        return "1"

    def fingerprint(self, method):
        return "plain"

    def refusal(self, problem, method):
        if method.name == "never":
            return "nothing at all"
        others = {e.kind for e in problem.scene.elements} - {"uniform_gravity", "spring"}
        return f"no {others}" if others else None

    def run(self, request):
        problem = request.problem
        columns = honest(problem.scene.to_json(), problem.interval, len(problem.times))
        lied = self.lie(request, {"t": problem.times, **columns})
        return Trajectory(**lied), Cost(seconds=0.0)


def changed(name, change):
    """A lie about one column."""
    return lambda request, columns: columns | {name: np.ascontiguousarray(change(columns[name]))}


def delayed(request, columns):
    return columns | {name: np.concatenate([columns[name][:1], columns[name][:-1]]) for name in columns if name != "t"}


LIES = {
    "a clock that starts at zero": (changed("t", lambda t: t - t[0]), "later: clock"),
    "gravity upwards": (changed("velocity", np.abs), "fall in space: velocity"),
    "millimetres": (changed("position", lambda r: 1000 * r), "line: position"),
    "y and z swapped": (changed("position", lambda r: r[..., [0, 2, 1]]), "plane: position"),
    "bodies swapped": (changed("position", lambda r: r[:, ::-1]), "two bodies: position"),
    "quaternion with w last": (changed("attitude", lambda q: np.roll(q, -1, axis=-1)), "quarter turn: attitude"),
    "quaternion from space to body": (changed("attitude", conjugate), "quarter turn: attitude"),
    "omega in body axes": (lambda _, c: c | {"omega": rotated(conjugate(c["attitude"]), c["omega"])}, "tipped body: omega"),
    "degrees a second": (changed("omega", np.degrees), "quarter turn: omega"),
    "turned axes of inertia": (changed("omega", lambda w: np.roll(w, 1, axis=-1)), "wobble about x: omega_body"),
    "a sample late": (delayed, "spring: position"),
    "a first sample after a step": (lambda r, c: c | {"position": c["position"] + 1e-6 * c["velocity"]}, "line: first sample"),
}


def test_nothing_is_said_against_an_adapter_that_is_right():
    findings = smoke(Plain())
    assert {f.outcome for f in findings if not f.quantity.startswith(("friction", "hanging", "circle", "knock"))} == {"pass"}
    assert {f.outcome for f in findings if f.quantity in ("friction", "hanging rod", "circle", "knock")} == {"unsupported"}


def test_what_an_engine_refuses_when_it_runs_is_unsupported_and_no_error():
    def refuses(request, columns):
        if len(request.problem.scene.bodies) > 1:
            raise UnsupportedError("one body only")
        return columns

    findings = smoke(Plain(refuses))
    assert [(f.outcome, f.sentence) for f in findings if f.quantity == "two bodies"] == [("unsupported", "one body only")]
    assert "error" not in {f.outcome for f in findings}


@pytest.mark.parametrize("name", LIES)
def test_an_adapter_that_lies_is_caught_where_it_lies(name):
    lie, quantity = LIES[name]
    failed = [f for f in smoke(Plain(lie)) if f.outcome == "fail"]
    assert quantity in [f.quantity for f in failed]
    assert all(f.margin < 0 for f in failed)


def test_the_other_sign_of_a_quaternion_is_the_same_attitude():
    assert all(f.outcome != "fail" for f in smoke(Plain(changed("attitude", lambda q: -q))))


def test_a_sentence_says_what_came_and_what_must_come():
    found = {f.quantity: f.sentence for f in smoke(Plain(changed("position", lambda r: -r)))}
    assert "at t = 1 s it is [ 2., -0., -0.] and must be [-2.,  0.,  0.]" in found["line: position"]
    assert "the x axis, metres and seconds" in found["line: position"]


def test_a_crash_and_a_missing_row_are_errors_that_name_the_method():
    def raising(request, columns):
        raise ZeroDivisionError("a bug")

    def short(request, columns):
        return {name: values[:-1] for name, values in columns.items()}

    for lie, words in ((raising, "best on 'line': ZeroDivisionError: a bug"), (short, "(32, 1, 3)")):
        found = {f.quantity: f for f in smoke(Plain(lie))}
        assert found["line"].outcome == "error"
        assert words in found["line"].sentence


def test_a_trajectory_that_is_not_finite_is_an_error():
    def nan(request, columns):
        with pytest.raises(EngineError):
            Trajectory(**columns | {"position": np.nan * columns["position"]})
        return columns | {"position": np.nan * columns["position"]}

    assert "error" in {f.outcome for f in smoke(Plain(nan))}


@pytest.mark.parametrize("probe", probes(), ids=lambda probe: probe.name)
def test_every_probe_starts_where_its_scene_does(probe):
    bodies = probe.scene.bodies
    expected = probe.expected(probe.times - probe.times[0])
    for name in ("position", "velocity", "attitude", "omega"):
        if name in expected:
            np.testing.assert_allclose(expected[name][0], getattr(bodies, name), atol=1e-15)
    assert set(expected)


def test_velocities_of_the_probes_are_the_rates_of_their_positions():
    for probe in probes():
        t = np.linspace(0.0, 1.0, 2001)
        expected = probe.expected(t)
        if {"position", "velocity"} <= set(expected):
            rate = np.gradient(expected["position"], t, axis=0)
            np.testing.assert_allclose(rate[5:-5], expected["velocity"][5:-5], atol=1e-5)
