"""Resolution: which misreading of each number of a scene a verdict would have noticed."""

import msgspec


class Seen(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What is noticed of one number: the smallest relative misreading that some finding fails, and
    which does; None and the reason if nothing is noticed.

    `computed` is what certified derivatives foresee of it, by the finding `computed_by`, which has
    the reason where nothing is foreseen; both are empty where nothing was computed.
    """

    number: str
    smallest: float | None = None
    by: str = ""
    reason: str = ""
    computed: float | None = None
    computed_by: str = ""

    @property
    def size(self) -> str:
        """The smallest misreading that is noticed, rounded to two digits, or `nothing`."""
        return size_of(self.smallest)


def size_of(smallest: float | None) -> str:
    """A misreading rounded to two digits, or `nothing`."""
    if smallest is None:
        return "nothing"
    if smallest < 1e-4:
        return f"{smallest:.1e}"
    return f"{100 * smallest:.2g} %"


class Resolution(msgspec.Struct, frozen=True, kw_only=True, tag="resolution", tag_field="type"):
    """What one method on one case would notice of each number of the scene: a sheet of a report."""

    label: str
    engine: str
    method: str
    numbers: tuple[Seen, ...]

    @property
    def sentence(self) -> str:
        """What would have been noticed, the most finely seen first, and what would not, with its
        reason; empty for a scene without numbers.
        """
        noticed = [seen for seen in self.numbers if seen.smallest is not None]
        noticed.sort(key=lambda seen: seen.smallest or 0.0)
        parts = [f"{seen.number} {seen.size}" for seen in noticed]
        parts += [
            f"no misreading of {seen.number}, because {seen.reason}"
            for seen in self.numbers
            if seen.smallest is None
        ]
        if not parts:
            return ""
        return f"Would have noticed: {', '.join(parts)}."
