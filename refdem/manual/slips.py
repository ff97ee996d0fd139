"""Slips of the source chapter (Matuttis and Chen 2014, chapter 1), each with the measurement that
settles it, made when it is asked for.
"""

import math
from collections.abc import Callable, Mapping
from fractions import Fraction

import numpy as np

from refdem.core.discovery import case, truth_of
from refdem.core.manual import Slip
from refdem.core.truth import Ball
from refdem.mechanics.quaternion import conjugate, product, rotated
from refdem.mechanics.rotation import about_axis, euler_rates

Measured = tuple[tuple[str, str], ...]


def frequency_rises() -> Measured:
    """The certified frequency of x'' + x + 0.1 x^3 at amplitude 1, beside both signs."""
    truth = truth_of("duffing", alpha="1", beta="1/10", amplitude="1")
    period = float(truth.scalars()["period"].mid)
    certified = 2 * math.pi / period
    # w = w0 (1 +- 3 eps A^2/(8 w0^2)) with w0 = 1, eps = 0.1, A = 1.
    shift = 3 * 0.1 / 8
    return (
        ("certified frequency, alpha = 1, beta = 0.1, A = 1", number(certified)),
        ("w0 (1 + 3 eps A^2/(8 w0^2))", number(1 + shift)),
        ("w0 (1 - 3 eps A^2/(8 w0^2)), as printed", number(1 - shift)),
    )


def damping_per_mass() -> Measured:
    """The certified decay over a period with m = 2, beside what the two readings of the damping
    term say.
    """
    truth = truth_of("viscous-oscillator", mass="2", stiffness="5", delta="1/10")
    period = truth.scalars()["period"].mid
    # Truth takes rational times: the period to 2^-40 s.
    t = Fraction(round(period * 2**40), 2**40)
    place = float(truth.at(t)["x"].mid)
    # x(T) = exp(-decay T), as x(0) = 1.
    decay = -math.log(place) / float(t)
    return (
        ("certified -ln(x(T)/x(0))/T, m = 2, delta = 0.1", number(decay)),
        ("delta, from x'' + 2 delta x' + w0^2 x = 0", number(0.1)),
        ("delta/m, from m x'' + 2 delta x' + k x = 0 as printed", number(0.05)),
    )


def sense_of_turn() -> Measured:
    """Where e_y goes under a turn by +90 degrees about x with either sign of the vector part."""
    # cos and sin of half the angle, 45 degrees.
    half = math.sqrt(0.5)
    e_y = np.array([0.0, 1, 0])
    shown = []
    for text, sign in (("(cos, +sin e_x), (1.64)", 1), ("(cos, -sin e_x), (1.62)", -1)):
        turn = np.array([half, sign * half, 0, 0])
        shown.append((f"e_y turned by {text}", vector(rotated(turn, e_y))))
    by_matrix = about_axis(0, math.pi / 2) @ [0, 1, 0]
    shown.append(("e_y under the matrix of a turn by +90 degrees about x", vector(by_matrix)))
    return tuple(shown)


def euler_angles_diverge() -> Measured:
    """phi' for omega = e_y at phi = 0 by theta: large where sin theta is small, and nowhere
    else.
    """
    omega = np.array([0.0, 1.0, 0.0])
    shown = []
    for theta in (math.pi / 2, 1e-1, 1e-3, 1e-6):
        phi_rate = euler_rates(0.0, theta, omega)[0]
        text = f"phi' [rad/s] at theta = {number(theta)}, omega = e_y"
        shown.append((text, number(phi_rate)))
    return tuple(shown)


def spin_wanders() -> Measured:
    """How far omega in space goes while L stays: about no principal axis, and about one."""
    shown = []
    for text, omega in (
        ("(0.9, 1.1, 1.3)", "0.9,1.1,1.3"),
        ("(0, 0, 1), a principal axis", "0,0,1"),
    ):
        truth = truth_of("free-rigid-body", omega_body=omega)
        start = _vector_of(truth.at(Fraction(0)), "omega", "xyz")
        later = _vector_of(truth.at(Fraction(3)), "omega", "xyz")
        what = f"|omega(3 s) - omega(0)| in space [rad/s], J = (1, 2, 3), omega_body = {text}"
        shown.append((what, number(norm(later - start))))
    return tuple(shown)


def _vector_of(balls: Mapping[str, Ball], name: str, axes: str) -> np.ndarray:
    """The middles of the certified components of a vector, `name.axis` for every axis."""
    return np.array([float(balls[f"{name}.{axis}"].mid) for axis in axes])


def quaternion_and_rate() -> Measured:
    """Whether q and its derivative commute, on a certified motion."""
    motion = truth_of("free-rigid-body").at(Fraction(1))
    q = _vector_of(motion, "attitude", "wxyz")
    omega = np.array([0.0, *_vector_of(motion, "omega", "xyz")])
    # qdot = (0, omega) q / 2, omega in space axes.
    rate = product(omega, q) / 2
    commutator = product(q, rate) - product(rate, q)
    symmetric = product(q, conjugate(rate)) + product(rate, conjugate(q))
    return (
        ("|q qdot - qdot q| at t = 1 s of the free rigid body", number(norm(commutator))),
        ("|q qdot* + qdot q*|", number(norm(symmetric))),
        ("q . qdot", number(float(q @ rate))),
    )


def peak_only_if_weakly_damped() -> Measured:
    """Certified steady amplitudes for delta = 0.8 > w0/sqrt 2: they fall from the start."""
    shown = []
    for drive in ("1/100", "1/4", "1/2", "1"):
        truth = truth_of("driven-oscillator", delta="4/5", drive=drive)
        amplitude = float(truth.scalars()["steady_amplitude"].mid)
        what = f"steady amplitude at w = {drive}, w0 = 1, delta = 0.8"
        shown.append((what, number(amplitude)))
    return (*shown, ("w0^2 - 2 delta^2, the square of the would-be peak", number(1 - 2 * 0.64)))


def resonance_curve() -> Measured:
    """What (1.120), |w0^2 + 3/4 eps A^2 - W^2 + 2 i delta W| A = f0, leaves of the roots that
    either reading of (1.121) gives.
    """
    eps = 0.4
    f0 = 1.5
    delta = 0.1
    amplitude = 1.5
    stiff = 0.75 * eps * amplitude**2
    shown = []
    for text, sign in (
        ("- 4 delta^2 (w0^2 + 3/4 eps A^2 - delta^2), as here", 1),
        ("- 4 delta^2 (w0^2 - 3/4 eps A^2 - delta^2), as printed", -1),
    ):
        # (1.121): W^2 = w0^2 + 3/4 eps A^2 - 2 delta^2 + root, with w0 = 1.
        root = math.sqrt(f0**2 / amplitude**2 - 4 * delta**2 * (1 + sign * stiff - delta**2))
        squared = 1 + stiff - 2 * delta**2 + root
        # (1.120): f0 = |w0^2 + 3/4 eps A^2 - W^2 + 2 i delta W| A.
        response = 1 + stiff - squared + 2j * delta * math.sqrt(squared)
        force = abs(response) * amplitude
        shown.append((f"force that the root with {text} needs; f0 = 1.5", number(force)))
    return tuple(shown)


def energy_of_spin() -> Measured:
    """Kinetic energy of a steady spin about axis 3, J3 = 3, omega = 2, from L."""
    return (
        ("(1.138)/2 with L = 6: sum J omega^2/2 [J]", number(0.5 * 3 * 2.0**2)),
        ("L^2/(2 J3) [J]", number(6.0**2 / (2 * 3))),
        ("L/(2 J3), as printed (its unit is 1/s)", number(6.0 / (2 * 3))),
    )


def driven_paths_cross() -> Measured:
    """How often the path of a driven and of a free oscillator crosses itself in the plane of x and
    v, on certified samples.
    """
    shown = []
    for text, name, given in (
        ("driven", "driven-oscillator", {"drive": "3", "f0": "4"}),
        ("free", "viscous-oscillator", {}),
    ):
        truth = truth_of(name, **given)
        path = np.array([_point(truth.at(Fraction(n, 16))) for n in range(321)])
        what = f"crossings of the path with itself in 20 s, {name} ({text})"
        shown.append((what, str(crossings(path))))
    return tuple(shown)


def resonance_grows_linearly() -> Measured:
    """The certified motion at resonance from rest, beside f0 t sin(w0 t)/(2 w0), the real part of
    the stated solution.
    """
    truth = truth_of("driven-oscillator", delta="0", drive="1", x0="0", v0="0")
    shown = []
    for t in (10, 100):
        certified = float(truth.at(Fraction(t))["x"].mid)
        # f0 t sin(w0 t)/(2 w0), with f0 = w0 = 1.
        stated = t * math.sin(t) / 2
        shown.append((f"certified x({t} s), f0 = w0 = w = 1, from rest", number(certified)))
        shown.append((f"Re(f0 t exp(i w t)/(2 i w0)) at {t} s", number(stated)))
    return tuple(shown)


def one_vector() -> Measured:
    """The product of two quarter turns is no quarter turn, though it takes e_x to e_y."""
    turn = about_axis(0, -math.pi / 2) @ about_axis(1, -math.pi / 2)
    # trace = 1 + 2 cos(angle).
    cosine = (np.trace(turn) - 1) / 2
    angle = math.degrees(math.acos(cosine))
    moved = [
        (f"Rx(-90) Ry(-90) {name}", vector(turn @ axis))
        for name, axis in zip(("e_x", "e_y", "e_z"), np.eye(3), strict=True)
    ]
    return (*moved, ("angle of the product [degrees]", number(angle)))


def kept_with_minus_integral() -> Measured:
    """T + Phi at start and end of a pass through the asymmetric field, with Phi = -integral of F,
    and with the other sign.
    """
    instance = case("asymmetric-field").at()
    truth = instance.truth()
    t = np.linspace(0.0, float(instance.times[-1]), 2001)
    x, v = np.array([_point(truth.at(Fraction(s))) for s in t]).T
    mass = float(instance.p.mass)
    # Phi = -integral of F dx by the trapezoidal rule, with F = m dv/dt.
    force = mass * np.gradient(v, t)
    work = (force[1:] + force[:-1]) / 2 * np.diff(x)
    potential = -np.concatenate([[0.0], np.cumsum(work)])
    kinetic = mass * v * v / 2
    shown = []
    for text, sign in (("T", 0), ("T + Phi", 1), ("T - Phi", -1)):
        energy = kinetic + sign * potential
        shown.append((f"range of {text} along the certified motion [J]", number(np.ptp(energy))))
    return tuple(shown)


def _point(balls: Mapping[str, Ball]) -> tuple[float, float]:
    """The middles of the certified place [m] and velocity [m/s]."""
    return float(balls["x"].mid), float(balls["v"].mid)


def crossings(path: np.ndarray) -> int:
    """How many pairs of segments of a polygon (n, 2) cross, neighbours left out."""
    a = path[:-1]
    b = path[1:]

    # Two segments cross if the ends of each lie on different sides of the other.
    i, j = np.triu_indices(len(a), 2)
    apart = _side(a[i], b[i], a[j]) * _side(a[i], b[i], b[j])
    across = _side(a[j], b[j], a[i]) * _side(a[j], b[j], b[i])
    return int(np.sum((apart < 0) & (across < 0)))


def _side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
    """(q - p) x (r - p), for points (..., 2): positive where r lies to the left of p -> q."""
    along = q - p
    aside = r - p
    side: np.ndarray = along[..., 0] * aside[..., 1] - along[..., 1] * aside[..., 0]
    return side


def norm(values: np.ndarray) -> float:
    """The Euclidean length of a vector (n,)."""
    return float(np.linalg.norm(values))


def number(value: float) -> str:
    """Six significant digits; what is round-off is shown as 0."""
    if abs(value) < 1e-14:
        return "0"
    return f"{value:.6g}"


def vector(values: np.ndarray) -> str:
    """The components of a vector (n,), each with six significant digits, as (x, y, z)."""
    return f"({', '.join(number(float(value)) for value in values)})"


SLIPS: tuple[tuple[tuple[str, ...], str, str, str, Callable[[], Measured]], ...] = (
    (
        ("duffing", "driven-duffing"),
        "(1.116)",
        "the frequency is w0 (1 - 3 eps A^2/(8 w0^2))",
        (
            "it rises with the amplitude for eps > 0: w0 (1 + 3 eps A^2/(8 w0^2)), as the text"
            " beside it says"
        ),
        frequency_rises,
    ),
    (
        ("viscous-oscillator", "driven-oscillator"),
        "(1.95), (1.96)",
        "m x'' + 2 delta x' + k x = 0 decays as exp(-delta t)",
        "the damping is 2 delta x' per mass, delta = b/(2 m)",
        damping_per_mass,
    ),
    (
        ("quaternions", "rotations"),
        "(1.62) against (1.64)",
        "a turn has the vector part -sin in one equation and +sin in the other",
        "the second is used: q = (cos phi/2, v sin phi/2) turns by +phi about v",
        sense_of_turn,
    ),
    (
        ("rotations",),
        "section 1.3.7",
        "Euler angles diverge close to theta = pi/2",
        "they diverge where sin theta = 0, and nowhere else",
        euler_angles_diverge,
    ),
    (
        ("free-rigid-body", "neglected-gyroscopic"),
        "section 1.3.6",
        "a constant angular momentum makes omega constant",
        "only if the body turns about a principal axis",
        spin_wanders,
    ),
    (
        ("quaternions", "free-rigid-body"),
        "after (1.75)",
        "a quaternion and its derivative commute",
        "they do not; what holds is q qdot* = -qdot q*, and that both are orthogonal",
        quaternion_and_rate,
    ),
    (
        ("driven-oscillator",),
        "(1.106)",
        "the amplitude has its peak at w^2 = w0^2 - 2 delta^2",
        "only for delta < w0/sqrt 2; beyond, it falls from w = 0 on",
        peak_only_if_weakly_damped,
    ),
    (
        ("driven-duffing",),
        "(1.121)",
        "inside the root 3/4 eps A^2 counts with the other sign than w0^2",
        (
            "W^2 = w0^2 + 3/4 eps A^2 - 2 delta^2 +- sqrt(f0^2/A^2 - 4 delta^2 (w0^2 + 3/4 eps A^2"
            " - delta^2))"
        ),
        resonance_curve,
    ),
    (
        ("intermediate-axis", "dissipating-body"),
        "section 1.7.3",
        "the energy of a spin about axis i is L/(2 Ji)",
        "T = L^2/(2 J)",
        energy_of_spin,
    ),
    (
        ("driven-oscillator", "van-der-pol", "stick-slip"),
        "sections 1.5.4, 1.6.2",
        "the theorem of Poincare and Bendixson is named for driven oscillators",
        (
            "it does not bind them: time is a third coordinate, and paths cross in the plane of x"
            " and v"
        ),
        driven_paths_cross,
    ),
    (
        ("asymmetric-field",),
        "section 1.7.4, (1.139)",
        "T - Phi, or Phi with the other sign",
        "T + Phi is kept with Phi = -integral of F",
        kept_with_minus_integral,
    ),
    (
        ("driven-oscillator",),
        "exercise 1.3",
        "x = t sin(i w t) solves the driven oscillator at resonance",
        "f0 t exp(i w t)/(2 i w0) does; it grows linearly",
        resonance_grows_linearly,
    ),
    (
        ("rotations",),
        "figure 1.7",
        "two quarter turns one after the other equal one quarter turn",
        "that is a statement about one vector: the product is a turn by 120 degrees",
        one_vector,
    ),
)
"""Cases, place, what the chapter says, what holds, and the measurement."""


def slips_of(case: str) -> tuple[Slip, ...]:
    """The slips that concern a case, measured now."""
    return tuple(
        Slip(where=where, says=says, holds=holds, measured=measure())
        for cases, where, says, holds, measure in SLIPS
        if case in cases
    )
