"""Sensitivity of the quantities of a case to each of its numbers, from certified derivatives, for
the report of a single case and for a page of the manual.
"""

import hashlib
from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

import msgspec

from refdem.core import discovery, fingerprint
from refdem.core.case import Instance
from refdem.core.moved import Moved, MovedLine
from refdem.core.run import Failure
from refdem.core.selection import Selection
from refdem.core.store import Store
from refdem.errors import NotCertifiedError
from refdem.execution.schedule import Job, Schedule
from refdem.planning.specification import Specification
from refdem.planning.truths import truth_key

if TYPE_CHECKING:
    from refdem.truth.sensitivities import Number, Sensitivities

DIGITS = 8
"""Decimal places to which derivatives are proved; a line shows four digits."""
SECONDS = 3.0
"""Limit on the CPU time [s] for derivatives in a report of a single case; most cases take less than
a second.
"""
_DECODER = msgspec.msgpack.Decoder(Moved)


def sheets(specification: Specification, store: Store) -> list[Moved]:
    """The sheet of sensitivities, if the specification has one instance and its problem has a time;
    otherwise none.

    It is proved in a worker process and kept in the store.
    """
    if len(specification.case) != 1:
        return []
    (entry,) = specification.case
    case = discovery.case(entry.id)
    if isinstance(case, Selection):
        return []
    instance = case.at(**entry.set)
    if not moved_at(instance):
        return []
    source = fingerprint.of_source("planning/moved.py", "core/moved.py")
    key = hashlib.sha256(f"{source}\0{truth_key(instance)}".encode()).hexdigest()
    kept = store.read("moved", key, _DECODER.decode)
    if kept is None:
        kept = _proved(instance)
        store.put("moved", key, msgspec.msgpack.encode(kept))
    return [kept]


def _proved(instance: Instance) -> Moved:
    """The sheet of an instance; it has only a reason if the proof takes longer than SECONDS."""
    job = Job(instance.label, of_case, (instance.case.id, instance.p.given), computes=True)
    with Schedule(1, SECONDS) as schedule:
        ((_, result),) = schedule.results([job])
    if isinstance(result, Failure):
        reason = f"the proof of the derivatives was given up: {result.sentence}"
        return msgspec.structs.replace(_empty(instance), reason=reason)
    return _DECODER.decode(result)


def _empty(instance: Instance) -> Moved:
    """The sheet of an instance without lines."""
    settings = [f"--set {name}={value}" for name, value in instance.p.changed().items()]
    words = ["refdem truth", instance.case.id, *settings]
    words.append(f"--sensitivities --at {moved_at(instance)}")
    return Moved(label=instance.label, at=moved_at(instance), command=" ".join(words))


def of_case(case: str, given: dict[str, str]) -> bytes:
    """The sheet of sensitivities of an instance, as MessagePack of Moved."""
    instance = discovery.case(case).at(**given)
    found = msgspec.structs.replace(_empty(instance), numbers=moved_lines(instance))
    return msgspec.msgpack.encode(found)


def moved_at(instance: Instance) -> str:
    """The time [s] at which the derivatives of a motion are shown, a third of it, in three digits;
    empty for a case without time.
    """
    times = instance.times
    if len(times) < 2:
        return ""
    return f"{float(times[len(times) // 3]):.3g}"


def moved_lines(instance: Instance) -> tuple[MovedLine, ...]:
    """A line for each number of a motion at its defaults; none where derivatives are not
    certified.
    """
    # Imports python-flint, which a sheet that is read from the store does not need.
    from refdem.truth.sensitivities import numbers_of, sensitivities

    time = moved_at(instance)
    if not time:
        return ()
    parameters = instance.case.written_out(instance.p)
    try:
        found = sensitivities(instance.case.truth, parameters, Fraction(time), DIGITS)
    except NotCertifiedError:
        return ()
    numbers = [(number, number.of(parameters)) for number in numbers_of(parameters)]
    return tuple(line(instance, found, number, value) for number, value in numbers)


def line(
    instance: Instance, found: "Sensitivities", number: "Number", value: Fraction
) -> MovedLine:
    """The line of one number of this value: the quantity with the largest |dq/dp|/scale."""
    name = number.name
    unit = instance.p.declared[number.parameter].unit
    if name in found.missing:
        return MovedLine(number=name, value=float(value), unit=unit, has_derivative=False)
    size, quantity, slope = max(moves(instance, found, name))
    if size == 0:
        return MovedLine(number=name, value=float(value), unit=unit)
    share = None
    if value:
        share = abs(float(value)) * size
    return MovedLine(
        number=name,
        value=float(value),
        unit=unit,
        quantity=quantity,
        unit_of_quantity=instance.quantities[quantity].unit,
        slope=slope,
        share=share,
    )


def moves(
    instance: Instance, found: "Sensitivities", name: str
) -> Iterator[tuple[float, str, float]]:
    """|dq/dp|/scale, the quantity, and dq/dp, for every quantity and one number."""
    for quantity, by_number in found.of.items():
        if quantity in instance.quantities:
            slope = float(by_number[name].mid)
            yield abs(slope) / instance.quantities[quantity].scale, quantity, slope
