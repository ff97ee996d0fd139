"""Mass properties and rotation algebra: truth against other derivations, engines that say some of
it, and wrong formulas that are seen.
"""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from refdem.cases import _solids
from refdem.core import discovery
from refdem.core.problem import Request
from refdem.mechanics import rotation
from refdem.mechanics.mass_properties import of_polyhedron
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.scene import box
from tests.rationals import hamilton

STATICS = {
    "moments-of-inertia": [
        {},
        {
            "a": "17/10",
            "b": "0.3",
            "c": "12",
            "density": "7800",
            "hollow": "0.9",
            "thin": "1/4",
            "attitude": "1,2,3,4",
        },
    ],
    "rotations": [
        {},
        {
            "angle": "-5/2",
            "euler": "-3,1/50,3",
            "omega": "100,3,-7",
            "near": "1e-6",
            "frequency": "50",
            "shifts": "1e3,2,3,-1/3,5,7",
            "small": "1/1000",
            "step": "1",
            "multiple": "32",
        },
    ],
    "degrees-of-freedom": [{}, {"points": "1,2,3,-1,4,1e3,7,8,1,0.5,0.25,-3,9,-9,2"}],
    "quaternions": [
        {},
        {"p": "1e5,2,3,4", "q": "-1,2,3,1e-3", "omega": "0.001,2,3"},
        {"q": "1,-100,50,2"},
    ],
    "poincare-sections": [
        {},
        {"friction_law": "quadratic", "gamma": "1/2", "eta": "6/5", "x0": "0", "v0": "0"},
        {"eta": "3/2", "x0": "3", "v0": "-2", "belt": "1/2"},
    ],
    "bifurcations": [
        {},
        {"delta": "1/5", "eta": "4"},
        {"delta": "1e-6", "beta": "1e-3", "f0": "50", "amplitude": "100", "eta": "3.0001"},
        {"delta": "6/25", "alpha": "11/10", "f0": "8/5", "amplitude": "17/10"},
        {"beta": "-1/20", "delta": "1/50", "f0": "1/10"},
        {"beta": "-1/5", "delta": "1/20", "f0": "1/10", "amplitude": "9/10"},
    ],
}
EVERY = [(case, given) for case, sets in STATICS.items() for given in sets]
ANSWERS = {
    "degrees-of-freedom": ["rotation-algebra"],
    "moments-of-inertia": ["mass-properties"],
    "rotations": ["rotation-algebra"],
    "quaternions": ["rotation-algebra"],
    "bifurcations": ["rotation-algebra"],
    "poincare-sections": ["rotation-algebra"],
}
MUJOCO = [
    ("moments-of-inertia", "compiler"),
    ("moments-of-inertia", "mesh-compiler"),
    ("rotations", "algebra"),
    ("quaternions", "algebra"),
]
PYMUNK = [("moments-of-inertia", "moments"), ("rotations", "vectors")]
SAID = (
    [("mujoco", *each) for each in MUJOCO]
    + [("pymunk", *each) for each in PYMUNK]
    + [("rebound", case, "rotation") for case in ("quaternions", "rotations")]
)


def failures(engine, method, case, **given):
    """Quantities that fail, and how many were decided."""
    instance = discovery.case(case).at(**given)
    findings = record_of(
        task_of(discovery.engine(engine), method, instance, truth_of(instance), 4)
    ).findings
    return {f.quantity for f in findings if f.outcome in ("fail", "error")}, sum(
        f.outcome == "pass" for f in findings
    )


@pytest.mark.parametrize("ulps", [-7, -2, 7])
@pytest.mark.parametrize(("case", "given"), EVERY)
def test_an_input_moved_by_some_ulps_is_answered_and_counts_what_the_input_counts(
    case, given, ulps
):
    instance = discovery.case(case).at(**given)
    moved = instance.problem.perturbed(ulps)
    engine = discovery.engine("reference")
    for method in ANSWERS[case]:
        values, values_of_moved = (
            engine.run(Request(problem=problem, method=method, step=problem.interval))[0].values
            for problem in (instance.problem, moved)
        )
        assert values_of_moved.keys() == values.keys()
        assert all(np.all(np.isfinite(value)) for value in values_of_moved.values())
        if case == "degrees-of-freedom":
            assert all(np.array_equal(values_of_moved[name], values[name]) for name in values)


@pytest.mark.parametrize(("case", "given"), EVERY)
def test_the_reference_says_every_number(case, given):
    failed, passed = failures("reference", ANSWERS[case][0], case, **given)
    assert failed == set()
    assert passed == len(discovery.case(case).at(**given).quantities) + 1  # determinism


@pytest.mark.parametrize(("engine", "case", "method"), SAID)
def test_engines_say_what_they_know_and_hold_it(engine, case, method):
    for given in STATICS[case]:
        failed, passed = failures(engine, method, case, **given)
        assert failed == set()
        assert passed > 2


def test_an_engine_that_knows_nothing_of_it_refuses():
    instance = discovery.case("moments-of-inertia").at()
    engine = discovery.engine("rebound")
    assert all(
        "cannot run mass properties" in engine.unsupported(instance.problem, method)
        for method in engine.methods
    )
    pymunk = discovery.engine("pymunk")
    quaternions = discovery.case("quaternions").at()
    assert "supports none" in pymunk.unsupported(quaternions.problem, pymunk.method("vectors"))


def of_tetrahedra(vertices, faces):
    """Volume, mean place and second moments about it in rational arithmetic, by tetrahedra from the
    first vertex.
    """
    base = vertices[0]
    volume = Fraction(0)
    first = [Fraction(0)] * 3
    second = [[Fraction(0)] * 3 for _ in range(3)]
    for face in faces:
        for k in range(1, len(face) - 1):
            corners = [base, *(vertices[face[i]] for i in (0, k, k + 1))]
            edges = [[x - y for x, y in zip(corner, base, strict=True)] for corner in corners[1:]]
            (a, b, c), (d, e, f), (g, h, i) = edges
            size = (a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)) / 6
            volume += size
            total = [sum(corner[n] for corner in corners) for n in range(3)]
            for n in range(3):
                first[n] += size * total[n] / 4
                for m in range(3):
                    second[n][m] += (
                        size
                        * (sum(corner[n] * corner[m] for corner in corners) + total[n] * total[m])
                        / 20
                    )
    centre = [x / volume for x in first]
    return (
        volume,
        centre,
        [[second[n][m] / volume - centre[n] * centre[m] for m in range(3)] for n in range(3)],
    )


@pytest.mark.parametrize(
    "name",
    [
        "rectangular-pyramid",
        "right-angle-wedge",
        "isosceles-wedge",
        "tetrahedron",
        "angle",
        "turned-tetrahedron",
    ],
)
def test_truth_of_polyhedra_is_the_sum_of_their_tetrahedra(name):
    from refdem.truth.closed_forms.moments_of_inertia import every

    instance = discovery.case("moments-of-inertia").at(
        a="3/2", b="5/4", c="7/8", attitude="1,1,0,0"
    )
    piece = next(piece for piece in _solids.solids(instance.p) if piece.name == name)
    vertices = [[Fraction(x) for x in vertex] for vertex in piece.shape.vertices]
    if name.startswith("turned"):
        vertices = [[x, -z, y] for x, y, z in vertices]  # a quarter turn about x
    means = every(instance.p)[name]
    assert (means.volume, list(means.centre), [list(row) for row in means.second]) == of_tetrahedra(
        vertices, piece.shape.faces
    )


@pytest.mark.parametrize("name", ["ellipsoid", "elliptical-cylinder", "hollow-cylinder"])
def test_truth_of_round_solids_is_a_quadrature(name):
    instance = discovery.case("moments-of-inertia").at(a="1.5", b="0.75", c="2", hollow="1/4")
    scalars = {n: float(ball.mid) for n, ball in instance.truth().scalars().items()}
    a = 1.5
    b = 0.75
    c = 2.0
    nodes, weights = np.polynomial.legendre.leggauss(40)
    angles = np.arange(64) * (2 * np.pi / 64)
    low, across = (0.25, a) if name == "hollow-cylinder" else (0.0, b)
    radii = low + (1 - low) * (nodes + 1) / 2
    areas = (1 - low) * weights / 2
    heights = [(z * c, w * c, np.sqrt(1 - z * z)) for z, w in zip(nodes, weights, strict=True)]
    if name == "ellipsoid":
        heights = heights
    else:
        heights = [(z * c / 2, w * c / 2, 1.0) for z, w in zip(nodes, weights, strict=True)]
    total = np.zeros(4)
    for z, thick, shrunk in heights:
        for r, dr in zip(radii, areas, strict=True):
            x = shrunk * r * a * np.cos(angles)
            y = shrunk * r * across * np.sin(angles)
            mass = 0.5 * thick * dr * r * shrunk**2 * a * across * (2 * np.pi / 64)
            total += mass * np.array(
                [64, np.sum(y * y + z * z), np.sum(x * x + z * z), np.sum(x * x + y * y)]
            )
    expected = [
        scalars[f"{name}.{entry}"] for entry in ("mass", "inertia.xx", "inertia.yy", "inertia.zz")
    ]
    assert total == pytest.approx(expected, rel=1e-12)


def test_a_triangulated_ellipsoid_comes_to_truth_with_the_square_of_its_edges():
    instance = discovery.case("moments-of-inertia").at()
    exact = float(instance.truth().scalars()["ellipsoid.inertia.xx"].mid)
    errors = [
        abs(of_polyhedron(*triangulated(n), 0.5).inertia[0, 0] / exact - 1) for n in (8, 16, 32)
    ]
    assert [np.log2(a / b) for a, b in pairwise(errors)] == pytest.approx([2, 2], abs=0.1)


def triangulated(n):
    """Vertices and faces of an ellipsoid with half axes 1, 2, 3, from a sphere's circles of
    latitude.
    """
    rings = [(np.pi * i / n, 2 * np.pi * j / (2 * n)) for i in range(1, n) for j in range(2 * n)]
    vertices = [
        (np.sin(t) * np.cos(f), 2 * np.sin(t) * np.sin(f), 3 * np.cos(t)) for t, f in rings
    ] + [(0, 0, 3), (0, 0, -3)]
    top = len(rings)
    bottom = len(rings) + 1
    m = 2 * n
    bands = [
        (i * m + j, (i + 1) * m + j, (i + 1) * m + (j + 1) % m, i * m + (j + 1) % m)
        for i in range(n - 2)
        for j in range(m)
    ]
    caps = [(top, j, (j + 1) % m) for j in range(m)] + [
        (bottom, (n - 2) * m + (j + 1) % m, (n - 2) * m + j) for j in range(m)
    ]
    return vertices, bands + caps


@pytest.mark.parametrize("entry", [(0, 0), (1, 1), (2, 2)])
def test_a_triangulated_cylinder_comes_to_truth_with_the_square_of_its_edges(entry):
    instance = discovery.case("moments-of-inertia").at()
    name = "elliptical-cylinder.inertia." + "xyz"[entry[0]] * 2
    exact = float(instance.truth().scalars()[name].mid)
    errors = [abs(of_polyhedron(*prism(n), 0.5).inertia[entry] / exact - 1) for n in (16, 32, 64)]
    assert [np.log2(a / b) for a, b in pairwise(errors)] == pytest.approx([2, 2], abs=0.05)


def prism(n):
    """Vertices and faces of a prism in a cylinder with half axes 1, 2 and height 3."""
    angles = 2 * np.pi * np.arange(n) / n
    ring = [(float(np.cos(f)), 2 * float(np.sin(f))) for f in angles]
    sides = [(j, (j + 1) % n, n + (j + 1) % n, n + j) for j in range(n)]
    return [(x, y, z) for z in (-1.5, 1.5) for x, y in ring], [
        *sides,
        tuple(range(n - 1, -1, -1)),
        tuple(range(n, 2 * n)),
    ]


@pytest.mark.parametrize("sides", [("1", "2", "3"), ("7/4", "1/8", "5")])
def test_truth_of_a_cuboid_is_that_of_its_triangles(sides):
    truth = (
        discovery.case("moments-of-inertia")
        .at(**dict(zip("abc", sides, strict=True)))
        .truth()
        .scalars()
    )
    body = box(*(float(Fraction(side)) for side in sides))
    found = of_polyhedron(body.vertices, body.faces, 0.5)
    expected = [
        float(truth[f"cuboid.{what}"].mid)
        for what in ("mass", "inertia.xx", "inertia.yy", "inertia.zz")
    ]
    assert [found.mass, *np.diag(found.inertia)] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("hollow", ["1/2", "9/10"])
def test_truth_of_hollow_bodies_is_that_of_triangles_of_both_surfaces(hollow):
    truth = discovery.case("moments-of-inertia").at(hollow=hollow).truth().scalars()
    numbers = {name: float(ball.mid) for name, ball in truth.items()}
    part = float(Fraction(hollow))
    outer, inner = (
        of_polyhedron(b.vertices, b.faces, 0.5)
        for b in (box(1, 2, 3), box(part, 2 * part, 3 * part))
    )
    expected = [outer.mass - inner.mass, *np.diag(outer.inertia - inner.inertia)]
    assert [numbers[f"hollow-cuboid.{what}"] for what in ("mass", *DIAGONAL)] == pytest.approx(
        expected, rel=1e-14
    )
    mass = numbers["hollow-cylinder.mass"]
    assert mass == pytest.approx(0.5 * np.pi * (1 - part**2) * 3, rel=1e-14)
    assert numbers["hollow-cylinder.inertia.zz"] == pytest.approx(
        mass * (1 + part**2) / 2, rel=1e-14
    )
    for entry, name in enumerate(DIAGONAL):
        found = [of_polyhedron(*ring(n, part), 0.5) for n in (32, 64)]
        errors = [
            abs(pipe.inertia[entry, entry] / numbers[f"hollow-cylinder.{name}"] - 1)
            for pipe in found
        ]
        assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.05)


DIAGONAL = ("inertia.xx", "inertia.yy", "inertia.zz")


def ring(n, part):
    """Vertices and faces of a prism with a hole, in a cylinder of radius 1 and height 3: one
    surface, inside it turned inwards.
    """
    around = [
        (float(np.cos(2 * np.pi * j / n)), float(np.sin(2 * np.pi * j / n))) for j in range(n)
    ]
    vertices = [(r * x, r * y, z) for r in (1.0, part) for z in (-1.5, 1.5) for x, y in around]
    quads = [(j, (j + 1) % n) for j in range(n)]
    outside = [(j, k, n + k, n + j) for j, k in quads]
    inside = [(2 * n + j, 3 * n + j, 3 * n + k, 2 * n + k) for j, k in quads]
    floor = [(j, 2 * n + j, 2 * n + k, k) for j, k in quads]
    top = [(n + j, n + k, 3 * n + k, 3 * n + j) for j, k in quads]
    return vertices, [*outside, *inside, *floor, *top]


def test_limits_of_the_table():
    long = discovery.case("moments-of-inertia").at(a="1e-8", b="1e-8", c="3")
    scalars = {name: float(ball.mid) for name, ball in long.truth().scalars().items()}
    mass = scalars["elliptical-cylinder.mass"]
    middle = scalars["elliptical-cylinder.inertia.xx"]
    assert middle == pytest.approx(mass * 9 / 12, rel=1e-14)
    end = scalars["cuboid-at-corner.inertia.xx"] / scalars["cuboid.inertia.xx"]
    assert end == pytest.approx(4, rel=1e-14)  # a stick held at its end against its middle
    ball = discovery.case("moments-of-inertia").at(a="2", b="2", c="2", density="1")
    scalars = {name: float(b.mid) for name, b in ball.truth().scalars().items()}
    assert scalars["ellipsoid.inertia.zz"] == pytest.approx(
        2 / 5 * 4 / 3 * np.pi * 8 * 4, rel=1e-14
    )


def test_thin_and_round_solids_are_the_limits_of_the_table():
    thin = 2.0**-13
    instance = discovery.case("moments-of-inertia").at(a="2", c="3", thin="1/8192")
    scalars = {name: float(ball.mid) for name, ball in instance.truth().scalars().items()}

    def per_mass(solid, axis):
        return scalars[f"{solid}.inertia.{axis}"] / scalars[f"{solid}.mass"]

    # m h^2/12 about the middle, m h^2/3 about the end, both but for m r^2/4.
    assert per_mass("stick", "xx") == pytest.approx(9 / 12, rel=10 * thin**2)
    assert per_mass("stick-at-end", "yy") == pytest.approx(9 / 3, rel=10 * thin**2)
    # 2/5 m r^2, and m r^2 but for the thickness of the wall.
    assert per_mass("sphere", "zz") == pytest.approx(2 / 5 * 4, rel=1e-14)
    assert per_mass("hoop", "zz") == pytest.approx(4, rel=1.01 * thin)
    # 2/5 m (r_o^5 - r_i^5)/(r_o^3 - r_i^3) with r_i = r_o/2.
    hollow = 2 / 5 * (32 - 1) / (8 - 1)
    assert per_mass("hollow-sphere", "xx") == pytest.approx(hollow, rel=1e-14)


def test_truth_of_quaternions_is_hamiltons():
    truth = discovery.case("quaternions").at().truth().scalars()
    p = [Fraction(1), Fraction(-2), Fraction(1, 2), Fraction(3)]
    q = [Fraction(2), Fraction(1), Fraction(-1), Fraction(1, 4)]
    r = [Fraction(-1), Fraction(1, 3), Fraction(2), Fraction(1)]
    v = [Fraction(0), Fraction(1), Fraction(2), Fraction(-1, 2)]
    omega = [Fraction(0), Fraction(3, 4), Fraction(-1), Fraction(2)]
    square = sum(x * x for x in q)
    star = [q[0], -q[1], -q[2], -q[3]]
    turned = [x / square for x in hamilton(hamilton(q, v), star)]
    body = [x / square for x in hamilton(hamilton(star, omega), q)]
    columns = []
    for k in range(3):
        # A column of the matrix is the picture q e_k q*/|q|^2 of a unit vector.
        unit = [Fraction(0)] * 4
        unit[1 + k] = Fraction(1)
        picture = hamilton(hamilton(q, unit), star)
        columns.append([x / square for x in picture[1:]])
    matrix = [columns[k][i] for i in range(3) for k in range(3)]
    p_q = hamilton(p, q)
    q_p = hamilton(q, p)
    expected = {
        "p-q": p_q,
        "commutator": [x - y for x, y in zip(p_q, q_p, strict=True)],
        "left": hamilton(p_q, r),
        "right": hamilton(p, hamilton(q, r)),
        "inverse": [x / square for x in star],
        "one": [Fraction(1), Fraction(0), Fraction(0), Fraction(0)],
        "rotated": turned[1:],
        "rotated-by-minus-u": turned[1:],
        "matrix": matrix,
        "omega-body": body[1:],
        "omega-back": omega[1:],
    }
    for name, numbers in expected.items():
        for i, number in enumerate(numbers):
            ball = truth[f"{name}.{i}"]
            assert abs(ball.mid - number) <= ball.radius
    ball = truth["absolute"]
    other = truth["complex-eigenvalue.1"]
    assert abs(ball.mid**2 - square) < Fraction(1, 10**38)
    assert abs(other.mid**2 - (square - 4)) < Fraction(1, 10**38)  # q has w = 2


def test_truth_of_rotations_is_that_of_products_of_sines_and_cosines():
    instance = discovery.case("rotations").at()
    truth = {name: float(ball.mid) for name, ball in instance.truth().scalars().items()}
    about = {
        axis: {s: rotation.about_axis(i, np.radians(s)) for s in (90, -90, 180)}
        for i, axis in enumerate("xyz")
    }
    expected = {f"{axis}{s:+d}": turn for axis, turns in about.items() for s, turn in turns.items()}
    expected |= {
        "z-then-x": about["x"][90] @ about["z"][90],
        "x-then-z": about["z"][90] @ about["x"][90],
        "globe": about["x"][-90] @ about["y"][-90],
        "two-halves": about["z"][180],
        "x-y-back": about["z"][90],
        "euler-matrix": about_z(0.5) @ rotation.about_axis(0, 0.75) @ about_z(-1.25),
    }
    for name, turn in expected.items():
        assert [truth[f"{name}.{i}"] for i in range(9)] == pytest.approx(
            turn.ravel().tolist(), abs=1e-15
        )
    assert truth["globe-angle"] == pytest.approx(np.radians(120))
    assert truth["energy-ratio"] == pytest.approx(39.4784176043574, rel=1e-14)
    assert abs(truth["near-rates.2"]) > 900 * abs(truth["near-quaternion-rate.0"])


def test_two_small_turns_fail_to_commute_by_the_square_of_their_angle():
    for small in ("1/8", "1/64"):
        truth = discovery.case("rotations").at(small=small).truth().scalars()
        h = float(Fraction(small))
        # h^2 about z, to a part h^2; what is beside it is of third order.
        assert float(truth["turn-commutator.3"].mid) == pytest.approx(h**2, rel=h**2)
        assert float(truth["loop-angle"].mid) == pytest.approx(h**2, rel=h**2)
        assert float(truth["beyond-leading.2"].mid) == pytest.approx(h**3 / 2, rel=h)
        assert truth["shift-commutator.0"].mid == 0


def test_nine_entries_lag_four_times_as_far_as_a_quaternion():
    truth = discovery.case("rotations").at(step="1/1000").truth().scalars()
    v = 1e-3 * float(np.linalg.norm([1, -2, 0.5]))
    # |v| - atan |v| and |v| - 2 atan(|v|/2): v^3/3 and v^3/12.
    assert float(truth["nine-entries-lag"].mid) == pytest.approx(v**3 / 3, rel=v)
    assert float(truth["four-entries-lag"].mid) == pytest.approx(v**3 / 12, rel=v)
    assert float(truth["nine-entries-determinant"].mid - 1) == pytest.approx(v**2, rel=v)
    assert truth["nine-entries-freedom"].mid == 3


def about_z(angle):
    return rotation.about_axis(2, angle)


def test_truth_of_freedom_is_the_chapters():
    scalars = discovery.case("degrees-of-freedom").at().truth().scalars()
    found = {name: int(ball.mid) for name, ball in scalars.items()}
    assert [found[f"2d-{n}"] for n in range(1, 6)] == [2, 3, 3, 3, 3]
    assert [found[f"3d-{n}"] for n in range(1, 6)] == [3, 5, 6, 6, 6]
    assert [
        found[f"{name}-first-order"]
        for name in ("coplanar-4", "coplanar-5", "collinear-3", "2d-collinear-3")
    ] == [7, 8, 7, 4]
    assert [
        found[f"{name}-rigid"]
        for name in ("coplanar-4", "coplanar-5", "collinear-3", "2d-collinear-3")
    ] == [6, 6, 5, 3]
    assert (found["rods-6-on-4-in-2d"], found["rods-10-on-5-in-3d"], found["rod-twice"]) == (
        3,
        6,
        5,
    )
