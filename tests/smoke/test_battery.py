"""The smoke test against a transparent engine in numpy: silent when it is right, and it names what
is wrong when it lies.
"""

import re
from dataclasses import replace
from functools import cache

import msgspec
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.engine import Engine, Method
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import EngineError, UnsupportedError
from refdem.faults.change import of_bodies, of_elements, scaled
from refdem.faults.fault import Carrier, Fault
from refdem.mechanics.quaternion import conjugate, product, rotated
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.smoke.battery import BOUND, SMOOTH_BOUND, STEP, every_probe, smoke
from refdem.smoke.diagnosis import distance, likely_causes

SUBSTEPS = 4
SAID = {"uniform_gravity", "spring"}
"""Elements that the engine of this test has."""


def derivative(scene, gyroscopic, r, v, q, w):
    """Rates of position, velocity, attitude and body omega for gravity, springs and Euler's
    equations, J w' = T - g w x J w.
    """
    mass = scene.bodies.mass
    acceleration = sum((np.array(e.g) for e in scene.all(UniformGravity)), np.zeros(3)) + 0 * r
    torque = 0 * r  # in body axes
    for spring in scene.all(Spring):
        ends = [
            (body, np.array(anchor))
            for body, anchor in ((spring.a, spring.anchor_a), (spring.b, spring.anchor_b))
        ]
        first, second = (
            anchor if body < 0 else r[body] + rotated(q[body], anchor) for body, anchor in ends
        )
        distance = np.linalg.norm(second - first)
        pull = spring.stiffness * (1 - spring.length / distance) * (second - first)
        for (body, anchor), force in zip(ends, (pull, -pull), strict=True):
            if body >= 0:
                acceleration[body] += force / mass[body]
                torque[body] += np.cross(anchor, rotated(conjugate(q[body]), force))
    acceleration[scene.bodies.fixed] = 0.0
    inertia = np.where(scene.bodies.inertia > 0, scene.bodies.inertia, 1.0)
    turn = product(q, np.pad(w, ((0, 0), (1, 0)))) / 2
    return [
        v,
        acceleration,
        turn,
        np.where(
            scene.bodies.inertia > 0,
            (gyroscopic * np.cross(inertia * w, w) + torque) / inertia,
            0.0,
        ),
    ]


@cache
def honest(scene_json, interval, count, gyroscopic=1.0):
    """Columns of the right trajectory, by classical Runge-Kutta."""
    scene = Scene.from_json(scene_json)
    h = interval / SUBSTEPS
    b = scene.bodies
    state = [b.position, b.velocity, b.attitude, rotated(conjugate(b.attitude), b.omega)]
    rows = [state]
    for step in range((count - 1) * SUBSTEPS):
        k1 = derivative(scene, gyroscopic, *state)
        k2 = derivative(scene, gyroscopic, *(s + h / 2 * k for s, k in zip(state, k1, strict=True)))
        k3 = derivative(scene, gyroscopic, *(s + h / 2 * k for s, k in zip(state, k2, strict=True)))
        k4 = derivative(scene, gyroscopic, *(s + h * k for s, k in zip(state, k3, strict=True)))
        state = [
            s + h / 6 * (a + 2 * b + 2 * c + d)
            for s, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)
        ]
        if step % SUBSTEPS == SUBSTEPS - 1:
            rows.append(state)
    position, velocity, attitude, body_omega = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    return {
        "position": position,
        "velocity": velocity,
        "attitude": attitude,
        "omega": rotated(attitude, body_omega),
    }


class Plain(Engine):
    """The right trajectory; `lie` changes it before it is handed back."""

    name = "plain"
    title = "Plain"
    methods = (
        Method(name="best", summary="Runge-Kutta", control="exact"),
        Method(name="never", summary="none", control="exact"),
    )

    def __init__(self, lie=lambda request, columns: columns):
        self.lie = lie

    def missing(self):
        return None

    def version(self):
        return "1"

    def fingerprint(self, method):
        return "plain"

    def unsupported_motion(self, problem, method):
        if method.name == "never":
            return "nothing at all"
        others = {e.kind for e in problem.scene.elements} - SAID
        if others:
            return f"no {others}"
        return None

    def run(self, request):
        problem = request.problem
        columns = honest(problem.scene.to_json(), problem.interval, len(problem.times))
        lied = self.lie(request, {"t": problem.times, **columns})
        return Trajectory(**lied), Cost(seconds=0.0)


def changed(name, change):
    """A lie about one column."""
    return lambda request, columns: columns | {name: np.ascontiguousarray(change(columns[name]))}


def lever(request, columns):
    """R d (T, N, 3) of a point displaced by d = (0.25, -0.5, 0.125) m in body axes."""
    return rotated(columns["attitude"], np.array([0.25, -0.5, 0.125]))


def swept(request, columns):
    """omega x R d (T, N, 3)."""
    return np.cross(columns["omega"], lever(request, columns))


def another_point(request, columns):
    return columns | {"position": columns["position"] + lever(request, columns)}


def velocity_of_another_point(request, columns):
    return columns | {"velocity": columns["velocity"] + swept(request, columns)}


def displaced_mass(request, columns):
    """The frame of the body starts where it should; the centre of mass, displaced in it, flies as
    the centre would.
    """
    arm = lever(request, columns)
    sweep = swept(request, columns)
    since = (columns["t"] - columns["t"][0])[:, None, None]
    position = columns["position"] + arm[:1] + since * sweep[:1] - arm
    return columns | {"position": position, "velocity": columns["velocity"] + sweep[:1] - sweep}


def rotating_frame(request, columns):
    """Seen from axes that turn about z at 0.5 rad/s."""
    angle = 0.5 * (columns["t"] - columns["t"][0])
    back = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, -np.sin(angle / 2)], axis=-1)[:, None]
    return columns | {"position": rotated(back, columns["position"])}


def without_anchors(request, columns):
    """What an adapter hands back that ties every spring to a centre."""
    scene = request.problem.scene
    centred = [
        (
            msgspec.structs.replace(
                e, anchor_a=(0.0, 0.0, 0.0), anchor_b=e.anchor_b if e.b < 0 else (0.0, 0.0, 0.0)
            )
            if isinstance(e, Spring)
            else e
        )
        for e in scene.elements
    ]
    changed = Scene(scene.bodies, tuple(centred))
    return {
        "t": columns["t"],
        **honest(changed.to_json(), request.problem.interval, len(request.problem.times)),
    }


def numbers_swapped(request, columns):
    """Elements act on the other of two bodies."""
    scene = request.problem.scene
    count = len(scene.bodies)
    other = [
        (
            msgspec.structs.replace(e, a=count - 1 - e.a, b=count - 1 - e.b if e.b >= 0 else -1)
            if isinstance(e, Spring)
            else e
        )
        for e in scene.elements
    ]
    changed = Scene(scene.bodies, tuple(other))
    return {
        "t": columns["t"],
        **honest(changed.to_json(), request.problem.interval, len(request.problem.times)),
    }


def fixed_falls(request, columns):
    """What an adapter hands back that lets a fixed body move like any other."""
    problem = request.problem
    bodies = problem.scene.bodies
    free = replace(bodies, fixed=np.zeros_like(bodies.fixed))
    changed = Scene(free, problem.scene.elements)
    return {"t": columns["t"], **honest(changed.to_json(), problem.interval, len(problem.times))}


def one_length(request, columns):
    """What an adapter hands back that gives every spring the length of the first one."""
    problem = request.problem
    scene = problem.scene
    springs = scene.all(Spring)
    elements = tuple(
        msgspec.structs.replace(element, length=springs[0].length)
        if isinstance(element, Spring)
        else element
        for element in scene.elements
    )
    changed = Scene(scene.bodies, elements)
    return {"t": columns["t"], **honest(changed.to_json(), problem.interval, len(problem.times))}


def moments_reordered(*axes):
    """A lie: moments of inertia come in another order."""

    def lie(request, columns):
        problem = request.problem
        bodies = problem.scene.bodies
        changed = Scene(replace(bodies, inertia=bodies.inertia[:, axes]), problem.scene.elements)
        return {
            "t": columns["t"],
            **honest(changed.to_json(), problem.interval, len(problem.times)),
        }

    return lie


def gyroscopic_term(factor):
    """A lie: the gyroscopic term is multiplied by a factor."""

    def lie(request, columns):
        problem = request.problem
        text = problem.scene.to_json()
        return {"t": columns["t"], **honest(text, problem.interval, len(problem.times), factor)}

    return lie


def delayed(request, columns):
    return columns | {
        name: np.concatenate([columns[name][:1], columns[name][:-1]])
        for name in columns
        if name != "t"
    }


LIES = {
    "a clock that starts at zero": (changed("t", lambda t: t - t[0]), "later: clock", ""),
    "springs of one length": (one_length, "two springs: position", ""),
    "a fixed body that moves": (fixed_falls, "hanging from a fixed body: position", ""),
    "gravity upwards": (changed("velocity", np.abs), "fall in space: velocity", ""),
    "millimetres": (
        changed("position", lambda r: 1000 * r),
        "line: position",
        "position is in millimetres",
    ),
    "y and z swapped": (
        changed("position", lambda r: r[..., [0, 2, 1]]),
        "plane: position",
        "the axes of position are in the order xzy instead of xyz",
    ),
    "bodies swapped": (
        changed("position", lambda r: r[:, ::-1]),
        "two bodies: position",
        "the bodies are in reverse order",
    ),
    "quaternion with w last": (
        changed("attitude", lambda q: np.roll(q, -1, axis=-1)),
        "quarter turn: attitude",
        "the quaternion is in the order x, y, z, w",
    ),
    "quaternion from space to body": (
        changed("attitude", conjugate),
        "quarter turn: attitude",
        "the quaternion rotates space to body axes",
    ),
    "omega in body axes": (
        lambda _, c: c | {"omega": rotated(conjugate(c["attitude"]), c["omega"])},
        "tipped body: omega",
        "omega is in body axes instead of space axes",
    ),
    "degrees a second": (changed("omega", np.degrees), "quarter turn: omega", "degrees per second"),
    "turned axes of inertia": (
        changed("omega", lambda w: np.roll(w, 1, axis=-1)),
        "wobble about x: omega_body",
        "",
    ),
    "moments of inertia in another order": (
        moments_reordered(1, 2, 0),
        "tumble: omega",
        "the moments of inertia are in the order yzx",
    ),
    "no gyroscopic term": (
        gyroscopic_term(0.0),
        "wobble about x: omega_body",
        "the gyroscopic term omega x J omega of Euler's equations is missing",
    ),
    "no gyroscopic term while a body tumbles": (
        gyroscopic_term(0.0),
        "tumbling throw: attitude",
        "the gyroscopic term omega x J omega of Euler's equations is missing",
    ),
    "a gyroscopic term with the other sign": (
        gyroscopic_term(-1.0),
        "wobble about z: angular_momentum",
        "the gyroscopic term omega x J omega of Euler's equations has the opposite sign",
    ),
    "a sample late": (delayed, "spring: position", "each row is that of the previous sample"),
    "a first sample after a step": (
        lambda r, c: c | {"position": c["position"] + 1e-6 * c["velocity"]},
        "line: first sample",
        "",
    ),
    "another point": (
        another_point,
        "tumble: position",
        "position is that of a point displaced from the centre of mass by (0.25, -0.5, 0.125) m",
    ),
    "velocity of another point": (
        velocity_of_another_point,
        "tumble: velocity",
        "velocity is that of a point displaced from the centre of mass by (0.25, -0.5, 0.125) m",
    ),
    "a displaced centre of mass": (
        displaced_mass,
        "tumble: position",
        "the centre of mass is displaced from its place in the scene by (0.25, -0.5",
    ),
    "a frame that turns": (
        rotating_frame,
        "tumble: position",
        "check in the adapter: the position and velocity of the centre of mass",
    ),
    "anchors left out": (
        without_anchors,
        "spring between two bodies: omega",
        "anchors off the centre",
    ),
    "elements on other bodies": (
        numbers_swapped,
        "spring between two bodies: omega",
        "anchors off the centre",
    ),
    "attitude in other axes": (
        changed("attitude", lambda q: q[..., [0, 2, 3, 1]]),
        "tumble: attitude",
        "",
    ),
    "omega with the other sign": (
        changed("omega", np.negative),
        "tumble: omega",
        "omega has the opposite sign",
    ),
    "two bodies in the other order": (
        lambda _, c: {
            name: values[:, ::-1] if name != "t" else values for name, values in c.items()
        },
        "two tumbling: position",
        "the bodies are in reverse order",
    ),
}


def misread(change):
    """The right motion of the scene that `change` makes of the one that was asked for."""

    def lie(request, columns):
        scene = change(request).problem.scene
        wrong = honest(scene.to_json(), request.problem.interval, len(request.problem.times))
        return {"t": columns["t"], **wrong}

    return lie


@pytest.mark.parametrize("factor", [0.99, 1.01])
@pytest.mark.parametrize(
    "change",
    [
        pytest.param(lambda by: of_bodies(mass=scaled(by)), id="mass"),
        pytest.param(lambda by: of_bodies(inertia=lambda j: j * [by, 1, 1]), id="moment about x"),
        pytest.param(lambda by: of_bodies(inertia=lambda j: j * [1, by, 1]), id="moment about y"),
        pytest.param(lambda by: of_bodies(inertia=lambda j: j * [1, 1, by]), id="moment about z"),
        pytest.param(lambda by: of_elements(UniformGravity, g=scaled(by)), id="gravity"),
        pytest.param(lambda by: of_elements(Spring, stiffness=scaled(by)), id="stiffness"),
        pytest.param(lambda by: of_elements(Spring, length=scaled(by)), id="length of a spring"),
        pytest.param(lambda by: of_elements(Spring, anchor_a=scaled(by)), id="anchor"),
    ],
)
def test_a_number_that_is_read_one_per_cent_wrong_shows_in_a_motion(change, factor):
    """First samples are those of the scene that was asked for: no number of its state is wrong."""
    findings = smoke(Plain(misread(change(factor))))
    wrong = [f.quantity for f in findings if f.outcome == "fail"]
    assert wrong
    assert not any(quantity.endswith("first sample") for quantity in wrong)


def mistakes():
    """A row for each mistake that a probe can tell."""
    rows = []
    for probe in every_probe():
        for number, mistake in enumerate(probe.mistakes):
            rows.append(pytest.param(probe, number, id=f"{probe.name}: {mistake.description}"))
    return rows


@pytest.mark.parametrize(("probe", "number"), mistakes())
def test_a_known_mistake_is_named_alone_or_as_one_of_equals(probe, number):
    description, wrong = probe.wrong_answers[number]
    seen = probe.expected_values | {
        name: wrong[name] for name in wrong if name in probe.expected_values
    }
    failing = [
        name
        for name, values in probe.expected_values.items()
        if distance(seen[name], values, name) > BOUND
    ]
    for name in failing:
        elapsed = probe.times - probe.start
        clause = likely_causes(probe.expected_values, seen, name, elapsed, probe.wrong_answers)
        assert description in clause
        equals = [
            other
            for other, columns in probe.wrong_answers
            if max(distance(seen[n], columns[n], n) for n in wrong if n in probe.expected_values)
            <= BOUND
        ]
        assert all(other in clause for other in equals)
        assert ("cannot distinguish them" in clause) == (" or " in clause.replace(description, ""))


def test_an_impact_tells_each_mistake_that_changes_it_from_every_other():
    probes = {probe.name: probe for probe in every_probe()}
    for name in ("impact in a plane", "impact in space", "bounce from a wall"):
        probe = probes[name]
        answers = [*probe.wrong_answers, ("right", probe.expected_values)]
        for n, (first, a) in enumerate(answers):
            for second, b in answers[:n]:
                off = max(distance(a[column], b[column], column) for column in a)
                assert off > BOUND, (name, first, second)


def test_a_missing_gyroscopic_term_is_told_from_axes_in_another_order():
    missing = "Euler's equations is missing"
    by_term = {f.quantity: f.sentence for f in smoke(Plain(gyroscopic_term(0.0)))}
    by_order = {f.quantity: f.sentence for f in smoke(Plain(moments_reordered(2, 0, 1)))}
    for quantity in ("wobble about x: omega_body", "tumble: omega"):
        assert missing in by_term[quantity]
        assert "moments of inertia" not in by_term[quantity].partition("; ")[2]
        assert missing not in by_order[quantity]
        assert "the moments of inertia are in the order" in by_order[quantity]


def test_a_failure_that_all_probes_share_is_told_once_and_ends_the_test():
    asked = []

    def raising(request, columns):
        asked.append(request)
        raise EngineError("no module named numpyy")

    errors = [f for f in smoke(Plain(raising)) if f.outcome == "error"]
    assert [f.quantity for f in errors] == ["line"]
    assert len(asked) == 3
    assert "; also failed for the same reason (2): plane, space" in errors[0].sentence
    assert re.search(r"; not run for this reason \(\d+\): two bodies, later", errors[0].sentence)
    assert errors[0].sentence.count("numpyy") == 1


def test_a_failure_of_some_probes_is_told_once_and_the_others_are_judged():
    def raising(request, columns):
        if request.problem.scene.all(Spring):
            raise EngineError("springs break")
        return columns

    findings = smoke(Plain(raising))
    errors = [f for f in findings if f.outcome == "error"]
    assert [f.quantity for f in errors] == ["spring"]
    assert re.search(r"for the same reason \(\d+\): spring in space", errors[0].sentence)
    assert "not run" not in errors[0].sentence
    assert "tumble: omega" in {f.quantity for f in findings if f.outcome == "pass"}


def test_failures_with_other_causes_are_told_each():
    def raising(request, columns):
        raise EngineError(f"v = {request.problem.scene.bodies.velocity[0, 1]}")

    errors = [f.quantity for f in smoke(Plain(raising)) if f.outcome == "error"]
    assert errors[:2] == ["line", "plane"]
    assert len(errors) > 3


def test_nothing_is_said_against_an_adapter_that_is_right():
    findings = smoke(Plain())
    assert {f.outcome for f in findings} == {"pass", "unsupported"}
    said = {probe.name for probe in every_probe() if {e.kind for e in probe.scene.elements} <= SAID}
    backwards = {probe.name for probe in every_probe() if probe.backwards}
    assert {
        f.quantity.partition(":")[0] for f in findings if f.outcome == "pass"
    } == said - backwards


def test_what_an_engine_refuses_when_it_runs_is_unsupported_and_no_error():
    def refuses(request, columns):
        if len(request.problem.scene.bodies) > 1:
            raise UnsupportedError("one body only")
        return columns

    findings = smoke(Plain(refuses))
    assert [(f.outcome, f.sentence) for f in findings if f.quantity == "two bodies"] == [
        ("unsupported", "one body only")
    ]
    assert "error" not in {f.outcome for f in findings}


@pytest.mark.parametrize("name", LIES)
def test_an_adapter_that_lies_is_caught_where_it_lies(name):
    lie, quantity, blamed = LIES[name]
    failed = {f.quantity: f for f in smoke(Plain(lie)) if f.outcome == "fail"}
    assert quantity in failed
    assert all(f.margin < 0 for f in failed.values())
    assert blamed in failed[quantity].sentence


def test_the_other_sign_of_a_quaternion_is_the_same_attitude():
    assert all(f.outcome != "fail" for f in smoke(Plain(changed("attitude", lambda q: -q))))


def test_a_sentence_says_what_came_and_what_must_come():
    found = {f.quantity: f.sentence for f in smoke(Plain(changed("position", lambda r: -r)))}
    shown = "at t = 1 s the value is [ 2., -0., -0.], expected [-2.,  0.,  0.]"
    assert shown in found["line: position"]
    assert found["line: position"].endswith("likely cause: position has the opposite sign")


def test_a_sentence_about_an_unknown_slip_says_where_to_look():
    found = {f.quantity: f.sentence for f in smoke(Plain(changed("position", lambda r: 1.5 * r)))}
    assert found["line: position"].endswith(
        "check in the adapter: the x axis and the units of length and time"
    )


def test_a_crash_and_a_missing_row_are_errors_that_name_the_method():
    def raising(request, columns):
        raise ZeroDivisionError("a bug")

    def short(request, columns):
        return {name: values[:-1] for name, values in columns.items()}

    for lie, words in (
        (raising, "best on 'line': ZeroDivisionError: a bug"),
        (short, "(32, 1, 3)"),
    ):
        found = {f.quantity: f for f in smoke(Plain(lie))}
        assert found["line"].outcome == "error"
        assert words in found["line"].sentence


def test_a_trajectory_that_is_not_finite_is_an_error():
    def nan(request, columns):
        with pytest.raises(EngineError):
            Trajectory(**columns | {"position": np.nan * columns["position"]})
        return columns | {"position": np.nan * columns["position"]}

    assert "error" in {f.outcome for f in smoke(Plain(nan))}


@pytest.mark.parametrize("probe", every_probe(), ids=lambda probe: probe.name)
def test_every_probe_starts_where_its_scene_does(probe):
    bodies = probe.scene.bodies
    expected = probe.expected(probe.times - probe.times[0])
    for name in ("position", "velocity", "attitude", "omega"):
        if name in expected:
            np.testing.assert_allclose(expected[name][0], getattr(bodies, name), atol=1e-15)
    assert set(expected)


def test_velocities_of_the_probes_are_the_rates_of_their_positions():
    # Central differences over 0.5 ms at 128 instants: off by 3e-5 where a contact has 26 rad/s.
    instants = (np.arange(128) + 0.5) / 128
    half = 0.0005
    beside = instants[:, None] + np.array([-half, 0.0, half])
    for probe in every_probe():
        expected = probe.expected(np.concatenate([[0.0], beside.ravel()]))
        if {"position", "velocity"} <= set(expected):
            before, _, after = (expected["position"][1 + k :: 3] for k in range(3))
            rate = (after - before) / (2 * half)
            np.testing.assert_allclose(rate, expected["velocity"][2::3], atol=1e-4)


def by_verlet(change=lambda request: request):
    """Velocity Verlet of the reference, of which a request may be changed: a method of order 2."""
    fault = Fault(
        name="misread",
        kind="number",
        sentence="a number of the scene is read wrong",
        on=(),
        sees=("smoke", "position"),
        before=change,
    )
    engine = Carrier(discovery.engine("reference"), fault)
    engine.methods = tuple(m for m in engine.methods if m.name == "velocity-verlet")
    return engine


@pytest.mark.parametrize(
    "change",
    [
        pytest.param(of_bodies(mass=scaled(1.001)), id="mass"),
        pytest.param(of_elements(UniformGravity, g=scaled(1.001)), id="gravity"),
        pytest.param(of_elements(Spring, stiffness=scaled(1.001)), id="stiffness"),
        pytest.param(of_elements(Contact, stiffness=scaled(1.001)), id="stiffness of a contact"),
        pytest.param(of_elements(Contact, damping=scaled(1.001)), id="damping of a contact"),
        pytest.param(of_elements(Spring, length=scaled(1.001)), id="length of a spring"),
    ],
)
def test_a_number_that_is_read_a_tenth_of_a_per_cent_wrong_shows_beside_twice_the_step(change):
    """A bound that a change of the step implies sees ten times less than one for all programs."""
    wrong = [f for f in smoke(by_verlet(change)) if f.outcome == "fail"]
    assert wrong
    assert all("implied by the change from twice the step" in f.basis for f in wrong)


def test_what_twice_the_step_implies_accuses_no_right_method_of_a_step():
    findings = smoke(by_verlet())
    implied = [f for f in findings if "implied by the change" in f.basis]
    assert len(implied) > 30
    assert {f.outcome for f in implied} == {"pass"}
    # Springs: 4/(2^2 - 1) of a change of 3 C h^2, four times the error itself.
    (spring,) = [f for f in findings if f.quantity == "spring: position"]
    assert spring.bound == pytest.approx(4 * spring.value, rel=0.02)


def test_a_run_at_twice_the_step_that_fails_leaves_the_wider_bound():
    class Fussy(Carrier):
        def run(self, request):
            if request.step == 2 * STEP:
                raise EngineError("no step that long")
            return super().run(request)

    plain = by_verlet()
    fussy = Fussy(plain.engine, plain.fault)
    fussy.methods = plain.methods
    (spring,) = [f for f in smoke(fussy) if f.quantity == "spring: position"]
    assert (spring.outcome, spring.bound) == ("pass", SMOOTH_BOUND)
