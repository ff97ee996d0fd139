"""The content of a page of the verification manual about a case; the page is a function of it."""

import msgspec

from refdem.core.moved import MovedLine


class ParameterLine(msgspec.Struct, frozen=True, kw_only=True):
    """One parameter: exact in truth, with unit and bounds."""

    name: str
    default: str
    unit: str
    bounds: str
    doc: str


class QuantityLine(msgspec.Struct, frozen=True, kw_only=True):
    """One quantity: its unit, and the scale of its errors at the default parameters; a scalar has a
    certified value and radius.
    """

    name: str
    unit: str = ""
    scale: float | None = None
    mid: str = ""
    radius: str = ""


class CheckLine(msgspec.Struct, frozen=True, kw_only=True):
    """One check that applies to the case at its defaults: its title and the faults it detects."""

    name: str
    title: str
    kills: str


class TruthLine(msgspec.Struct, frozen=True, kw_only=True):
    """The proof and the witness of a case's values, and the certified values in the store."""

    method: str
    own_witness: str
    witness: str
    witnessed: int
    agreed: int | None
    sets: int
    values: int
    digits: int | None
    has_no_witness: bool
    labels: tuple[str, ...] = ()
    not_certified: tuple[tuple[str, str, str], ...] = ()
    """(set, time, reason)"""


class Slip(msgspec.Struct, frozen=True, kw_only=True):
    """An error of the source: the place, the statement there, the correct statement, and numbers
    (name, value) that decide between them.
    """

    where: str
    says: str
    holds: str
    measured: tuple[tuple[str, str], ...]


class ChapterLine(msgspec.Struct, frozen=True, kw_only=True):
    """One item of the source chapter: where it stands, what it states, the case that runs it with
    its parameters, the engines that can, the check that judges it, and what that check kills.
    """

    where: str
    states: str
    case: str
    parameters: str
    engines: tuple[str, ...]
    check: str
    kills: str
    pictures: tuple[str, ...] = ()


class ManualPage(msgspec.Struct, frozen=True, kw_only=True):
    """The page of the manual about one case."""

    case: str
    title: str
    words: tuple[str, ...]
    statement: str
    latex: str
    source: str
    convention: str
    kind: str
    features: tuple[str, ...]
    parameters: tuple[ParameterLine, ...]
    quantities: tuple[QuantityLine, ...]
    scalars: tuple[QuantityLine, ...]
    moved: tuple[MovedLine, ...] = ()
    moved_at: str = ""
    truth: TruthLine
    checks: tuple[CheckLine, ...]
    slips: tuple[Slip, ...]
    reproduce: tuple[str, ...]
