"""What every driver of a code needs at its border: the request, quaternions (w, x, y, z), and the
trajectory file.
"""

from pathlib import Path

HEADER = "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz"


class UnsupportedError(Exception):
    """The code cannot run this scene; the text says why."""


def cannot(condition, why):
    """Raises UnsupportedError if the code cannot say what the scene says."""
    if condition:
        raise UnsupportedError(why)


def of_kind(request, kind):
    """The elements of one kind."""
    return [element for element in request["scene"]["elements"] if element["kind"] == kind]


def refuse_shapes(request):
    """Raises UnsupportedError for a body that is neither a point nor a solid sphere."""
    for body in request["scene"]["bodies"]:
        moment = 0.4 * body["mass"] * body["shape"].get("radius", 0.0) ** 2
        cannot(body["shape"]["kind"] == "polyhedron", "polyhedra")
        cannot(
            any(abs(j - moment) > 1e-14 * max(j, moment) for j in body["inertia"]),
            "inertia other than that of a solid sphere",
        )


def contact_law(request, *known):
    """The contact law, or None; raises UnsupportedError unless it is one of `known`, or linear if
    none are named.
    """
    known = known or ("linear",)
    laws = of_kind(request, "contact")
    cannot(
        any(law["law"] not in known for law in laws),
        f"contact laws other than {' and '.join(known)}",
    )
    if laws:
        return laws[0]
    return None


def product(p, q):
    """The product p q of two quaternions (4)."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    # (p, a)(q, b) = (p q - a . b, p b + q a + a x b), Hamilton 1843.
    w = pw * qw - px * qx - py * qy - pz * qz
    x = pw * qx + px * qw + py * qz - pz * qy
    y = pw * qy - px * qz + py * qw + pz * qx
    z = pw * qz + px * qy - py * qx + pz * qw
    return w, x, y, z


def conjugate(q):
    """The conjugate q* of a quaternion (4)."""
    return (q[0], -q[1], -q[2], -q[3])


def turned(q, vector):
    """q v q*: a vector of the body seen from space."""
    return product(product(q, (0.0, *vector)), conjugate(q))[1:]


def quaternion(rotation):
    """The unit quaternion (w, x, y, z), w >= 0, of a rotation matrix, by rows.

    The largest of |w|, |x|, |y|, |z| comes from the diagonal, the others from it (Shepperd 1978).
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
    # Four times the square of each component, from the diagonal.
    squares = {
        "w": 1 + r00 + r11 + r22,
        "x": 1 + r00 - r11 - r22,
        "y": 1 - r00 + r11 - r22,
        "z": 1 - r00 - r11 + r22,
    }
    # Four times the products w x, w y, w z and x y, x z, y z, from the pairs across it.
    wx = r21 - r12
    wy = r02 - r20
    wz = r10 - r01
    xy = r01 + r10
    xz = r02 + r20
    yz = r12 + r21
    # Four times the products of one component with all four (w, x, y, z).
    products = {
        "w": (squares["w"], wx, wy, wz),
        "x": (wx, squares["x"], xy, xz),
        "y": (wy, xy, squares["y"], yz),
        "z": (wz, xz, yz, squares["z"]),
    }
    largest = max(squares, key=squares.get)
    w, x, y, z = products[largest]
    # (4 q_k q)/(4 |q_k|) is q or -q, with 4 |q_k| = 2 sqrt(4 q_k^2).
    scale = 0.5 / squares[largest] ** 0.5
    if w < 0:
        scale = -scale
    return (scale * w, scale * x, scale * y, scale * z)


def matrix(q):
    """The rotation matrix of a unit quaternion (w, x, y, z), by rows."""
    columns = [turned(q, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    return [list(row) for row in zip(*columns, strict=True)]


def tensor(body):
    """The inertia tensor in space axes, rows."""
    axes = [
        turned(body["attitude"], axis)
        for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    ]
    return [
        [
            sum(j * axis[m] * axis[n] for j, axis in zip(body["inertia"], axes, strict=True))
            for n in range(3)
        ]
        for m in range(3)
    ]


def write(path, rows):
    """The trajectory: rows of t, body, position, velocity, attitude (None: as at the start),
    omega.
    """
    with Path(path).open("w") as file:
        file.write(HEADER + "\n")
        for row in rows:
            file.write(line(*row))


def write_slopes(path, rows):
    """The derivatives: rows of the key of a number, and then as those of a trajectory."""
    with Path(path).open("w") as file:
        file.write(f"number,{HEADER}\n")
        for key, *row in rows:
            file.write(f"{key},{line(*row)}")


def line(t, body, *vectors):
    """A row of a table as a line of its file."""
    numbers = [repr(float(x)) for vector in vectors for x in vector]
    return ",".join([repr(t), str(body), *numbers]) + "\n"
