"""An expected deviation: a value known to be out of bounds, with its range, the reason and a
link.
"""

from fnmatch import fnmatchcase
from math import isfinite

import msgspec

from refdem.core.finding import Finding, Record
from refdem.errors import OutOfRangeError


class Deviation(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A failing value that is accepted within [low, high] for these versions ("4.*").

    `parameters` is the part of the label in brackets, or a list of such parts. Names may be
    patterns with *, ? and [].
    """

    case: str
    parameters: str | tuple[str, ...] = "*"
    method: str
    check: str
    quantity: str
    versions: str
    low: float
    high: float
    reason: str
    link: str = ""

    def __post_init__(self) -> None:
        """Raises OutOfRangeError for an unbounded or empty range, or an empty name; msgspec turns
        it into an error with the place in the document.
        """
        if not (isfinite(self.low) and isfinite(self.high) and 0 <= self.low <= self.high):
            raise OutOfRangeError(
                f"low = {self.low:g} and high = {self.high:g}; expected finite numbers, 0 <= low <="
                " high"
            )
        for name in ("case", "method", "check", "quantity", "versions", "reason"):
            if not getattr(self, name).strip():
                raise OutOfRangeError(
                    f"{name} is empty; an expected deviation says where it holds, and why"
                )

    @property
    def _patterns(self) -> tuple[str, ...]:
        """The patterns of the parameters."""
        if isinstance(self.parameters, str):
            return (self.parameters,)
        return self.parameters

    def covers(self, record: Record, finding: Finding) -> bool:
        """True if the deviation is about this finding."""
        # The label is case[parameters].
        parameters = record.label.removeprefix(record.case).strip("[]")
        is_same_property = (self.case, self.check) == (record.case, finding.check)
        return (
            is_same_property
            and fnmatchcase(finding.quantity, self.quantity)
            and fnmatchcase(record.method, self.method)
            and fnmatchcase(record.version, self.versions)
            and any(fnmatchcase(parameters, pattern) for pattern in self._patterns)
        )
