"""What the tests of batteries share: one sweep, shortened, run in this process by the
reference or by one that carries a fault.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.core.problem import Motion, Request
from refdem.core.store import Store
from refdem.core.trajectory import Trajectory
from refdem.faults.fault import Carrier, Fault
from refdem.stress.record import StressRecord
from refdem.stress.selection import battery
from refdem.stress.session import Stress

REFERENCE = discovery.engine("reference")


def results(
    folder: Path,
    name: str,
    sweep: str,
    points: Sequence[str],
    engine: Engine = REFERENCE,
    method: str = "",
    **options: Any,
) -> StressRecord:
    """The record of one sweep with these points alone; the last of them that is promised stays
    promised.
    """
    whole = battery(name)
    (found,) = (one for one in whole.sweeps if one.name == sweep)
    if found.promised in points:
        promised = found.promised
    else:
        promised = ""
    exempt = {who: due if due[0] in points else ("", "") for who, due in found.exempt.items()}
    short = replace(
        found,
        points=tuple(points),
        promised=promised,
        basis=found.basis if promised else "",
        exempt=exempt,
    )
    with discovery.engine_here(engine):
        asked = replace(whole, sweeps=(short,))
        return Stress(
            [asked],
            Store(folder / "store.sqlite"),
            engines=[engine.name],
            method=method,
            jobs=0,
            **options,
        ).record()


def verdicts(record: StressRecord) -> dict[str, list[str]]:
    """Verdicts point by point, by method."""
    return {result.method: [point.verdict for point in result.points] for result in record.results}


def carrier(name: str, *, before: Any = None, after: Any = None) -> Engine:
    """The reference with a fault."""
    fault = Fault(
        name=name,
        kind="stress",
        sentence=f"{name}.",
        on=(),
        sees=("", ""),
        before=before,
        after=after,
    )
    return Carrier(REFERENCE, fault)


def changed_bodies(
    change: Callable[[dict[str, Any]], dict[str, Any]],
) -> Callable[[Request], Request]:
    """A fault before the run: columns of bodies that are changed."""

    def before(request: Request) -> Request:
        problem = request.problem
        assert isinstance(problem, Motion)
        bodies = problem.scene.bodies
        columns = {
            name: getattr(bodies, name).copy()
            for name in ("mass", "inertia", "position", "velocity", "omega")
        }
        scene = replace(problem.scene, bodies=replace(bodies, **change(columns)))
        return replace(request, problem=replace(problem, scene=scene))

    return before


def changed_elements(**changes: Callable[[float], float]) -> Callable[[Request], Request]:
    """A fault before the run: numbers of elements that are changed, where an element has them."""
    import msgspec

    def before(request: Request) -> Request:
        problem = request.problem
        assert isinstance(problem, Motion)
        elements = [
            msgspec.structs.replace(
                element,
                **{
                    name: change(getattr(element, name))
                    for name, change in changes.items()
                    if hasattr(element, name)
                },
            )
            for element in problem.scene.elements
        ]
        return replace(
            request,
            problem=replace(problem, scene=replace(problem.scene, elements=tuple(elements))),
        )

    return before


def changed_run(**changes: Callable[[Any], Any]) -> Callable[[Request, Trajectory], Trajectory]:
    """A fault after the run: columns of the trajectory that are changed."""
    return lambda request, run: replace(
        run, **{name: change(getattr(run, name)) for name, change in changes.items()}
    )
