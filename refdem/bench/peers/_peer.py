"""The base class of peers: they integrate the systems of `equations`, forward, at a tolerance."""

from importlib.metadata import version
from importlib.util import find_spec

from refdem.bench.peers._equations import Equations, equations
from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Problem
from refdem.errors import UnsupportedError

CARTESIAN = "-cartesian"
"""Suffix of the name of a method that integrates a rod's end in Cartesian coordinates, with its
constraint force.
"""


class Peer(Engine):
    """An integrator of first-order systems; `name` is also that of its package."""

    def missing(self) -> str | None:
        """None if the package is installed, else what to install."""
        if find_spec(self.name):
            return None
        return f"install refdem[bench], or {self.name}"

    def version(self) -> str:
        """The version of the package that is installed."""
        return version(self.name)

    def fingerprint(self, method: Method) -> str:
        """The version: runs of a bench are never stored."""
        return self.version()

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None for the scenes whose equations are written down."""
        if problem.interval < 0:
            return "only forward in time"
        if equations(problem, cartesian=method.name.endswith(CARTESIAN)):
            return None
        return "its equations are not written for peers"

    def supported_equations(self, problem: Problem, name: str) -> Equations:
        """The equations; raises UnsupportedError if there are none."""
        if isinstance(problem, Motion):
            system = equations(problem, cartesian=name.endswith(CARTESIAN))
        else:
            system = None
        if system is None:
            raise UnsupportedError(f"{self.name} has no equations for this scene")
        return system
