"""Slips of the source chapter (Matuttis and Chen 2014, chapter 1), each with the measurement that
settles it, made on demand.
"""

import math
from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from refdem.core.discovery import case, truth_of
from refdem.core.manual import Slip
from refdem.core.truth import Ball, Truth
from refdem.manual import attitude_slips, oscillator_slips
from refdem.manual.slip import KnownSlip, Measured, norm, number, phase_point, vector, vector_of
from refdem.mechanics.quaternion import conjugate, matrix, product, rotated
from refdem.mechanics.rotation import about_axis, euler_rates


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
    plus = np.array([half, half, 0, 0])
    minus = np.array([half, -half, 0, 0])
    e_y = np.array([0.0, 1, 0])
    by_matrix = about_axis(0, math.pi / 2) @ e_y
    return (
        ("e_y turned by (cos, +sin e_x), (1.64)", vector(rotated(plus, e_y))),
        ("e_y turned by (cos, -sin e_x), (1.62)", vector(rotated(minus, e_y))),
        ("e_y under the matrix of a turn by +90 degrees about x", vector(by_matrix)),
    )


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
    what = "|omega(3 s) - omega(0)| in space [rad/s], J = (1, 2, 3), omega_body ="
    return (
        (f"{what} (0.9, 1.1, 1.3)", number(_spin_change("0.9,1.1,1.3"))),
        (f"{what} (0, 0, 1), a principal axis", number(_spin_change("0,0,1"))),
    )


def _spin_change(omega_body: str) -> float:
    """|omega(3 s) - omega(0)| [rad/s] in space axes of the free rigid body, certified."""
    truth = truth_of("free-rigid-body", omega_body=omega_body)
    start = vector_of(truth.at(Fraction(0)), "omega", "xyz")
    later = vector_of(truth.at(Fraction(3)), "omega", "xyz")
    return norm(later - start)


def quaternion_and_rate() -> Measured:
    """Whether q and its derivative commute, on a certified motion."""
    motion = truth_of("free-rigid-body").at(Fraction(1))
    q = vector_of(motion, "attitude", "wxyz")
    omega = np.array([0.0, *vector_of(motion, "omega", "xyz")])
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
    """The force f0 that (1.120) needs for the frequency that either reading of (1.121) gives."""
    what = "force that the root with"
    here = number(_force_of_root(sign=1))
    printed = number(_force_of_root(sign=-1))
    return (
        (f"{what} - 4 delta^2 (w0^2 + 3/4 eps A^2 - delta^2), as here needs; f0 = 1.5", here),
        (f"{what} - 4 delta^2 (w0^2 - 3/4 eps A^2 - delta^2), as printed needs; f0 = 1.5", printed),
    )


def _force_of_root(sign: int) -> float:
    """The force f0 of (1.120), |w0^2 + 3/4 eps A^2 - W^2 + 2 i delta W| A = f0, at the frequency W
    of (1.121), where 3/4 eps A^2 has this sign inside the root; 1.5 if (1.121) is right.
    """
    eps = 0.4
    f0 = 1.5
    delta = 0.1
    amplitude = 1.5
    stiffening = 0.75 * eps * amplitude**2
    # (1.121): W^2 = w0^2 + 3/4 eps A^2 - 2 delta^2 + root, with w0 = 1.
    damped = 4 * delta**2 * (1 + sign * stiffening - delta**2)
    root = math.sqrt(f0**2 / amplitude**2 - damped)
    squared = 1 + stiffening - 2 * delta**2 + root
    response = 1 + stiffening - squared + 2j * delta * math.sqrt(squared)
    return abs(response) * amplitude


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
    driven = _crossings_of(truth_of("driven-oscillator", drive="3", f0="4"))
    free = _crossings_of(truth_of("viscous-oscillator"))
    what = "crossings of the path with itself in 20 s,"
    return (
        (f"{what} driven-oscillator (driven)", str(driven)),
        (f"{what} viscous-oscillator (free)", str(free)),
    )


def _crossings_of(truth: Truth) -> int:
    """How often a certified path in the plane of x and v crosses itself in 20 s, by 16 samples a
    second.
    """
    path = [phase_point(truth.at(Fraction(n, 16))) for n in range(20 * 16 + 1)]
    return crossings(np.array(path))


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
    """T and T + Phi in a pass through the asymmetric field, with Phi = -integral of F, and Phi at
    its end.
    """
    instance = case("asymmetric-field").at()
    truth = instance.truth()
    t = np.linspace(0.0, float(instance.times[-1]), 2001)
    x, v = np.array([phase_point(truth.at(Fraction(s))) for s in t]).T
    mass = float(instance.p.mass)
    # Phi = -integral of F dx by the trapezoidal rule, with F = m dv/dt.
    force = mass * np.gradient(v, t)
    work = (force[1:] + force[:-1]) / 2 * np.diff(x)
    potential = -np.concatenate([[0.0], np.cumsum(work)])
    kinetic = mass * v * v / 2
    what = "along the certified motion [J]"
    return (
        (f"range of T {what}", number(np.ptp(kinetic))),
        (f"range of T + Phi {what}", number(np.ptp(kinetic + potential))),
        ("Phi at the far end, where it is 0 at the near one [J]", number(potential[-1])),
    )


def turned_tensor() -> Measured:
    """The certified tensor of a turned tetrahedron, beside both ways to turn that of the straight
    one by the printed matrix A of (1.21).
    """
    instance = case("moments-of-inertia").at()
    balls = instance.truth().scalars()
    straight = _tensor_of(balls, "tetrahedron")
    certified = _tensor_of(balls, "turned-tetrahedron")
    attitude = instance.p.attitude / np.linalg.norm(instance.p.attitude)
    # (1.22): the printed matrix leads from space to the body, r' = A r.
    printed = matrix(attitude).T
    holds = printed.T @ straight @ printed
    said = printed @ straight @ printed.T
    what = "off the certified tensor of the turned tetrahedron, relative"
    scale = norm(certified)
    return (
        (f"A^T J_b A, {what}", number(norm(holds - certified) / scale)),
        (f"A J_b A^T as printed, {what}", number(norm(said - certified) / scale)),
    )


def _tensor_of(balls: Mapping[str, Ball], name: str) -> np.ndarray:
    """The middles (3, 3) of the certified tensor of inertia of a solid."""
    entries = [
        [float(balls[f"{name}.inertia.{''.join(sorted(i + j))}"].mid) for j in "xyz"] for i in "xyz"
    ]
    return np.array(entries)


def torque_of_a_free_body() -> Measured:
    """How far J, and L = J omega, go in space on a certified motion without torque."""
    truth = truth_of("free-rigid-body")
    tensors = []
    momenta = []
    for t in (0, 3):
        balls = truth.at(Fraction(t))
        entries = [float(balls[f"R.{i}{j}"].mid) for i in "xyz" for j in "xyz"]
        turn = np.array(entries).reshape(3, 3)
        tensor = turn @ np.diag([1.0, 2.0, 3.0]) @ turn.T
        tensors.append(tensor)
        momenta.append(tensor @ vector_of(balls, "omega", "xyz"))
    what = "in space, no torque, J = (1, 2, 3)"
    return (
        (f"|J(3 s) - J(0)| [kg m^2] {what}", number(norm(tensors[1] - tensors[0]))),
        (f"|L(3 s) - L(0)| [kg m^2/s] {what}", number(norm(momenta[1] - momenta[0]))),
    )


def dashed_lines_are_undamped() -> Measured:
    """What is left of the position and of the speed after periods of the certified oscillators of
    figures 1.15 and 1.16.
    """
    free = truth_of("harmonic-oscillator", x0="1", v0="0")
    viscous = truth_of("viscous-oscillator", delta="1/10", x0="1", v0="0")
    # Periods are irrational and truth takes rational times: 2 pi to 2^-40 s.
    late = Fraction(round(10 * math.pi * 2**40), 2**40)
    later = late + Fraction(round(math.pi / 2 * 2**40), 2**40)
    what = "m = k = 1, x(0) = 1"
    return (
        (f"x after 5 periods, (1.92), {what}", number(float(free.at(late)["x"].mid))),
        (f"v a quarter of a period later, (1.92), {what}", number(float(free.at(later)["v"].mid))),
        (
            f"x at the same time, (1.95) with delta = 0.1, {what}",
            number(float(viscous.at(late)["x"].mid)),
        ),
    )


def rule_of_the_product() -> Measured:
    """The product of 1 + 2 I + 3 J + 4 K and 5 + 6 I + 7 J + 8 K by the table of (1.44) and (1.45),
    and by (1.56); and what (1.92) is.
    """
    first = np.array([1.0, 2, 3, 4])
    second = np.array([5.0, 6, 7, 8])
    # (1.44), (1.45): I I = -1, I J = K, J I = -K, and so on; (factor, factor): (sign, element).
    table = {(0, 0): (1, 0)}
    for i in (1, 2, 3):
        table[0, i] = table[i, 0] = (1, i)
        table[i, i] = (-1, 0)
    for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        table[i, j] = (1, k)
        table[j, i] = (-1, k)
    by_table = np.zeros(4)
    for (i, j), (sign, element) in table.items():
        by_table[element] += sign * first[i] * second[j]
    # (1.56): (s1 s2 - v1 . v2, s1 v2 + s2 v1 + v1 x v2).
    s1, v1 = first[0], first[1:]
    s2, v2 = second[0], second[1:]
    scalar = s1 * s2 - v1 @ v2
    by_rule = np.array([scalar, *(s1 * v2 + s2 * v1 + np.cross(v1, v2))])
    motion = truth_of("harmonic-oscillator", x0="1", v0="0").at(Fraction(1))
    place = float(motion["x"])
    return (
        ("(w, x, y, z) by (1.44) and (1.45)", vector(by_table)),
        ("(w, x, y, z) by (1.56)", vector(by_rule)),
        ("x(1 s) of the motion that solves (1.92), m = k = 1, x(0) = 1", number(place)),
        ("cos(1)", number(math.cos(1))),
    )


def segment_at_rest() -> Measured:
    """Filippov's velocity on the line v = 0 inside |x| < f/k, and where the certified block is."""
    stiffness = 1.0
    friction = 0.15
    x = -0.1
    above = np.array([0.0, -stiffness * x - friction])
    below = np.array([0.0, -stiffness * x + friction])
    # Filippov: the mean of the fields on both sides whose part across the line is 0.
    weight = below[1] / (below[1] - above[1])
    sliding = weight * above + (1 - weight) * below
    truth = truth_of("coulomb-oscillator", friction_force="3/20", x0="1", v0="0")
    stop = float(truth.scalars()["stop_time"])
    soon = float(truth.at(Fraction(10))["x"])
    late = float(truth.at(Fraction(1000))["x"])
    fields = "fields (x', v') above and below x = -0.1, m = k = 1, f = 0.15"
    return (
        (fields, f"{vector(above)}, {vector(below)}"),
        ("weight of the field above in Filippov's mean", number(weight)),
        ("x' and v' of Filippov's mean", vector(sliding)),
        ("certified time at which the block reaches the segment [s]", number(stop)),
        ("certified x at 10 s", number(soon)),
        ("certified x at 1000 s", number(late)),
    )


def crossings(path: np.ndarray) -> int:
    """How many pairs of segments of a polygon (n, 2) cross, neighbours left out."""
    a = path[:-1]
    b = path[1:]
    # Two segments cross if the ends of each lie on different sides of the other.
    i, j = np.triu_indices(len(a), 2)
    sides_of_i = _side(a[i], b[i], a[j]) * _side(a[i], b[i], b[j])
    sides_of_j = _side(a[j], b[j], a[i]) * _side(a[j], b[j], b[i])
    return int(np.sum((sides_of_i < 0) & (sides_of_j < 0)))


def _side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
    """(q - p) x (r - p), for points (..., 2): positive where r lies to the left of p -> q."""
    along = q - p
    aside = r - p
    side: np.ndarray = along[..., 0] * aside[..., 1] - along[..., 1] * aside[..., 0]
    return side


SLIPS = (
    KnownSlip(
        cases=("duffing", "driven-duffing"),
        where="(1.116)",
        says="the frequency is w0 (1 - 3 eps A^2/(8 w0^2))",
        holds=(
            "it rises with the amplitude for eps > 0: w0 (1 + 3 eps A^2/(8 w0^2)), as the text"
            " beside it says"
        ),
        measure=frequency_rises,
    ),
    KnownSlip(
        cases=("viscous-oscillator", "driven-oscillator"),
        where="(1.95), (1.96)",
        says="m x'' + 2 delta x' + k x = 0 decays as exp(-delta t)",
        holds="the damping is 2 delta x' per mass, delta = b/(2 m)",
        measure=damping_per_mass,
    ),
    KnownSlip(
        cases=("quaternions", "rotations"),
        where="(1.62) against (1.64)",
        says="a turn has the vector part -sin in one equation and +sin in the other",
        holds="the second is used: q = (cos phi/2, v sin phi/2) turns by +phi about v",
        measure=sense_of_turn,
    ),
    KnownSlip(
        cases=("rotations",),
        where="section 1.3.7",
        says="Euler angles diverge close to theta = pi/2",
        holds="they diverge where sin theta = 0, and nowhere else",
        measure=euler_angles_diverge,
    ),
    KnownSlip(
        cases=("free-rigid-body", "neglected-gyroscopic"),
        where="section 1.3.6",
        says="a constant angular momentum makes omega constant",
        holds="only if the body turns about a principal axis",
        measure=spin_wanders,
    ),
    KnownSlip(
        cases=("quaternions", "free-rigid-body"),
        where="after (1.75)",
        says="a quaternion and its derivative commute",
        holds="they do not; what holds is q qdot* = -qdot q*, and that both are orthogonal",
        measure=quaternion_and_rate,
    ),
    KnownSlip(
        cases=("driven-oscillator",),
        where="(1.106)",
        says="the amplitude has its peak at w^2 = w0^2 - 2 delta^2",
        holds="only for delta < w0/sqrt 2; beyond, it falls from w = 0 on",
        measure=peak_only_if_weakly_damped,
    ),
    KnownSlip(
        cases=("driven-duffing",),
        where="(1.121)",
        says="inside the root 3/4 eps A^2 counts with the other sign than w0^2",
        holds=(
            "W^2 = w0^2 + 3/4 eps A^2 - 2 delta^2 +- sqrt(f0^2/A^2 - 4 delta^2 (w0^2 + 3/4 eps A^2"
            " - delta^2))"
        ),
        measure=resonance_curve,
    ),
    KnownSlip(
        cases=("intermediate-axis", "dissipating-body"),
        where="section 1.7.3",
        says="the energy of a spin about axis i is L/(2 Ji)",
        holds="T = L^2/(2 J)",
        measure=energy_of_spin,
    ),
    KnownSlip(
        cases=("driven-oscillator", "van-der-pol", "stick-slip"),
        where="sections 1.5.4, 1.6.2",
        says="the theorem of Poincare and Bendixson is named for driven oscillators",
        holds=(
            "it does not bind them: time is a third coordinate, and paths cross in the plane of x"
            " and v"
        ),
        measure=driven_paths_cross,
    ),
    KnownSlip(
        cases=("asymmetric-field",),
        where="section 1.7.4, (1.139)",
        says="the total energy changes, since there is no potential at either end of the field",
        holds="T + Phi is kept with Phi = -integral of F, which differs between the ends",
        measure=kept_with_minus_integral,
    ),
    KnownSlip(
        cases=("driven-oscillator",),
        where="exercise 1.3",
        says="x = t sin(i w t) solves the driven oscillator at resonance",
        holds="f0 t exp(i w t)/(2 i w0) does; it grows linearly",
        measure=resonance_grows_linearly,
    ),
    KnownSlip(
        cases=("rotations",),
        where="figure 1.7",
        says="two quarter turns one after the other equal one quarter turn",
        holds="that is a statement about one vector: the product is a turn by 120 degrees",
        measure=one_vector,
    ),
    KnownSlip(
        cases=("moments-of-inertia", "rotations"),
        where="(1.30)",
        says="the tensor in space is J = A J_b A^T, with the A of (1.21)",
        holds=(
            "(1.21) leads from space to the body, (1.22): J = A^T J_b A; J = A J_b A^T needs the"
            " transpose of (1.21)"
        ),
        measure=turned_tensor,
    ),
    KnownSlip(
        cases=("free-rigid-body", "neglected-gyroscopic"),
        where="section 1.3.6, (1.32)",
        says="torques are the rate of change of the moment of inertia",
        holds=(
            "they are that of the angular momentum L = J omega, which (1.32) differentiates:"
            " without torque L stays, and J turns with the body"
        ),
        measure=torque_of_a_free_body,
    ),
    KnownSlip(
        cases=("harmonic-oscillator", "viscous-oscillator", "coulomb-oscillator"),
        where="captions of figures 1.15 and 1.16",
        says="the dashed lines are damped, and figure 1.15 shows the amplitude",
        holds=(
            "they are (1.93) and (1.94), undamped, as the text beside them says, and figure 1.15"
            " shows the position, whose amplitude stays"
        ),
        measure=dashed_lines_are_undamped,
    ),
    KnownSlip(
        cases=("quaternions",),
        where="exercise 1.2 a",
        says="(1.92) is the rule for quaternion products",
        holds="(1.56) is; (1.92) is the harmonic oscillator m x'' + k x = 0",
        measure=rule_of_the_product,
    ),
    KnownSlip(
        cases=("coulomb-oscillator", "phase-flow"),
        where="section 1.4.3, on Filippov's theory",
        says=(
            "the theory does not allow a line of singular points, and postulates transport along it"
        ),
        holds=(
            "its velocity on the line is a mean of the fields on both sides, and x' = v = 0 in"
            " both: no transport, a segment of rest that is reached in finite time"
        ),
        measure=segment_at_rest,
    ),
    *attitude_slips.SLIPS,
    *oscillator_slips.SLIPS,
)


def slips_of(case: str) -> tuple[Slip, ...]:
    """The slips that concern a case, measured now."""
    return tuple(
        Slip(where=slip.where, says=slip.says, holds=slip.holds, measured=slip.measure())
        for slip in SLIPS
        if case in slip.cases
    )
