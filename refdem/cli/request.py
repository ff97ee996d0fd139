"""refdem request: the request that a program receives, with comments."""

from typing import Annotated

import typer

from refdem.cli import completion


def command(
    case: Annotated[
        str,
        typer.Argument(
            autocompletion=completion.cases,
            help="A case such as `pendulum` or `pendulum[theta0=2]`.",
        ),
    ],
    set: Annotated[
        list[str] | None, typer.Option(help="Parameter of the case, name=value.")
    ] = None,
    method: Annotated[
        str, typer.Option(help="Name of the method, as in refdem.toml.")
    ] = "leapfrog",
    stride: Annotated[
        int, typer.Option(help="Number of steps between samples.", min=1, max=1_000_000)
    ] = 8,
    json: Annotated[
        bool, typer.Option("--json", help="Print request.json as the program reads it.")
    ] = False,
    text: Annotated[
        bool, typer.Option("--text", help="Print request.txt as the program reads it.")
    ] = False,
) -> None:
    """Prints the request that a program receives.

    It is printed with comments, for one case.

    With --text or --json, prints the file without comments, for a first run by hand.

    Example: refdem request two-spheres --set friction=0 --stride 4
    """
    from refdem.core import discovery
    from refdem.core.parameters import labelled, settings
    from refdem.core.problem import Request
    from refdem.core.problem_kinds import Motion
    from refdem.core.request_comments import commented
    from refdem.core.request_text import request_text
    from refdem.core.selection import Selection
    from refdem.errors import UsageError

    if json and text:
        raise UsageError("--json and --text: got both; expected one of them, or none for comments")
    name, own = labelled(case)
    canonical = discovery.case(name)
    if isinstance(canonical, Selection):
        raise UsageError(
            f"{name} is a selection of other cases; expected one of them (`refdem list cases`)"
        )
    problem = canonical.at(**(own | settings(set or []))).problem
    step = None
    if isinstance(problem, Motion):
        step = abs(problem.interval) / stride
    request = Request(problem=problem, method=method, step=step)
    if json:
        print(request.to_json().decode())
    elif text:
        print(request_text(request), end="")
    else:
        print("\n".join(commented(request)))
