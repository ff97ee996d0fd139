"""pymunk (Chipmunk): as many discs in a square, with the same filled fraction as that of the
spheres in the cube.
"""

from importlib.util import find_spec
from time import perf_counter

import numpy as np

from refdem.bench.crowds._crowd import Crowd, Gas


class Pymunk(Crowd):
    """A gas in pymunk, with its tree of bounding boxes, which is 3 to 6 times as fast here as its
    spatial hash, and a single pass of the solver.
    """

    name = "pymunk"
    note = "discs in a plane, elastic impacts"

    def missing(self) -> str | None:
        """None if the package is installed, else what to install."""
        if find_spec("pymunk"):
            return None
        return "install refdem[pymunk]"

    def unsupported(self, gas: Gas) -> str | None:
        """None for a gas between walls, else why it cannot be moved."""
        if gas.periodic:
            return "no periodic box"
        return None

    def seconds(self, gas: Gas, steps: int) -> float:
        """The time of the space's own steps, after one that is not counted."""
        import pymunk

        n = len(gas.position)
        radius = gas.diameter / 2
        # The filled fraction n (pi/6) (d/L)^3 of the cube, and the edge of a square in which discs
        # fill the same fraction.
        filled = n * np.pi / 6 * (gas.diameter / gas.size) ** 3
        side = int(np.ceil(np.sqrt(n)))
        edge = float(np.sqrt(n * np.pi * radius**2 / filled))
        space = pymunk.Space()
        space.iterations = 1
        for k, velocity in enumerate(gas.velocity.tolist()):
            body = pymunk.Body(gas.mass, gas.mass * radius**2 / 2)
            # At the centre of a cell of a square grid, row by row.
            x = (k % side + 0.5) * edge / side
            y = (k // side + 0.5) * edge / side
            body.position = (x, y)
            body.velocity = tuple(velocity[:2])
            disc = pymunk.Circle(body, radius)
            disc.elasticity = 1.0
            disc.friction = gas.law.friction
            space.add(body, disc)
        corners = [(0.0, 0.0), (edge, 0.0), (edge, edge), (0.0, edge)]
        walls = [
            pymunk.Segment(space.static_body, corners[k - 1], corners[k], radius) for k in range(4)
        ]
        for wall in walls:
            wall.elasticity = 1.0
        space.add(*walls)
        space.step(gas.step)
        began = perf_counter()
        for _ in range(steps):
            space.step(gas.step)
        return perf_counter() - began


CROWD = Pymunk()
