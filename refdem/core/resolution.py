"""Resolution: the smallest misreading of each number of a scene that a check would detect."""

import msgspec


class NumberResolution(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The resolution for one number: the `smallest` relative misreading with which some finding
    fails, and `by`, the check and quantity that does; None and the `reason` if none is detected.

    `computed` is the prediction of `smallest` from certified derivatives, and `computed_by` its
    check and quantity, or the reason why there is no prediction; both are empty if none was
    computed.
    """

    number: str
    smallest: float | None = None
    by: str = ""
    reason: str = ""
    computed: float | None = None
    computed_by: str = ""

    @property
    def size(self) -> str:
        """The smallest misreading that is detected, rounded to two digits, or `nothing`."""
        return size_of(self.smallest)


def size_of(smallest: float | None) -> str:
    """A misreading rounded to two digits, or `nothing`."""
    if smallest is None:
        return "nothing"
    if smallest < 1e-4:
        return f"{smallest:.1e}"
    return f"{100 * smallest:.2g} %"


class Resolution(msgspec.Struct, frozen=True, kw_only=True, tag="resolution", tag_field="type"):
    """The resolution of one method on one case for each number of the scene: a report sheet."""

    label: str
    engine: str
    method: str
    numbers: tuple[NumberResolution, ...]

    @property
    def sentence(self) -> str:
        """The misreadings that would be detected, smallest first, and the numbers of which none
        would be, each with the reason; empty for a scene without numbers.
        """
        detected = [entry for entry in self.numbers if entry.smallest is not None]
        detected.sort(key=lambda entry: entry.smallest or 0.0)
        parts = [f"{entry.number} {entry.size}" for entry in detected]
        parts += [
            f"no misreading of {entry.number}, because {entry.reason}"
            for entry in self.numbers
            if entry.smallest is None
        ]
        if not parts:
            return ""
        return f"Would have noticed: {', '.join(parts)}."
