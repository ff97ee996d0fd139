"""An expected deviation: a value known to be out of bounds, with its range, the reason and a link."""

from fnmatch import fnmatchcase

import msgspec

from refdem.core.finding import Finding, Record


class Deviation(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Excuses a failing value in [low, high] for these versions ("4.*"); `parameters` is the label's part in brackets.

    Names may be patterns with * and ?.
    """

    case: str
    parameters: str = "*"
    method: str
    check: str
    quantity: str
    versions: str
    low: float
    high: float
    reason: str
    link: str = ""

    def covers(self, record: Record, finding: Finding) -> bool:
        """The deviation speaks of this finding."""
        inside = record.label.removeprefix(record.case).strip("[]")
        return (
            (self.case, self.check) == (record.case, finding.check)
            and fnmatchcase(finding.quantity, self.quantity)
            and fnmatchcase(record.method, self.method)
            and fnmatchcase(record.version, self.versions)
            and fnmatchcase(inside, self.parameters)
        )
