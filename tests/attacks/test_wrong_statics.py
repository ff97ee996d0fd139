"""Wrong formulas of mass properties and of rotation algebra are seen, each in the quantity that it
spoils.
"""

import numpy as np
import pytest

from refdem.cases import _solids
from refdem.core import discovery
from refdem.errors import UsageError
from refdem.mechanics import freedom, koenig, mass_properties, quaternion, rotation
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene.shapes import Polyhedron
from refdem.solvers import _belt_points, rotation_algebra
from refdem.solvers import mass_properties as solid_solver


def failures(method, case, **given):
    """Quantities of the reference that fail."""
    instance = discovery.case(case).at(**given)
    findings = record_of(
        task_of(discovery.engine("reference"), method, instance, truth_of(instance), 4)
    ).findings
    return {f.quantity for f in findings if f.outcome in ("fail", "error")}


def spoilt(monkeypatch, place, name, change):
    """One function of the reference or of mechanics, changed."""
    if isinstance(place, dict):
        monkeypatch.setitem(place, name, change(place[name]))
    else:
        monkeypatch.setattr(place, name, change(getattr(place, name)))


def at_end_of_step(scene, time):
    """Time and place at the end of the step of 1/64 s in which a passage lies."""
    end = np.ceil(64 * time) / 64
    places, _ = _belt_points.states(scene, np.array([0.0, end]))
    return float(end), float(places[1])


def of_other_half(time, place):
    """A passage with x < 0 in place of one with x > 0."""
    return time, -place


ROTATION_FAULTS = {
    "product in the other order": (
        rotation_algebra.ANSWERS,
        "product",
        lambda f: lambda p, q: f(q, p),
        "quaternions",
        "p-q.1",
    ),
    "conjugate that changes the scalar": (
        rotation_algebra.ANSWERS,
        "conjugate",
        lambda f: lambda q: -f(q),
        "quaternions",
        "conjugate-of-sum.0",
    ),
    "inverse without the square": (
        rotation_algebra.ANSWERS,
        "inverse",
        lambda f: quaternion.conjugate,
        "quaternions",
        "inverse.0",
    ),
    "vectors turned backwards": (
        rotation_algebra.ANSWERS,
        "rotated",
        lambda f: lambda q, v: f(quaternion.conjugate(q), v),
        "quaternions",
        "rotated.1",
    ),
    "the matrix from space to body": (
        rotation_algebra.ANSWERS,
        "matrix-of-quaternion",
        lambda f: lambda q: f(q).T,
        "quaternions",
        "matrix.1",
    ),
    "rate with the body's omega": (
        rotation_algebra.ANSWERS,
        "rate",
        lambda f: lambda q, w: quaternion.product(q, np.array([0.0, *w])) / 2,
        "quaternions",
        "rate.1",
    ),
    "second rate without omega's own": (
        rotation_algebra.ANSWERS,
        "second-rate",
        lambda f: lambda q, w, rise: f(q, w, 0 * rise),
        "quaternions",
        "second-rate.0",
    ),
    "Pauli's eigenvalue without i": (
        rotation_algebra.ANSWERS,
        "complex-eigenvalue",
        lambda f: lambda q: f(q)[::-1],
        "quaternions",
        "complex-eigenvalue.0",
    ),
    "Pauli's matrices with those of the quaternions": (
        rotation,
        "pauli_matrix",
        lambda f: lambda v: -1j * f(v),
        "quaternions",
        "pauli-y.0",
    ),
    "u1 u2 for u1 and then u2": (
        rotation_algebra.ANSWERS,
        "product",
        lambda f: lambda q, p: f(p, q),
        "quaternions",
        "rotated-at-once.0",
    ),
    "a turn for a translation": (
        rotation_algebra.ANSWERS,
        "vector-sum",
        lambda f: lambda v, shift: f(v, np.cross(shift, v)),
        "rotations",
        "shift-commutator.1",
    ),
    "turns that commute": (
        rotation_algebra.ANSWERS,
        "matrix-product",
        lambda f: lambda m, n: (f(m, n) + f(n, m)) / 2,
        "rotations",
        "turn-commutator.1",
    ),
    "a commutator with the other sign": (
        rotation_algebra.ANSWERS,
        "matrix-difference",
        lambda f: lambda m, n: f(n, m),
        "rotations",
        "turn-commutator.3",
    ),
    "the angle of a loop from its cosine halved": (
        rotation_algebra,
        "turn_angle",
        lambda f: lambda m: f(m) / 2,
        "rotations",
        "loop-angle",
    ),
    "a step from the side of the body": (
        rotation,
        "first_order_turn",
        lambda f: lambda m, v: m + m @ rotation.cross_matrix(v),
        "rotations",
        "nine-entries.1",
    ),
    "nine entries that are taken for a rotation": (
        rotation,
        "nearest_turn",
        lambda f: lambda m: m,
        "rotations",
        "nine-entries-back.0",
    ),
    "a step scaled by its determinant": (
        rotation,
        "nearest_turn",
        lambda f: lambda m: m / np.cbrt(np.linalg.det(m)),
        "rotations",
        "nine-entries-back.4",
    ),
    "a quaternion that is not normalised": (
        rotation_algebra.ANSWERS,
        "unit",
        lambda f: lambda q: q,
        "rotations",
        "four-entries-back.0",
    ),
    "three conditions on nine entries": (
        freedom,
        "orthogonal_freedom",
        lambda f: lambda m: 6,
        "rotations",
        "nine-entries-freedom",
    ),
    "orthogonality without the transpose": (
        rotation,
        "orthogonality",
        lambda f: lambda m: m @ m - np.eye(3),
        "rotations",
        "nine-entries-defect.0",
    ),
    "a recurrence with plus": (
        rotation_algebra,
        "cosine_by_recurrence",
        lambda f: lambda angle, n: -f(angle + np.pi, n + 1) + f(angle, n - 1),
        "rotations",
        "cosine-by-recurrence",
    ),
    "n cos^n for cos^n": (
        rotation_algebra,
        "cosine_by_powers",
        lambda f: lambda angle, n: f(angle, n) + (n - 1) * np.cos(angle) ** n,
        "rotations",
        "cosine-3",
    ),
    "cos(a + b) - cos(a - b) for their sum": (
        rotation_algebra,
        "cosines_mixed",
        lambda f: lambda a, b: (np.cos(a + b) - np.cos(a - b)) / 2,
        "rotations",
        "cosines-mixed",
    ),
    "a product of cosines twice as large": (
        rotation_algebra,
        "cosines_mixed",
        lambda f: lambda a, b: 2 * f(a, b),
        "rotations",
        "cosines-mixed",
    ),
    "L^2/2 without the moment of inertia": (
        rotation_algebra.ANSWERS,
        "momentum-energy",
        lambda f: lambda momentum, inertia: momentum**2 / 2,
        "rotations",
        "momentum-energy",
    ),
    "the diagonal of a turned tensor for its principal moments": (
        mass_properties,
        "principal_moments",
        lambda f: lambda inertia: np.sort(np.diag(inertia)),
        "rotations",
        "principal-moments.0",
    ),
    "principal moments in falling order": (
        mass_properties,
        "principal_moments",
        lambda f: lambda inertia: f(inertia)[::-1],
        "rotations",
        "principal-moments.2",
    ),
    "the part along the base for that across it": (
        rotation_algebra,
        "rejection",
        lambda f: lambda a, b: np.subtract(a, f(a, b)),
        "rotations",
        "height",
    ),
    "a rejection that divides by |b| once": (
        rotation_algebra,
        "rejection",
        lambda f: lambda a, b: np.subtract(a, np.dot(a, b) / np.linalg.norm(b) * np.array(b)),
        "rotations",
        "rejection.0",
    ),
    "the inverse of rates transposed": (
        rotation,
        "euler_rate_inverse",
        lambda f: lambda phi, theta: rotation.euler_rate_matrix(phi, theta).T,
        "rotations",
        "rate-inverse.0",
    ),
    "rates in axes of the body": (
        rotation,
        "euler_rate_matrix",
        lambda f: lambda phi, theta: f(phi, -theta),
        "rotations",
        "rate-matrix.2",
    ),
    "r x omega for omega x r": (
        rotation_algebra.ANSWERS,
        "cross",
        lambda f: lambda omega, r: f(r, omega),
        "rotations",
        "swept.0",
    ),
    "omega^2 r^2 for the square of omega x r": (
        rotation_algebra.ANSWERS,
        "cross-square",
        lambda f: lambda omega, r: (omega @ omega) * (r @ r),
        "rotations",
        "swept-by-products",
    ),
    "1.121 with the sign of the stiffness turned inside the root": (
        rotation_algebra.response,
        "balanced_drives",
        lambda f: (
            lambda a, alpha, beta, delta, f0: f(
                a, alpha, beta, delta, np.sqrt(f0**2 + 6 * delta**2 * beta * a**4)
            )
        ),
        "bifurcations",
        "drives.0",
    ),
    "1.120 without the damping of the drive": (
        rotation_algebra.response,
        "balanced_force",
        lambda f: lambda a, drive, alpha, beta, delta: f(a, drive, alpha, beta, 0.0),
        "bifurcations",
        "forces.0",
    ),
    "a fold of a cube of 1 in place of 3/4": (
        rotation_algebra.response,
        "folds",
        lambda f: lambda alpha, beta, delta, f0: f(alpha, beta * 4 / 3, delta, f0),
        "bifurcations",
        "lower-fold.0",
    ),
    "folds with the damping of b": (
        rotation_algebra.response,
        "folds",
        lambda f: lambda alpha, beta, delta, f0: f(alpha, beta, delta / 2, f0),
        "bifurcations",
        "upper-fold.1",
    ),
    "doublings where cycles are superstable": (
        rotation_algebra,
        "doubling_point",
        lambda f: lambda doublings: (2.0, 1 + 5**0.5, 3.4985616993277)[doublings],
        "bifurcations",
        "doubling-of-4",
    ),
    "a cycle of two of the map eta x (1 - x) + 1/100": (
        rotation_algebra,
        "two_cycle",
        lambda f: lambda eta: f(eta) + 0.01,
        "bifurcations",
        "two-cycle.1",
    ),
    "values of a chaotic map that are spread uniformly": (
        rotation_algebra,
        "share_below",
        lambda f: lambda x: x,
        "bifurcations",
        "below-quarter",
    ),
    "the arcsine law without the root": (
        rotation_algebra,
        "share_below",
        lambda f: lambda x: f(x * x),
        "bifurcations",
        "below-half",
    ),
    "the energy of the centre without its mass": (
        koenig,
        "energy_of_centre",
        lambda f: lambda m, v: f(m, v) / m.sum(),
        "rotations",
        "koenig-energy",
    ),
    "a centre without weights": (
        koenig,
        "mean",
        lambda f: lambda m, vectors: vectors.mean(axis=0),
        "rotations",
        "koenig-energy",
    ),
    "energy about the centre at the velocities of space": (
        koenig,
        "energy_about_centre",
        lambda f: koenig.energy,
        "rotations",
        "koenig-energy",
    ),
    "arms from the origin about the centre, velocities too": (
        koenig,
        "angular_momentum_about_centre",
        lambda f: koenig.angular_momentum,
        "rotations",
        "koenig-momentum.0",
    ),
    "v x r for r x v": (
        koenig,
        "angular_momentum",
        lambda f: lambda m, r, v: f(m, v, r),
        "rotations",
        "points-momentum.0",
    ),
    "a tensor about the centre of mass for one about the origin": (
        koenig,
        "tensor_energy",
        lambda f: lambda m, r, omega: f(m, r - koenig.mean(m, r), omega),
        "rotations",
        "tensor-energy",
    ),
    "products of inertia left out": (
        koenig,
        "tensor_energy",
        lambda f: lambda m, r, omega: sum(f(m, r, axis) for axis in np.diag(omega)),
        "rotations",
        "tensor-energy",
    ),
    "a section a quarter of a period late": (
        rotation_algebra.ANSWERS,
        "belt-strobe",
        lambda f: lambda *given: f(*given[:-1], given[-1] + 0.25),
        "poincare-sections",
        "strobe-1.0",
    ),
    "passages where x < 0, at mirrored places": (
        _belt_points,
        "passed",
        lambda f: lambda *given: of_other_half(*f(*given)),
        "poincare-sections",
        "passage-1.1",
    ),
    "passages of the whole plane v = 0": (
        _belt_points,
        "passed",
        lambda f: lambda *given: (f(*given)[0], abs(f(*given)[1])),
        "poincare-sections",
        "passage-2.0",
    ),
    "the place where the step ends that passes v = 0": (
        _belt_points,
        "passed",
        lambda f: lambda scene, drive, time: at_end_of_step(scene, f(scene, drive, time)[0]),
        "poincare-sections",
        "passage-1.1",
    ),
    "the time where the chord of a step is zero": (
        _belt_points,
        "passed",
        lambda f: lambda scene, drive, time: (time, f(scene, drive, time)[1]),
        "poincare-sections",
        "passage-1.0",
    ),
    "mirror as a turn": (
        rotation_algebra,
        "mirror",
        lambda f: rotation_algebra.plane,
        "rotations",
        "mirror-determinant",
    ),
    "turn with the clock": (
        rotation_algebra,
        "plane",
        lambda f: lambda angle: f(-angle),
        "rotations",
        "plane-turn.0",
    ),
    "Euler angles in the other order": (
        rotation,
        "matrix_of_euler",
        lambda f: lambda phi, theta, psi: f(psi, theta, phi),
        "rotations",
        "euler-matrix.1",
    ),
    "rates with omega in body axes": (
        rotation,
        "euler_rates",
        lambda f: lambda phi, theta, w: f(-phi, theta, w),
        "rotations",
        "euler-rates.0",
    ),
    "f in place of omega": (
        rotation_algebra.ANSWERS,
        "rotation-energy",
        lambda f: lambda j, w: f(j, w / (2 * np.pi)),
        "rotations",
        "energy",
    ),
}


@pytest.mark.parametrize("fault", ROTATION_FAULTS)
def test_wrong_algebra_is_seen(monkeypatch, fault):
    place, name, change, case, quantity = ROTATION_FAULTS[fault]
    spoilt(monkeypatch, place, name, change)
    assert quantity in failures("rotation-algebra", case)


SOLID_FAULTS = {
    "no parallel axis": (
        "_of_point",
        lambda f: lambda mass, arm: 0 * f(mass, arm),
        "cuboid-at-corner.inertia.xx",
    ),
    "parallel axis with the wrong sign off the diagonal": (
        "_of_point",
        lambda f: lambda mass, arm: np.abs(f(mass, arm)),
        "points.inertia.xy",
    ),
    "an ellipsoid with a sixth": (
        "of_ellipsoid",
        lambda f: lambda a, d: scaled(f(a, d), 5 / 6),
        "ellipsoid.inertia.zz",
    ),
    "a cylinder's axes swapped": (
        "of_cylinder",
        lambda f: lambda a, h, d: f(a[::-1], h, d),
        "elliptical-cylinder.inertia.xx",
    ),
    "a stick about its end as about its middle": (
        "_of_point",
        lambda f: lambda mass, arm: 0 * f(mass, arm),
        "stick-at-end.inertia.yy",
    ),
    "a stick with h^2/3 about its middle": (
        "of_cylinder",
        lambda f: lambda a, h, d: scaled_across(f(a, h, d), 4),
        "stick.inertia.xx",
    ),
    "a sphere as its shell, 2/3 m r^2": (
        "of_ellipsoid",
        lambda f: lambda a, d: scaled(f(a, d), 5 / 3),
        "sphere.inertia.xx",
    ),
    "a hoop as a disc, 1/2 m r^2": (
        "of_cylinder",
        lambda f: lambda a, h, d: scaled(f(a, h, d), 1 / 2),
        "hoop.inertia.zz",
    ),
}


def scaled_across(found, factor):
    factors = np.diag([factor, factor, 1])
    return mass_properties.MassProperties(found.mass, found.centre, found.inertia * factors)


def scaled(found, factor):
    return mass_properties.MassProperties(found.mass, found.centre, found.inertia * factor)


@pytest.mark.parametrize("fault", SOLID_FAULTS)
def test_wrong_mass_properties_are_seen(monkeypatch, fault):
    name, change, quantity = SOLID_FAULTS[fault]
    spoilt(monkeypatch, mass_properties, name, change)
    assert quantity in failures("mass-properties", "moments-of-inertia")


def test_a_hollow_that_is_added_and_a_turn_that_is_backwards_are_seen(monkeypatch):
    monkeypatch.setattr(
        mass_properties.MassProperties, "__sub__", mass_properties.MassProperties.__add__
    )
    monkeypatch.setattr(solid_solver, "matrix", lambda q: quaternion.matrix(q).T)
    failed = failures("mass-properties", "moments-of-inertia")
    assert {
        "hollow-cylinder.mass",
        "hollow-sphere.mass",
        "hoop.inertia.zz",
        "hollow-cuboid.inertia.xx",
        "turned-tetrahedron.inertia.xy",
    } <= failed


def test_a_face_the_wrong_way_round_is_seen(monkeypatch):
    whole = _solids.pyramid
    monkeypatch.setattr(_solids, "pyramid", lambda a, b, c: flipped(whole(a, b, c)))
    failed = failures("mass-properties", "moments-of-inertia")
    assert "rectangular-pyramid.mass" in failed


def flipped(solid):
    return Polyhedron(
        vertices=solid.vertices, faces=(tuple(reversed(solid.faces[0])), *solid.faces[1:])
    )


@pytest.mark.parametrize("q", ["0,0,0,0", "1,0,0,0", "0,1,0,0", "0,1,2,3"])
def test_quaternions_without_unique_euler_angles_are_refused(q):
    with pytest.raises(UsageError, match="parameter q"):
        discovery.case("quaternions").at(q=q)


def test_what_has_no_axis_is_refused():
    with pytest.raises(UsageError, match="parameter p"):
        discovery.case("quaternions").at(p="0,0,0,0")
    with pytest.raises(UsageError, match="parameter omega"):
        discovery.case("rotations").at(omega="0,0,0")


def test_euler_angles_that_do_not_come_back_are_refused():
    with pytest.raises(UsageError, match="parameter euler"):
        discovery.case("rotations").at(euler="1,4,1")


def test_a_count_without_the_rank_is_seen(monkeypatch):
    monkeypatch.setattr(
        freedom, "first_order_freedom", lambda points, rods: points.size - len(rods)
    )
    failed = failures("rotation-algebra", "degrees-of-freedom")
    assert {"rods-6-on-4-in-2d", "rods-10-on-5-in-3d", "rod-twice"} <= failed


def test_points_in_a_plane_are_refused_where_a_generic_placement_is_asked_for():
    with pytest.raises(UsageError, match="parameter points"):
        discovery.case("degrees-of-freedom").at(points="0,0,0,1,0,0,0,1,0,1,1,0,2,3,0")
