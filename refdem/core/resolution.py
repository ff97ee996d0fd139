"""Resolution: which misreading of each number of a scene a verdict would have noticed."""

from collections.abc import Iterable

import msgspec


class Seen(msgspec.Struct, frozen=True, kw_only=True):
    """What a method would notice of one number: the smallest relative misreading that some finding
    fails, and which does; None and the reason if it would notice nothing.
    """

    label: str
    engine: str
    method: str
    number: str
    smallest: float | None = None
    by: str = ""
    reason: str = ""

    @property
    def size(self) -> str:
        """The smallest misreading that is noticed, rounded to two digits, or `nothing`."""
        if self.smallest is None:
            return "nothing"
        if self.smallest < 1e-4:
            return f"{self.smallest:.1e}"
        return f"{100 * self.smallest:.2g} %"


def sentence(seen: Iterable[Seen]) -> str:
    """What one method on one case would have noticed, as a sentence: the most finely seen first,
    and what is not seen with its reason.
    """
    noticed = []
    blind = []
    for one in seen:
        if one.smallest is None:
            blind.append(one)
        else:
            noticed.append(one)
    noticed.sort(key=lambda one: one.smallest or 0.0)
    parts = [f"{one.number} {one.size}" for one in noticed]
    parts += [f"{one.number}: nothing, since {one.reason}" for one in blind]
    if not parts:
        return ""
    return f"Would have noticed: {', '.join(parts)}."
