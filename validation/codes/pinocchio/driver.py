"""A scene in Pinocchio: free bodies, a top on a ball joint, rods in a plane, uniform gravity.

Pinocchio has accelerations (Featherstone's ABA, `aba`) and the exponential map of each joint
(`integrate`); the step is its user's. Derivatives are Pinocchio's own too, of both, chained through
the steps.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import served

# isort: split
from tangent import Tangent
from world import World

KNOWN = ("uniform_gravity", "rod", "ball_joint")


def solve(scene):
    """One run of the method that was asked for, and one with derivatives if they were."""
    world = World(scene)
    methods = {"semi-implicit-euler": world.euler, "midpoint": world.midpoint}
    scene.sampled(methods[scene.method], world.states)
    if scene.sensitivities:
        differentiate(scene)


def differentiate(scene):
    """Keeps the derivatives of the states, in a run that steps as the first."""
    beside = scene.with_numbers(lambda value, place: value)
    tangent = Tangent(beside)
    methods = {"semi-implicit-euler": tangent.euler, "midpoint": tangent.midpoint}
    beside.sampled(methods[scene.method], tangent.states)
    # Each component of a state is the array (K,) of its derivatives.
    scene.differentiated(beside, lambda derivatives: derivatives)


served.run(solve, *KNOWN)
