"""The source chapter item by item: equation, figure, table or exercise, the case that runs it, the
engines that can, the check that judges it and what that check kills.
"""

import re
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from itertools import chain
from pathlib import Path

import msgspec

from refdem.core import discovery
from refdem.core.case import Canonical, Instance
from refdem.core.engine import Engine
from refdem.core.manual import ChapterLine
from refdem.core.problem import Request
from refdem.core.static_problems import Static
from refdem.faults.catalogue import chosen
from refdem.faults.fault import Fault

FILE = Path(__file__).with_name("chapter.toml")
SPOILED = 1e-3
"""Part of its scale by which a number is off that the check `error` must see."""
RANGE = re.compile(r"\(1\.(\d+)\)(?:-\(1\.(\d+)\))?")
"""An equation, or several from one to another."""
OTHERS = re.compile(r"(?:figure|Table|exercise) 1\.\d+(?: [a-e]\b)?")
"""A figure, a table, or an exercise with its part."""


class Item(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Something that the chapter states, the case that runs it, and what is seen to be wrong: the
    fault `kills`, or any of `numbers`, names of quantities or of rows of them, that is off.

    `method` is the name of the method that the item is about, if it is about one. `picture` is the
    id of a figure that shows the item and is none of the chapter's.
    """

    where: str
    states: str
    case: str
    set: dict[str, str] = {}
    kills: str = ""
    numbers: tuple[str, ...] = ()
    method: str = ""
    picture: str = ""

    @property
    def instance(self) -> Instance:
        """The case at the parameters of the item."""
        case: Canonical = discovery.case(self.case)
        return case.at(**self.set)

    @property
    def fault(self) -> Fault | None:
        """The fault that the check of the item kills, or None where numbers are named."""
        if not self.kills:
            return None
        (fault,) = chosen([self.kills])
        return fault

    @property
    def check(self) -> str:
        """The name of the check that judges the item."""
        fault = self.fault
        if fault is None:
            return "error"
        check, _ = fault.sees
        return check

    @property
    def quantities(self) -> list[str]:
        """The quantities of the case that `numbers` names."""
        return [name for number in self.numbers for name in self.quantities_of(number)]

    def quantities_of(self, number: str) -> list[str]:
        """The quantities that one of `numbers` names: of `rotated` rotated.0, rotated.1 ..."""
        found = []
        for name in self.instance.quantities:
            row, _, component = name.rpartition(".")
            if name == number or (row == number and component.isdigit()):
                found.append(name)
        return found


class _File(msgspec.Struct, forbid_unknown_fields=True):
    item: tuple[Item, ...]


@cache
def items() -> tuple[Item, ...]:
    """All items of the chapter that have a case, in the order of the file."""
    return msgspec.toml.decode(FILE.read_bytes(), type=_File).item


def cited(where: str) -> set[str]:
    """What a place names one by one: "(1.1)-(1.3), figure 1.2" is (1.1), (1.2), (1.3) and
    figure 1.2.
    """
    found = set(OTHERS.findall(where))
    for first, last in RANGE.findall(where):
        numbers = range(int(first), int(last or first) + 1)
        found |= {f"(1.{number})" for number in numbers}
    return found


def lines(pictures: Collection[str]) -> Iterator[ChapterLine]:
    """The lines of the table, one an item; `pictures` are the ids of the figures of the gallery."""
    for item in items():
        shown = [*_figures_of(item.where), item.picture]
        figures = [name for name in shown if name in pictures]
        yield ChapterLine(
            where=item.where,
            states=item.states,
            case=item.case,
            parameters=parameters(item.set, item.method),
            engines=tuple(engines(item)),
            check=item.check,
            kills=killed(item),
            pictures=tuple(figures),
        )


def _figures_of(where: str) -> list[str]:
    """The ids of the figures that a place names, in their order."""
    return re.findall(r"figure (1\.\d+)", where)


def parameters(given: Mapping[str, str], method: str = "") -> str:
    """Parameters, and a method if one is named, as the command line reads them; empty at the
    defaults.
    """
    options = [f"--set {name}={value}" for name, value in given.items()]
    if method:
        options.append(f"--method {method}")
    return " ".join(options)


def engines(item: Item) -> Iterator[str]:
    """The engines that can run an item: those with a method for a motion, installed or not, and of
    those installed the ones that answer the numbers of a question without time, or how many.
    """
    for name in discovery.own_names("engines"):
        engine = discovery.engine(name)
        if not isinstance(item.instance.problem, Static):
            able = _methods(engine, item.instance)
            if item.method in able or (able and not item.method):
                yield name
        elif engine.missing() is None:
            answered = _answered(engine, item)
            if answered == len(item.numbers):
                yield name
            elif answered:
                yield f"{name} ({answered} of {len(item.numbers)})"


def _methods(engine: Engine, instance: Instance) -> list[str]:
    """The methods of an engine that can run an instance, by name."""
    problem = instance.problem
    return [method.name for method in engine.methods if engine.unsupported(problem, method) is None]


def _answered(engine: Engine, item: Item) -> int:
    """How many numbers of an item some method of an engine answers, at most."""
    instance = item.instance
    most = 0
    for method in _methods(engine, instance):
        trajectory, _ = engine.run(Request(problem=instance.problem, method=method))
        observed = instance.observe(trajectory)
        answers = [set(item.quantities_of(number)) <= set(observed) for number in item.numbers]
        most = max(most, sum(answers))
    return most


def killed(item: Item) -> str:
    """What the check of an item kills: the fault and its sentence, or the numbers that are off."""
    fault = item.fault
    if fault is not None:
        return f"{fault.name}: {fault.sentence}"
    return f"off by {SPOILED:g} of its scale: {', '.join(item.numbers)}"


def named() -> set[str]:
    """Every equation, figure, table and exercise that some item names."""
    return set(chain.from_iterable(cited(item.where) for item in items()))
