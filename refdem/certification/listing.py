"""The table of what is certified, case by case: sets, values, digits, method, witness, and how many
sets are stale.
"""

import math
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import msgspec

from refdem.core import discovery
from refdem.core.selection import Selection
from refdem.truth.certified.reader import CertifiedSet, load
from refdem.truth.certified.sources import digest_of

NONE = "none"


class CertifiedCase(msgspec.Struct, frozen=True, kw_only=True):
    """One line of the table. `digits`: decimals that the worst radius leaves; `witnessed` values
    that `witness` confirmed when they were proved, to `agreed` digits; `own_witness` is what the
    truth itself names, checked by the tests; `stale` sets.
    """

    case: str
    sets: int
    values: int
    digits: int | None
    methods: list[str]
    witness: str
    witnessed: int
    agreed: int | None
    own_witness: str
    stale: int

    @property
    def has_no_witness(self) -> bool:
        """Neither when it was proved nor in the tests."""
        return self.witness == NONE and self.own_witness in ("", NONE)


def certified_cases(folder: Path, only: Iterable[str] = ()) -> list[CertifiedCase]:
    """The lines of all cases, or of these, also of those without certified sets.

    Raises UsageError for a case that does not exist.
    """
    sets: dict[str, list[CertifiedSet]] = {}
    for certified_set in load(folder=folder / "certified"):
        sets.setdefault(certified_set.case, []).append(certified_set)
    names = list(only) or discovery.names("cases")
    cases = {name for name in names if not isinstance(discovery.case(name), Selection)}
    return [certified_case(name, sets.get(name, [])) for name in sorted(cases)]


def certified_case(name: str, sets: list[CertifiedSet]) -> CertifiedCase:
    """The line of one case, from its sets in the store."""
    cross_checks = [entry.witnessed for entry in sets if entry.witnessed]
    radii: list[Fraction] = []
    for entry in sets:
        radii += [Fraction(value.radius) for value in entry.values]
    witnesses = sorted({cross_check["by"] for cross_check in cross_checks})
    own_witnesses = sorted({entry.witness for entry in sets})
    if radii:
        digits = _digits(max(radii))
    else:
        digits = None
    methods = sorted({entry.method for entry in sets})
    witnessed = sum(cross_check["values"] for cross_check in cross_checks)
    agreed = min((cross_check["digits"] for cross_check in cross_checks), default=None)
    # A set is stale if it was proved with another state of the case's code.
    source = digest_of(name)
    stale = sum(entry.source != source for entry in sets)
    return CertifiedCase(
        case=name,
        sets=len(sets),
        values=len(radii),
        digits=digits,
        methods=methods,
        witness="; ".join(witnesses) or NONE,
        witnessed=witnessed,
        agreed=agreed,
        own_witness="; ".join(own_witnesses),
        stale=stale,
    )


def _digits(radius: Fraction) -> int | None:
    """Decimal places that a radius leaves certain, floor(-log10(radius)); None if it is 0."""
    if radius:
        return math.floor(-math.log10(radius))
    return None


def in_all(cases: list[CertifiedCase]) -> str:
    """The sentence below the table: the sums of its columns."""
    certified = [case for case in cases if case.sets]
    sets = sum(case.sets for case in certified)
    proved = sum(case.values for case in certified)
    witnessed = sum(case.witnessed for case in certified)
    return (
        f"{sets} sets of {len(certified)} cases: {proved} values, {witnessed} of them confirmed by"
        " a witness when they were proved"
    )
