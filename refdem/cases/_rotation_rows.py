"""The operations of the case rotations, and the sizes of their results."""

from typing import Any

import numpy as np

from refdem.cases._algebra import Row, X, Y, Z
from refdem.core.parameters import Parameters


def rows(p: Parameters) -> list[Row]:
    """Plane, products of turns, Euler angles, energies."""
    angle = [p.angle]
    v = p.vector.tolist()
    euler = p.euler.tolist()
    turns: list[Row] = []
    for axis, unit in (("x", X), ("y", Y), ("z", Z)):
        for degrees in (90, -90, 180):
            radians = float(np.radians(degrees))
            turns.append((f"{axis}{degrees:+d}", "turn-about", [unit, [radians]]))
    products: list[tuple[str, str, str]] = [
        ("z-then-x", "x+90", "z+90"),
        ("x-then-z", "z+90", "x+90"),
        ("globe", "x-90", "y-90"),
        ("two-halves", "x+180", "y+180"),
        ("x-y", "x+90", "y+90"),
        ("x-y-back", "x-y", "x-90"),
    ]
    return [
        ("plane-turn", "plane-turn", [angle, v]),
        ("complex-turn", "complex-turn", [angle, v]),
        ("plane-eigenvalue", "plane-eigenvalue", [angle]),
        ("plane-determinant", "plane-determinant", [angle]),
        ("mirror", "mirror", [angle, v]),
        ("mirror-determinant", "mirror-determinant", [angle]),
        *turns,
        *((name, "matrix-product", [first, second]) for name, first, second in products),
        ("globe-x", "matrix-vector", ["globe", X]),
        ("globe-angle", "turn-angle", ["globe"]),
        ("globe-determinant", "determinant", ["globe"]),
        *euler_rows(p, euler),
    ]


def euler_rows(p: Parameters, euler: list[float]) -> list[Any]:
    """Euler angles and back, their rates beside the quaternion's, and the energies."""
    omega = p.omega.tolist()
    return [
        ("euler-matrix", "matrix-of-euler", [euler]),
        ("euler-back", "euler-of-matrix", ["euler-matrix"]),
        ("euler-quaternion", "quaternion-of-euler", [euler]),
        ("euler-rates", "euler-rates", [euler, omega]),
        ("near-rates", "euler-rates", [[euler[0], p.near, euler[2]], omega]),
        ("near-quaternion", "quaternion-of-euler", [[euler[0], p.near, euler[2]]]),
        ("near-quaternion-rate", "rate", ["near-quaternion", omega]),
        ("energy", "rotation-energy", [[1.0], [2 * np.pi * p.frequency]]),
        ("frequency-energy", "rotation-energy", [[1.0], [p.frequency]]),
        ("energy-ratio", "quotient", ["energy", "frequency-energy"]),
    ]


def sizes(p: Parameters) -> dict[str, float]:
    """Vectors, rates and energies have sizes of their own."""
    omega = float(np.linalg.norm(p.omega))
    v = float(np.linalg.norm(p.vector))
    steep = 1 / abs(np.sin(p.euler[1])), 1 / np.sin(p.near)
    energy = 2 * (np.pi * p.frequency) ** 2
    rates = {
        "euler-rates": omega * steep[0] ** 2,
        "near-rates": omega * steep[1] ** 2,
        "near-quaternion-rate": omega,
    }
    energies = {"energy": energy, "frequency-energy": energy, "energy-ratio": 40.0}
    return {
        "plane-turn": v,
        "complex-turn": v,
        "mirror": v,
        **rates,
        **energies,
        "euler-back": np.pi * steep[0],
    }
