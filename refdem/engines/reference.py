"""The reference implementation as an engine: it selects a method by the contents of the scene and
passes the request on to it.
"""

import hashlib
import inspect
from dataclasses import replace
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

import refdem
from refdem import kernels
from refdem.core import fingerprint
from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Problem, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.errors import UnsupportedError
from refdem.solvers.solver import Solver

FOLDER = Path(refdem.__file__).parent / "solvers"


class Reference(Engine):
    """Every METHOD found in refdem/solvers, one a file."""

    name = "reference"
    title = "Reference"
    licence = "BSD-3-Clause"
    is_reference = True

    @cached_property
    def solvers(self) -> dict[str, Solver]:
        """The solvers by the name of their method, cheapest first."""
        names = sorted(
            path.stem
            for path in FOLDER.glob("*.py")
            if not path.stem.startswith("_") and path.stem != "solver"
        )
        solvers: list[Solver] = [import_module(f"refdem.solvers.{name}").METHOD for name in names]
        return {
            s.claims.name: s
            for s in sorted(solvers, key=lambda s: (s.claims.cost_rank, s.claims.name))
        }

    @cached_property
    def methods(self) -> tuple[Method, ...]:  # type: ignore[override]
        """The methods of the solvers with their claims, cheapest first."""
        return tuple(
            replace(solver.claims, answers=solver.answers.kind) for solver in self.solvers.values()
        )

    def missing(self) -> str | None:
        """None: it comes with refdem."""
        return None

    def version(self) -> str:
        """The version of refdem, which the reference shares."""
        return refdem.__version__

    def fingerprint(self, method: Method) -> str:
        """Digest of the method's kernels and source, the scene's and mechanics' code, numpy and the
        machine.
        """
        solver = self.solvers[method.name]
        own = Path(inspect.getfile(type(solver)))
        parts = (
            kernels.fingerprint(*solver.kernels),
            fingerprint.of_files([own]),
            fingerprint.of_source(
                "engines/reference.py", "solvers/solver.py", *_shared(), "scene", "mechanics"
            ),
            fingerprint.version_of("numpy"),
            fingerprint.of_machine(),
        )
        return hashlib.sha256("\0".join(parts).encode()).hexdigest()

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None if the method can run the problem, else why not."""
        return self.unsupported(problem, method)

    def unsupported(self, problem: Problem, method: Method) -> str | None:
        """None if the method answers such questions and can run this one, else why not."""
        solver = self.solvers[method.name]
        if isinstance(problem, solver.answers):
            return solver.unsupported(problem)
        return f"cannot run {problem.words}"

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Runs the request with the method that it names; raises UnsupportedError if that method
        refuses the scene.
        """
        solver = self.solvers[self.method(request.method).name]
        reason = self.unsupported(request.problem, solver.claims)
        if reason:
            raise UnsupportedError(
                f"the reference's {request.method} cannot run this scene: {reason}"
            )
        return solver.run(request)

    def section(self, problem: Motion, frequency: Any, *, skip: int, keep: int) -> Any:
        """The Poincare section of a point on a driven belt over frequencies (M,) [rad/s]
        (solvers/_belt_section.py).

        Raises UnsupportedError for other scenes.
        """
        from refdem.solvers._belt_section import section

        reason = self.solvers["stick-slip"].unsupported(problem)
        if reason:
            raise UnsupportedError(f"the reference has no section of this scene: {reason}")
        return section(problem.scene, frequency, skip=skip, keep=keep)

    def best(self, problem: Problem) -> Method:
        """The cheapest method that does not refuse and needs no name; raises UnsupportedError with
        every method's reason if all do.
        """
        reasons = []
        for method in self.chosen_methods():
            reason = self.unsupported(problem, method)
            if reason is None:
                return method
            reasons.append(f"{method.name}: {reason}")
        raise UnsupportedError(
            "no method of the reference can run this scene; " + "; ".join(reasons)
        )


@cache
def _shared() -> tuple[str, ...]:
    """Private modules beside the solvers, which any of them may use."""
    return tuple(sorted(f"solvers/{path.name}" for path in FOLDER.glob("_*.py")))


ENGINE = Reference()
