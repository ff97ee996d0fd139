"""Ten million impacts of rigid spheres: errors of sums grow as a random walk of roundings."""

import numpy as np

from refdem.bench.hard_spheres import box_of_spheres, caged_spheres
from refdem.core.balance import angular, kinetic, linear
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


def test_ten_million_rough_impacts_change_angular_momentum_by_a_walk_of_roundings() -> None:
    """Spins take part in every impact: what they gain bodies lose on their ways, to round-off.

    The spheres are alone in space, in a cage of heavy ones that are free too: nothing acts from
    outside. Terms m |r| |v| of the cage grow with what it is hit by, and so do their roundings.
    """
    scene = caged_spheres(12, friction=100.0)
    request = Request(problem=Motion(scene, np.array([0.0, 1340.0])), method="impacts", step=None)
    call = METHOD.prepare(request)
    impacts = call.made("impacts")
    assert impacts > 10_000_000
    trajectory = METHOD.finish(request, call, impacts)
    momenta = scene.bodies.mass * np.linalg.norm(trajectory.velocity, axis=-1)
    moments = momenta * np.linalg.norm(trajectory.position, axis=-1)
    walk = 10 * U * np.sqrt(impacts)
    parts = angular(scene, trajectory)
    total = parts["total"]
    assert np.abs(total[-1] - total[0]).max() < walk * moments.max()
    assert np.abs(parts["spin"][-1] - parts["spin"][0]).max() > 1.0
    momentum = linear(scene, trajectory)
    assert np.abs(momentum[-1] - momentum[0]).max() < walk * 2 * momenta.max()


def test_impacts_whose_friction_is_cut_keep_angular_momentum() -> None:
    scene = caged_spheres(8, friction=0.5)
    request = Request(problem=Motion(scene, np.array([0.0, 20.0])), method="impacts", step=None)
    call = METHOD.prepare(request)
    impacts = call.made("impacts")
    assert impacts > 5_000
    trajectory = METHOD.finish(request, call, impacts)
    assert trajectory.channels["dissipated_work"][-1] > 0.1
    total = angular(scene, trajectory)["total"]
    speeds = np.linalg.norm(trajectory.velocity, axis=-1)
    moments = scene.bodies.mass * speeds * np.linalg.norm(trajectory.position, axis=-1)
    assert np.abs(total[-1] - total[0]).max() < 10 * U * np.sqrt(impacts) * moments.max()
