"""refdem certify: rebuilds the certified store, or verifies it."""

import shlex
from pathlib import Path
from typing import Annotated

import typer


def command(
    cases: Annotated[list[str] | None, typer.Argument(help="Cases; default: all.")] = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            help=(
                "Folder of the store, with sets.toml, certified/ and samples/; default: that of"
                " refdem."
            )
        ),
    ] = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help=(
                "Only check the store: verify all hashes, then prove and cross-check a sample of"
                " sets again."
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
    """Proves certified sets again after changes.

    Every set of sets.toml whose code or parameters have changed is proved, cross-checked with an
    independent method, and written to the store.

    An interrupted run resumes where it ended.

    Example: refdem certify --check
    """
    from refdem.certification.proofs import Certification
    from refdem.cli.progress import Progress
    from refdem.core.store import Store, default_path
    from refdem.planning.kept_truth import truth_folder

    home = folder or truth_folder()
    if check:
        raise typer.Exit(checked(home, cases or [], each=each, seed=seed, jobs=jobs))
    certified = Certification(home, Store(default_path()), jobs, anew, Progress()).run(cases or [])
    for problem in certified.problems:
        print(f"PROBLEM: {problem}")
    print(f"{certified.made} sets proved. {summary(home)}")
    raise typer.Exit(int(bool(certified.problems)))


def checked(folder: Path, cases: list[str], *, each: int, seed: str, jobs: int) -> int:
    """Checks the store and prints its problems; exit status 1 if there are any, else 0.

    The hashes of all sets are checked. If they hold, sets of the cases (all, if none is named) are
    drawn by the seed, `each` of them for every case and method, and proved again.
    """
    from refdem.certification.reproof import contradictions, damaged, sample
    from refdem.cli.progress import Progress
    from refdem.truth.certified.reader import load

    problems = damaged(folder)
    if not problems:
        certified_sets = load(folder=folder / "certified")
        known_cases = {certified.case for certified in certified_sets}
        _refuse_unknown(cases, known_cases, folder)
        candidates = [
            certified for certified in certified_sets if not cases or certified.case in cases
        ]
        drawn = sample(candidates, each=each, seed=seed)
        problems += contradictions(drawn, jobs=jobs, progress=Progress())
        print(f"{len(drawn)} sets proved again. {summary(folder)}")
    for problem in problems:
        print(f"PROBLEM: {problem}")
    return int(bool(problems))


def _refuse_unknown(cases: list[str], known: set[str], folder: Path) -> None:
    """Raises UsageError for a case without a set in the store, and for an empty store, since
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


def summary(folder: Path) -> str:
    """A sentence: how much the store holds, and which of its sets are stale."""
    from refdem.certification.proofs import stale
    from refdem.truth.certified.reader import load

    sets = load(folder=folder / "certified")
    stale_sets = stale(folder)
    listed = ", ".join(stale_sets[:5])
    if len(stale_sets) > 5:
        listed += " ..."
    staleness = "none stale"
    if stale_sets:
        remedy = f"run `refdem certify --folder {shlex.quote(str(folder))}`"
        staleness = f"{len(stale_sets)} stale or missing: {listed}; {remedy}"
    cases = len({certified.case for certified in sets})
    values = sum(len(certified.values) for certified in sets)
    return f"The store has {len(sets)} sets of {cases} cases, {values} values, {staleness}."
