"""What is certified, case by case: sets, values, digits, method, who witnesses it, and what is
stale or has no witness.
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
    """The whole catalogue, or these cases, also those without certified sets; raises UsageError for
    one that is not there.
    """
    sets: dict[str, list[CertifiedSet]] = {}
    for one in load(folder=folder / "certified"):
        sets.setdefault(one.case, []).append(one)
    asked = list(only) or discovery.names("cases")
    wanted = {name for name in asked if not isinstance(discovery.case(name), Selection)}
    return [certified_case(name, sets.get(name, [])) for name in sorted(wanted)]


def certified_case(name: str, sets: list[CertifiedSet]) -> CertifiedCase:
    """What the store has of one case, from its sets."""
    testimonies = [one.witnessed for one in sets if one.witnessed]
    radii: list[Fraction] = []
    for one in sets:
        radii += [Fraction(value.radius) for value in one.values]
    witnesses = sorted({testimony["by"] for testimony in testimonies})
    own_witnesses = sorted({one.witness for one in sets})
    if radii:
        digits = _digits(max(radii))
    else:
        digits = None
    source = digest_of(name)
    return CertifiedCase(
        case=name,
        sets=len(sets),
        values=len(radii),
        digits=digits,
        methods=sorted({one.method for one in sets}),
        witness="; ".join(witnesses) or NONE,
        witnessed=sum(testimony["values"] for testimony in testimonies),
        agreed=min((testimony["digits"] for testimony in testimonies), default=None),
        own_witness="; ".join(own_witnesses),
        stale=sum(one.source != source for one in sets),
    )


def _digits(radius: Fraction) -> int | None:
    """Decimal places before the radius begins; None if it is 0."""
    if radius:
        return math.floor(-math.log10(radius))
    return None


def in_all(found: list[CertifiedCase]) -> str:
    """The sentence below the table."""
    kept = [one for one in found if one.sets]
    sets = sum(one.sets for one in kept)
    proved = sum(one.values for one in kept)
    witnessed = sum(one.witnessed for one in kept)
    return (
        f"{sets} sets of {len(kept)} cases: {proved} values, {witnessed} of them confirmed by a"
        " witness when they were proved"
    )
