"""refdem diagnose: which known fault, or which integrator, a run behaves as."""

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from refdem.core.case import Instance
    from refdem.core.engine import Engine
    from refdem.core.problem import Request
    from refdem.core.trajectory import Trajectory
    from refdem.diagnosis.misreading import Misreading
    from refdem.diagnosis.twins import Diagnosis, Twin

SECOND_OPINION = 30.0
"""Limit on the run time [s] for trying known faults if misread numbers explain the run."""
MAX_TWINS = 5
"""Number of nearest twins that are printed; the others differ far more from the run."""


def command(
    record: Annotated[
        str,
        typer.Argument(
            help=(
                "Name of a finding: `case[name=value]/engine/method`, optionally followed by the"
                " check and the quantity."
            )
        ),
    ],
    engine: Annotated[
        str,
        typer.Option(
            help="Path to a refdem.toml, if the engine of the finding is an external program."
        ),
    ] = "",
    level: Annotated[
        int, typer.Option(help="Refinement level of the run to diagnose; 0 is the coarsest.")
    ] = 0,
    seconds: Annotated[
        float, typer.Option(help="Time limit [s]: no further fault is tried after it.", min=1)
    ] = 120.0,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Finds the fault or integrator that reproduces a run.

    Variants of the transparent engine, each with one known fault or another integrator, run the
    same case, and the one whose trajectory agrees with that of the run is reported. If none agrees,
    the numbers of the case that the run has misread are estimated, with the size of each error.

    Example: refdem diagnose free-rigid-body/mujoco/euler/error/omega_body.x
    """
    import msgspec

    from refdem.core import discovery
    from refdem.core.parameters import labelled
    from refdem.core.selection import Selection
    from refdem.errors import EngineMissingError, UsageError

    label, name, method = parts_of(record)
    case, given = labelled(label)
    chosen_engine = discovery.engine(engine or name)
    if (reason := chosen_engine.missing()) is not None:
        raise EngineMissingError(f"engine {name} is not installed here; {reason}")
    chosen_case = discovery.case(case)
    if isinstance(chosen_case, Selection):
        raise UsageError(f"{case} is a selection of cases; name one of them")
    result, misread, step = diagnosed(
        chosen_case.at(**given), chosen_engine, method, level, seconds
    )
    if result.explanation is None and misread is not None:
        sentence = misread.sentence()
    else:
        sentence = result.sentence()
    if json:
        document = _diagnosis_as_json(record, step, result)
        document |= {"sentence": sentence, "misread": _misread_as_json(misread)}
        print(msgspec.json.format(msgspec.json.encode(document)).decode())
        return
    if step:
        resolution = f"step {step:.6g} s"
    else:
        resolution = "exact"
    print(f"{record}, {resolution}: {sentence}")
    for twin in result.twins[:MAX_TWINS]:
        print(f"  {twin.digits:5.1f} digits  {twin.behaviour}, step {twin.step:.3g} s")


def parts_of(record: str) -> tuple[str, str, str]:
    """Label, engine and method of a record's or a finding's id; raises UsageError."""
    from refdem.errors import UsageError

    head, bracket, tail = record.partition("]")
    if bracket:
        label = head + bracket
        rest = tail.lstrip("/")
    else:
        label, _, rest = record.partition("/")
    names = rest.split("/")
    if not label or len(names) < 2 or not all(names[:2]):
        raise UsageError(
            f"record {record!r} is not the name of a finding; expected a name such as"
            " pendulum[theta0=2]/mujoco/euler"
        )
    return label, names[0], names[1]


def diagnosed(
    instance: "Instance", engine: "Engine", method: str, level: int, seconds: float
) -> "tuple[Diagnosis, Misreading | None, float | None]":
    """The diagnosis of one run, which is repeated for it, the numbers that it has misread (None if
    none explain it), and its step.

    A run at half the step is also made: a fault of the code has the same amplitude there, and a
    discretisation error has not. A twin has the steps of the code, so that it can agree with a run
    to round-off. Misread numbers agree with it up to the discretisation error, for any method.
    Raises EngineError if the engine has no run to diagnose.
    """
    from dataclasses import replace

    from refdem.core.problem import Request
    from refdem.core.refinement import levels
    from refdem.diagnosis.twins import diagnosis, first_part
    from refdem.errors import UnsupportedError

    claims = engine.method(method)
    if (reason := engine.unsupported(instance.problem, claims)) is not None:
        raise UnsupportedError(
            f"{engine.name}/{method} does not support {instance.label}: {reason}"
        )
    # Steps or tolerances, coarse to fine; a level beyond the last one is the last one.
    all_levels = levels(instance, claims, 10, 1e6)
    chosen_level = all_levels[min(level, len(all_levels) - 1)]
    step = None
    tolerance = None
    if claims.control == "step":
        step = chosen_level
    elif claims.control == "tolerance":
        tolerance = chosen_level
    request = Request(problem=instance.problem, method=method, step=step, tolerance=tolerance)
    request = first_part(request)
    run = _trajectory(engine, request)
    other = None
    finer_run = run
    if request.step is not None:
        finer = replace(request, step=request.step / 2)
        finer_run = _trajectory(engine, finer)
        other = (finer, finer_run)
    misread = _misreading(instance, run, finer_run, seconds)
    if misread is not None:
        seconds = min(seconds, SECOND_OPINION)
    return diagnosis(instance, request, run, other, seconds), misread, request.step


def _misreading(
    instance: "Instance", run: "Trajectory", finer: "Trajectory", seconds: float
) -> "Misreading | None":
    """The numbers that a run has misread; None where none explain it, or derivatives are not
    certified.
    """
    from refdem.diagnosis.misreading import misreading
    from refdem.errors import NotCertifiedError

    try:
        found = misreading(instance, run, finer, seconds)
    except NotCertifiedError:
        return None
    if found.fits:
        return found
    return None


def _trajectory(engine: "Engine", request: "Request") -> "Trajectory":
    """The trajectory of the engine's run; raises EngineError if the run fails."""
    from refdem.errors import EngineError
    from refdem.planning.in_process import run_of

    run = run_of(engine, request)
    if run.failure is not None:
        raise EngineError(f"{engine.name}/{request.method}: {run.failure.sentence}")
    if run.trajectory is None:
        raise EngineError(f"{engine.name}/{request.method}: no trajectory")
    return run.trajectory


def _amplitude(twin: "Twin") -> float | None:
    """The amplitude of the twin's fault; None for a fault that has no amplitude."""
    if twin.scaled is None:
        return None
    return twin.amplitude


def _misread_as_json(found: "Misreading | None") -> list[dict[str, object]]:
    """Misread numbers as JSON has them."""
    fits: list[dict[str, object]] = []
    if found is None:
        return fits
    for fit in found.fits:
        names = [number.name for number in fit.numbers]
        fits.append(
            {
                "numbers": dict(zip(names, fit.amounts, strict=True)),
                "explains": fit.explains,
                "left": fit.left,
            }
        )
    return fits


def _diagnosis_as_json(record: str, step: float | None, result: "Diagnosis") -> dict[str, object]:
    """The diagnosis as JSON has it."""
    twin_that_explains = result.explanation
    twins = [
        {
            "fault": twin.name or None,
            "amplitude": _amplitude(twin),
            "method": twin.method,
            "step": twin.step,
            "distance": twin.distance,
        }
        for twin in result.twins
    ]
    explained = None
    if twin_that_explains is not None:
        explained = {
            "fault": twin_that_explains.name or None,
            "amplitude": _amplitude(twin_that_explains),
            "alike": list(result.alike),
            "method": twin_that_explains.method,
            "digits": twin_that_explains.digits,
        }
    return {
        "record": record,
        "step": step,
        "defect": result.defect,
        "explained_by": explained,
        "sentence": result.sentence(),
        "ended_after": result.seconds or None,
        "twins": twins,
    }
