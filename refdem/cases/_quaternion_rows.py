"""The operations of the case quaternions, and the sizes of their results."""

import numpy as np

from refdem.cases._algebra import Row
from refdem.core.parameters import Parameters


def rows(p: Parameters) -> list[Row]:
    """Algebra, then turns, then rates."""
    given = (p.p, p.q, p.r, p.vector, p.omega, p.rise)
    a, b, c, v, omega, rise = (value.tolist() for value in given)
    algebra = [
        ("p-q", "product", [a, b]),
        ("q-p", "product", [b, a]),
        ("commutator", "difference", ["p-q", "q-p"]),
        ("q-r", "product", [b, c]),
        ("left", "product", ["p-q", c]),
        ("right", "product", [a, "q-r"]),
        ("conjugate-of-product", "conjugate", ["p-q"]),
        ("sum", "sum", [a, b]),
        ("conjugate-of-sum", "conjugate", ["sum"]),
        ("inverse", "inverse", [b]),
        ("one", "product", [b, "inverse"]),
        ("absolute", "absolute", [b]),
        ("u", "unit", [b]),
        ("real-product", "real-product", [a, b]),
        ("complex-product", "complex-product", [a, b]),
        ("complex-eigenvalue", "complex-eigenvalue", [b]),
    ]
    turns = [
        ("rotated", "rotated", ["u", v]),
        ("-u", "negative", ["u"]),
        ("rotated-by-minus-u", "rotated", ["-u", v]),
        ("matrix", "matrix-of-quaternion", ["u"]),
        ("back", "quaternion-of-matrix", ["matrix"]),
        ("euler", "euler-of-matrix", ["matrix"]),
        ("turned-twice", "product", ["u", "u"]),
        ("rotated-twice", "rotated", ["turned-twice", v]),
    ]
    rates = [
        ("rate", "rate", ["u", omega]),
        ("second-rate", "second-rate", ["u", omega, rise]),
        ("orthogonal", "dot", ["u", "rate"]),
        ("rate-conjugate", "conjugate", ["rate"]),
        ("u-conjugate", "conjugate", ["u"]),
        ("u-rate", "product", ["u", "rate-conjugate"]),
        ("rate-u", "product", ["rate", "u-conjugate"]),
        ("anticommute", "sum", ["u-rate", "rate-u"]),
        ("omega-back", "omega-of-rate", ["u", "rate"]),
        ("omega-body", "body-omega-of-rate", ["u", "rate"]),
    ]
    return algebra + turns + rates


def sizes(p: Parameters) -> dict[str, float]:
    """Products of the sizes of what is multiplied; a turn moves its vector by twice an error of u,
    two turns by four times.
    """
    given = (p.p, p.q, p.r, p.vector, p.omega, p.rise)
    a, b, c, v, w, rise = (float(np.linalg.norm(value)) or 1.0 for value in given)
    return {
        "p-q": a * b,
        "q-p": a * b,
        "commutator": a * b,
        "conjugate-of-product": a * b,
        "real-product": a * b,
        "complex-product": a * b,
        "sum": a + b,
        "conjugate-of-sum": a + b,
        "absolute": b,
        "complex-eigenvalue": b,
        "q-r": b * c,
        "left": a * b * c,
        "right": a * b * c,
        "inverse": 1 / b,
        "second-rate": rise + w * w,
        "rotated": 2 * v,
        "rotated-by-minus-u": 2 * v,
        "rotated-twice": 4 * v,
        "rate": w,
        "orthogonal": w,
        "rate-conjugate": w,
        "u-rate": w,
        "rate-u": w,
        "anticommute": w,
        "omega-back": w,
        "omega-body": w,
        "euler": float(np.pi) * steepness(p),
    }


def steepness(p: Parameters) -> float:
    """How much steeper Euler angles are than the attitude: 1/sin theta."""
    w, x, y, z = p.q / np.linalg.norm(p.q)
    return float(1 / max(1e-100, 2 * np.hypot(x, y) * np.hypot(w, z)))
