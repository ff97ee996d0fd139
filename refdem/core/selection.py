"""A selection: cases times one check, under an id of its own in the catalogue."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from refdem.core.case import Canonical, Instance


def at_defaults(case: Canonical) -> Sequence[Mapping[str, str]]:
    """One instance, without any parameters given."""
    return ({},)


@dataclass(frozen=True, kw_only=True)
class Selection:
    """Every instance that `admits` returns None for, judged by one `check`; the campaign expands
    it.

    Adding one is one file in cases/ with an instance named CASE. `admits` returns the reason why an
    instance is left out;
    `parameters` gives those at which a case is looked at, each as text.
    """

    id: str
    title: str
    statement: str
    source: str
    check: str
    admits: Callable[[Instance], str | None]
    parameters: Callable[[Canonical], Sequence[Mapping[str, str]]] = at_defaults
    words: tuple[str, ...] = ()
