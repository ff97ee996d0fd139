"""refdem certify: proves the certified store again, or checks that it holds."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    cases: Annotated[list[str] | None, typer.Argument(help="Cases; default: all.")] = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            help=(
                "Folder of the store: sets.toml, certified/, samples/; default: the one of refdem."
            )
        ),
    ] = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help=(
                "Only check the store: every hash, and a sample of sets proved and witnessed again."
            ),
        ),
    ] = False,
    each: Annotated[
        int,
        typer.Option(
            help="With --check: number of sets per case and method that are proved again.", min=0
        ),
    ] = 1,
    seed: Annotated[str, typer.Option(help="With --check: seed that selects these sets.")] = "1",
    anew: Annotated[
        bool, typer.Option("--anew", help="Prove all sets, including those that are up to date.")
    ] = False,
    jobs: Annotated[int, typer.Option(help="Number of worker processes.", min=1)] = 2,
) -> None:
    """Proves every set of sets.toml whose code or parameters changed, has it witnessed, and writes
    the store; killed, it resumes.

    Example: refdem certify --check
    """
    from refdem.campaign.certification import Certification
    from refdem.campaign.kept_truth import truth_folder
    from refdem.cli.progress import Progress
    from refdem.core.store import Store, default_path

    home = folder or truth_folder()
    if check:
        raise typer.Exit(checked(home, cases or [], each=each, seed=seed, jobs=jobs))
    certified = Certification(home, Store(default_path()), jobs, anew, Progress()).run(cases or [])
    for problem in certified.problems:
        print(f"PROBLEM: {problem}")
    print(f"{certified.made} sets proved. {told(home)}")
    if certified.problems:
        status = 1
    else:
        status = 0
    raise typer.Exit(status)


def checked(folder: Path, cases: list[str], *, each: int, seed: str, jobs: int) -> int:
    """Exit status of a check; what is wrong is printed."""
    from refdem.campaign.reproof import contradictions, damaged, sample
    from refdem.cli.progress import Progress
    from refdem.truth.certified.reader import load

    problems = damaged(folder)
    if not problems:
        every = load(folder=folder / "certified")
        _refuse_unknown(cases, {one.case for one in every}, folder)
        chosen = sample(
            [one for one in every if not cases or one.case in cases], each=each, seed=seed
        )
        problems += contradictions(chosen, jobs=jobs, progress=Progress())
        print(f"{len(chosen)} sets proved again. {told(folder)}")
    for problem in problems:
        print(f"PROBLEM: {problem}")
    if problems:
        return 1
    return 0


def _refuse_unknown(cases: list[str], known: set[str], folder: Path) -> None:
    """Raises UsageError for a case that the store has no set of, and for a store without any:
    nothing would be checked.
    """
    from refdem.core.parameters import nearest
    from refdem.errors import UsageError

    if not known:
        raise UsageError(
            f"{folder} holds no certified set to check; expected a store that `refdem certify`"
            " wrote"
        )
    for name in cases:
        if name not in known:
            raise UsageError(f"{folder} has no set of case {name!r}; {nearest(name, known)}")


def told(folder: Path) -> str:
    """How much the store holds, and what of it is stale."""
    from refdem.campaign.certification import stale
    from refdem.truth.certified.reader import load

    sets = load(folder=folder / "certified")
    old = stale(folder)
    named = ", ".join(old[:5])
    if len(old) > 5:
        named += " ..."
    if old:
        more = f", {len(old)} stale or missing: {named}; run `make certify`"
    else:
        more = ", none stale"
    cases = len({one.case for one in sets})
    values = sum(len(one.values) for one in sets)
    return f"The store has {len(sets)} sets of {cases} cases, {values} values{more}."
