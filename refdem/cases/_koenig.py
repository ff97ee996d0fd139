"""The operations of the case rotations about points that move: Koenig's theorem for energy and for
angular momentum, and the energy of a turn by the tensor of inertia.
"""

import numpy as np

from refdem.cases._algebra import Row
from refdem.core.parameters import Parameters


def rows(p: Parameters) -> list[Row]:
    """Energy and angular momentum of the points as sums over them, as the part of the centre of
    mass and the part about it; and the energy of the same points that turn with omega.
    """
    masses = p.masses.tolist()
    places = p.places.ravel().tolist()
    velocities = p.velocities.ravel().tolist()
    moving = [masses, velocities]
    placed = [masses, places, velocities]
    turning = [masses, places, p.omega.tolist()]
    energies: list[Row] = [
        ("points-energy", "points-energy", moving),
        ("centre-energy", "centre-energy", moving),
        ("energy-about-centre", "energy-about-centre", moving),
        ("koenig-energy", "scalar-sum", ["centre-energy", "energy-about-centre"]),
    ]
    momenta: list[Row] = [
        ("points-momentum", "points-angular-momentum", placed),
        ("centre-momentum", "centre-angular-momentum", placed),
        ("momentum-about-centre", "angular-momentum-about-centre", placed),
        ("koenig-momentum", "vector-sum", ["centre-momentum", "momentum-about-centre"]),
    ]
    turns: list[Row] = [
        ("swept-energy", "swept-energy", turning),
        ("tensor-energy", "tensor-energy", turning),
    ]
    return energies + momenta + turns


def sizes(p: Parameters) -> dict[str, float]:
    """The magnitudes of the results by name: those of all mass at the farthest point and at the
    largest speed.
    """
    mass = float(p.masses.sum())
    distance = float(np.linalg.norm(p.places, axis=1).max())
    speed = float(np.linalg.norm(p.velocities, axis=1).max())
    turning_speed = float(np.linalg.norm(p.omega)) * distance
    energies = ("points-energy", "centre-energy", "energy-about-centre", "koenig-energy")
    momenta = ("points-momentum", "centre-momentum", "momentum-about-centre", "koenig-momentum")
    return {
        **dict.fromkeys(energies, mass * speed**2),
        **dict.fromkeys(momenta, mass * distance * speed),
        **dict.fromkeys(("swept-energy", "tensor-energy"), mass * turning_speed**2),
    }
