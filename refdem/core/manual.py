"""The content of a page of the verification manual about a case; the page is a function of it."""

import msgspec


class ParameterLine(msgspec.Struct, frozen=True, kw_only=True):
    """One parameter: exact in truth, with unit and bounds."""

    name: str
    default: str
    unit: str
    bounds: str
    doc: str


class QuantityLine(msgspec.Struct, frozen=True, kw_only=True):
    """One quantity: its unit, and the size against which an error counts at the defaults; a scalar
    has a certified value and radius.
    """

    name: str
    unit: str = ""
    scale: float | None = None
    mid: str = ""
    radius: str = ""


class MovedLine(msgspec.Struct, frozen=True, kw_only=True):
    """What one number of a case moves: the quantity that it moves most, in units of its scale.

    `slope` is the derivative of this quantity by the number; a number larger by a small part a
    moves it by `share` times a of its scale (None for a number that is 0). No quantity is named
    where none depends on the number. `has_derivative` is False where motions are of another kind
    on either side of the number.
    """

    number: str
    value: float
    unit: str
    has_derivative: bool = True
    quantity: str = ""
    unit_of_quantity: str = ""
    slope: float = 0.0
    share: float | None = None


class CheckLine(msgspec.Struct, frozen=True, kw_only=True):
    """One check that applies to the case at its defaults: what it judges and kills."""

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
    """A slip of the source: where, what it says, what holds, and the numbers (what, value) that
    settle it.
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
