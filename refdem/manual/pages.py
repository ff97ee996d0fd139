"""The pages of the manual from cases, checks and the certified store."""

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

from refdem.certification.listing import certified_case
from refdem.core import discovery
from refdem.core.case import Canonical, Instance
from refdem.core.manual import CheckLine, ManualPage, ParameterLine, QuantityLine, TruthLine
from refdem.core.selection import Selection
from refdem.errors import NotCertifiedError
from refdem.manual.slips import slips_of
from refdem.planning import plan
from refdem.planning.moved import moved_at, moved_lines
from refdem.planning.specification import Specification
from refdem.truth.certified.reader import CertifiedSet, load
from refdem.truth.witnesses.cross_check import witnesses

DIGITS = 24
"""Decimal places of the scalars that are shown."""


def pages(folder: Path) -> Iterator[ManualPage]:
    """A page for every case with a truth of its own; `folder` is the store's."""
    sets: dict[str, list[CertifiedSet]] = {}
    for certified in load(folder=folder / "certified"):
        sets.setdefault(certified.case, []).append(certified)
    for name in discovery.names("cases"):
        case = discovery.case(name)
        if not isinstance(case, Selection):
            yield page(case, sets.get(name, []))


def page(case: Canonical, sets: list[CertifiedSet]) -> ManualPage:
    """The page of one case at its defaults."""
    instance = case.at()
    parameters = [
        ParameterLine(name=p.name, default=p.default, unit=p.unit, bounds=p.bounds(), doc=p.doc)
        for p in instance.p.declared.values()
    ]
    quantities = [
        QuantityLine(name=q.name, unit=q.unit, scale=q.scale) for q in instance.quantities.values()
    ]
    # The docstring of the case on one line.
    convention = " ".join((type(case).__doc__ or "").split())
    kind = instance.problem.words
    features = tuple(sorted(instance.problem.features))
    certified_scalars = scalars(instance)
    moved = moved_lines(instance)
    where_moved = moved_at(instance)
    truth = truth_line(case.id, instance, sets)
    lines_of_checks = tuple(checks(instance))
    slips = slips_of(case.id)
    commands = reproduce(case.id, instance)
    return ManualPage(
        case=case.id,
        title=case.title,
        words=case.words,
        statement=case.statement,
        latex=case.latex,
        source=case.source,
        convention=convention,
        kind=kind,
        features=features,
        parameters=tuple(parameters),
        quantities=tuple(quantities),
        scalars=certified_scalars,
        moved=moved,
        moved_at=where_moved,
        truth=truth,
        checks=lines_of_checks,
        slips=slips,
        reproduce=commands,
    )


def scalars(instance: Instance) -> tuple[QuantityLine, ...]:
    """The certified scalars at the defaults; none where the case has none at them."""
    try:
        values = instance.truth().refined(DIGITS).scalars()
    except NotCertifiedError:
        return ()
    lines = []
    for name, ball in values.items():
        if name not in instance.quantities:
            mid, radius = ball.decimals(DIGITS)
            lines.append(QuantityLine(name=name, mid=mid, radius=radius))
    return tuple(lines)


def truth_line(name: str, instance: Instance, sets: list[CertifiedSet]) -> TruthLine:
    """How the truth of a case is proved and witnessed: by its sets in the store, or as the case
    itself says where the store has none.
    """
    certified = certified_case(name, sets)
    truth = instance.truth()
    own_witness = certified.own_witness or truth.witness
    known_witness = witnesses().get(name)
    witness = "none"
    if known_witness is not None:
        witness = known_witness.method
    if certified.witnessed:
        witness = certified.witness
    has_no_witness = known_witness is None and own_witness in ("", "none")
    not_certified: list[tuple[str, str, str]] = []
    for each in sets:
        not_certified += [(each.label, t, reason) for t, reason in each.not_certified.items()]
    return TruthLine(
        method="; ".join(certified.methods) or truth.method,
        own_witness=own_witness,
        witness=witness,
        witnessed=certified.witnessed,
        agreed=certified.agreed,
        sets=certified.sets,
        values=certified.values,
        digits=certified.digits,
        has_no_witness=has_no_witness,
        labels=tuple(each.label for each in sets),
        not_certified=tuple(not_certified),
    )


def checks(instance: Instance) -> Iterator[CheckLine]:
    """The checks that apply in some method of the reference that can run the case, by name.

    Others are left out, so that a new check changes the pages of the cases that it judges alone.
    """
    specification = Specification(name="manual", case=[], engines=["reference"])
    reference = discovery.engine("reference")
    applied = {
        check.name: check
        for task in plan.tasks(specification, instance, (), reference, None)
        if task.unsupported is None
        for check in task.checks
    }
    for name, check in sorted(applied.items()):
        yield CheckLine(name=name, title=check.title, kills=check.kills)


def certified_time(instance: Instance) -> str:
    """A time [s] at which the case has certified values, as text; empty if there is none (a mean
    over many starts has no states).
    """
    if not instance.quantities or len(instance.times) < 2:
        return ""
    time = f"{float(instance.times[1]):g}"
    try:
        instance.truth().at(Fraction(time))
    except NotCertifiedError:
        return ""
    return time


def reproduce(name: str, instance: Instance) -> tuple[str, ...]:
    """Commands that show the same; every one of them ends well."""
    time = certified_time(instance)
    at = ""
    if time:
        at = f" --at {time}"
    return (
        f"refdem truth {name}{at}",
        f"refdem truth --list {name}",
        f"refdem run {name}",
        f"refdem explain {name}",
    )
