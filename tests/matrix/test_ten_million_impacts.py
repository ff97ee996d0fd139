"""Ten million impacts of rigid spheres: errors of sums grow as a random walk of roundings."""

import numpy as np

from refdem.bench.hard_spheres import box_of_spheres
from refdem.core.balance import kinetic, linear
from refdem.core.problem import Motion, Request
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.solvers.impacts import METHOD

U = 2.0**-53


def test_ten_million_impacts_change_energy_and_momentum_by_a_walk_of_roundings() -> None:
    """Each impact rounds the momenta of two, independently: ten times the width of such a walk."""
    walled = box_of_spheres(1000, 0.4)
    size = max(max(plane.point) for plane in walled.all(Plane))
    law = walled.all(Contact)[0]
    scene = Scene(bodies=walled.bodies, elements=(law, PeriodicBox(size=size)))
    problem = Motion(scene, np.array([0.0, 1010.0]))
    request = Request(problem=problem, method="impacts", step=None)
    call = METHOD.prepare(request)
    impacts = call.made("impacts")
    assert impacts > 10_000_000
    trajectory = METHOD.finish(request, call, impacts)
    energy = kinetic(scene, trajectory)
    momentum = linear(scene, trajectory)
    walk = 10 * U * np.sqrt(impacts)
    assert abs(energy[-1] / energy[0] - 1) < walk
    assert np.abs(momentum[-1] - momentum[0]).max() < walk * 2 * np.abs(trajectory.velocity).max()
