"""Synthetic sheets with every outcome, every control and names from a stranger who means harm."""

import msgspec
import numpy as np

from refdem.core.finding import (
    CampaignSheet,
    CaseSheet,
    EngineSheet,
    Finding,
    Level,
    Record,
    Series,
    Sheet,
)
from refdem.core.replay import DrawnBody, DrawnLink, DrawnPlane, Grid, Replay, Track

HOSTILE = "<script>alert(1)</script>|`x`|</script><img src=x onerror=alert(2)>"
STEPS = (0.1, 0.05, 0.025, 0.0125)


def levels(size: float, order: int, steps: tuple[float, ...] = STEPS) -> tuple[Level, ...]:
    """Errors size * (h/0.1)^order, half of their bounds."""
    errors = [size * (h / 0.1) ** order if order else size for h in steps]
    pairs = zip(steps, errors, strict=True)
    return tuple(
        Level(level=h, error=e, bound=2 * e, seconds=1e-4 / (h or 1e-4), counts=order > 0)
        for h, e in pairs
    )


def error(
    quantity: str,
    size: float,
    order: int,
    *,
    outcome: str = "pass",
    steps: tuple[float, ...] = STEPS,
) -> Finding:
    """A finding of the check `error`; an order of 0 means no claim of an order."""
    seen = levels(size, order, steps)
    curve = [seen[-1].error * (1 + (k % 7) / 7) / 2 for k in range(65)]
    sentence = f"The error of {quantity} is {seen[-1].error:.2g}: claimed order {order}."
    return Finding(
        check="error",
        quantity=quantity,
        outcome=outcome,
        sentence=sentence,
        value=seen[-1].error,
        bound=seen[-1].bound,
        basis=f"claimed order {order}",
        levels=seen,
        series=Series(t=[0.1 * k for k in range(65)], value=curve, bound=[seen[-1].bound] * 65),
        order_seen=order - 0.02 if order else None,
        order_claimed=float(order) if order else None,
        constant_seen=0.3 if order else None,
    )


def energy(outcome: str, value: float, bound: float) -> Finding:
    """A finding of the check `energy` with a curve that starts at exactly 0."""
    times = [0.1 * k for k in range(65)]
    curve = Series(t=times, value=[value * k / 64 for k in range(65)], bound=[bound] * 65)
    sentence = f"The energy drifts by {value:.2g} J, bound {bound:.2g} J."
    return Finding(
        check="energy",
        quantity="energy",
        outcome=outcome,
        sentence=sentence,
        value=value,
        bound=bound,
        unit="J",
        basis="no secular drift",
        series=curve,
    )


def said(check: str, outcome: str, sentence: str) -> Finding:
    """A finding without numbers."""
    return Finding(check=check, quantity="state", outcome=outcome, sentence=sentence)


def record(case: str, label: str, engine: str, method: str, *findings: Finding) -> Record:
    """A record; the engine called reference is the reference."""
    return Record(
        case=case,
        label=label,
        parameters={},
        engine=engine,
        version="1.0",
        method=method,
        is_reference=engine == "reference",
        runs=("a" * 64, "b" * 64),
        findings=findings,
    )


def case_sheet(case: str, label: str, title: str, latex: str) -> CaseSheet:
    """A sheet of an instance."""
    return CaseSheet(
        case=case,
        label=label,
        title=title,
        statement=f"A statement of {title} with x < y & z.",
        latex=latex,
        source="chapter, (1.1)",
        parameters={"mass": "1", "duration": ""},
        units={"mass": "kg", "duration": "s"},
        scene='{"bodies": [{"mass": 1.0}]}',
        scales={"L": 1.0, "tau": 0.5, "T": 10.0, "mass": 1.0},
        quantities={"x": "m"},
        truth_method="closed form",
        truth_witness="validated integration",
        truth_scalars={"period": ("6.2831853071795865", "1e-16")},
        reproduce=f"refdem run {case} --set mass='1'",
    )


def engine_sheet(engine: str) -> EngineSheet:
    """A sheet of an engine."""
    audit = (("damping", "0.2", "0", "the scene has none"), (HOSTILE, HOSTILE, HOSTILE, HOSTILE))
    return EngineSheet(
        engine=engine,
        title=f"Engine {engine}",
        version="1.0",
        licence="MIT",
        is_reference=engine == "reference",
        methods={"verlet": "order 2; symplectic", "rk4": "order 4"},
        audit=audit,
    )


def replay(label: str, engine: str, method: str) -> Replay:
    """A ball and a box that move along x, and a run that lags behind them and turns too far; it
    tells a contact in its third frame.
    """
    frames = 9
    along = np.linspace(0.0, 2.0, frames)[:, None] * np.array([1.0, 0, 0, 1, 0, 0])
    behind = np.linspace(0.0, 1e-4, frames)[:, None] * np.array([-1.0, 0, 0, -1, 0, 0])
    twist = np.linspace(0.0, 1e-3, frames)[:, None] * np.array([0.0, 0, 1, 0, 0, 0])
    corners = tuple((x, y, z) for x in (-0.3, 0.3) for y in (-0.2, 0.2) for z in (-0.1, 0.1))
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    upright = (1.0, 0.0, 0.0, 0.0)
    track = Track(
        engine=engine,
        method=method,
        control="step",
        level=0.1,
        place=Grid.of(behind),
        turn=Grid.of(twist),
        largest=1e-4,
        largest_turn=1e-3,
        contacts=((2, 0),),
    )
    return Replay(
        label=label,
        t=tuple(0.5 * k for k in range(frames)),
        bodies=(
            DrawnBody(position=(0.0, 0.5, 0.0), attitude=upright, radius=0.5),
            DrawnBody(position=(-1.5, 0.2, 0.0), attitude=upright, vertices=corners, faces=faces),
        ),
        links=(DrawnLink(kind=method, a=0, b=1, anchor_a=(0, 0, 0), anchor_b=(0, 0, 0)),),
        planes=(DrawnPlane(point=(0.0, 0.0, 0.0), normal=(0.0, 1.0, 0.0)),),
        touches=True,
        view=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        place=Grid.of(along),
        turn=Grid.of(np.zeros((frames, 8))),
        certified=("x", engine),
        anchor="exact",
        anchor_error=1e-15,
        contacts=(),
        tracks=(track, msgspec.structs.replace(track, engine="reference", method="exact")),
    )


def sheets() -> list[Sheet]:
    """A campaign of three instances and five engines."""
    found: list[Sheet] = [
        CampaignSheet(name="main", refdem="0.1.0", runs_made=12, runs_read=3, seconds=1.25)
    ]
    found += [engine_sheet(name) for name in ("reference", "alpha", "beta", "gamma", HOSTILE)]
    swing = r"\ddot\theta+\frac{g}{l}\sin\theta=0,\qquad F=m\left(l\dot\theta^2+g\cos\theta\right)"
    found += [
        case_sheet("pendulum", "pendulum", "Pendulum", swing),
        case_sheet("pendulum", "pendulum[theta0=3 mass=2]", "Pendulum", r"\ddot\theta=0"),
        case_sheet(
            HOSTILE,
            f"{HOSTILE}[x=1]",
            HOSTILE,
            r"\text{" + HOSTILE + r"}\href{javascript:alert(3)}{x}",
        ),
    ]
    for label in ("pendulum", "pendulum[theta0=3 mass=2]"):
        found += _pendulum(label)
    label = f"{HOSTILE}[x=1]"
    hostile = (error(HOSTILE, 1e-2, 1), energy("pass", 1e-9, 1e-6), said(HOSTILE, "fail", HOSTILE))
    found.append(record(HOSTILE, label, HOSTILE, HOSTILE, *hostile))
    found.append(
        record(
            HOSTILE,
            label,
            "reference",
            "exact",
            error(HOSTILE, 1e-15, 0, steps=(0.0,)),
            error("y", 0.0, 0, steps=(0.0,)),
        )
    )
    found += [replay("pendulum", "alpha", "rk4"), replay(label, HOSTILE, HOSTILE)]
    return found


def _pendulum(label: str) -> list[Sheet]:
    undecided = said("order", "undecided", "Undecided: 2 levels count.")
    return [
        record(
            "pendulum",
            label,
            "reference",
            "exact",
            error("theta", 3e-16, 0, steps=(0.0,)),
            energy("pass", 0.0, 1e-14),
        ),
        record(
            "pendulum",
            label,
            "reference",
            "verlet",
            error("theta", 1e-2, 2),
            error("x", 3e-2, 2),
            energy("pass", 1e-4, 1e-2),
        ),
        record(
            "pendulum",
            label,
            "alpha",
            "rk4",
            error("theta", 1e-3, 4),
            error("x", 2e-3, 4),
            energy("pass", 1e-7, 1e-6),
        ),
        record(
            "pendulum",
            label,
            "alpha",
            "euler",
            error("theta", 0.4, 1, outcome="fail"),
            energy("fail", 3.0, 1e-2),
        ),
        record(
            "pendulum",
            label,
            "alpha",
            "adaptive",
            error("theta", 1e-8, 0, steps=(1e-4, 1e-6, 1e-8)),
            energy("expected", 1e-5, 1e-7),
        ),
        record(
            "pendulum",
            label,
            "beta",
            "verlet",
            said("run", "error", "The engine crashed: signal 11 at step 3."),
        ),
        record(
            "pendulum",
            label,
            "gamma",
            "verlet",
            said("support", "unsupported", "gamma has no rod."),
        ),
        record(
            "pendulum",
            label,
            HOSTILE,
            "verlet",
            error("theta", 1e-5, 2, outcome="stale"),
            undecided,
        ),
    ]
