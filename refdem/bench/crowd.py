"""Run time per body and step in a gas of many spheres, compared with codes made for such gases:
interleaved rounds, medians, one thread.
"""

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from refdem.bench.crowds import crowds
from refdem.bench.crowds._crowd import Crowd, Gas
from refdem.bench.tables import Table, two
from refdem.core import discovery

LONG = 0.3
"""Approximate duration [s] of a round of the slowest runs, from which the number of steps follows.
"""
FEWEST_STEPS = 20
"""Smallest number of steps of a run, so that the start is a small part of its time."""
STEPS_PER_TAU = 5
"""Smallest number of steps per characteristic time tau of the gas. It is that of common practice,
since speed is compared and not accuracy.
"""
LAWS = {"smooth": {"friction": "0"}, "rough": {"friction": "1/2"}}


@dataclass(frozen=True)
class Cost:
    """Nanoseconds a body and step in each round.

    `beside` are those of the reference in the same rounds, in the same gas.
    """

    n: int
    law: str
    boundary: str
    name: str
    note: str
    rounds: Sequence[float]
    beside: Sequence[float]

    @property
    def ratio(self) -> float:
        """The cost in units of that of the reference: the median over the rounds."""
        pairs = zip(self.rounds, self.beside, strict=True)
        return statistics.median(seconds / other for seconds, other in pairs)


def costs(
    sizes: Sequence[int], rounds: int = 5, progress: Callable[[str], None] = lambda line: None
) -> list[Cost]:
    """The cost of every gas of these sizes in every installed code that supports it."""
    all_costs = []
    for n in sizes:
        for law, given in LAWS.items():
            for boundary in ("periodic", "walls"):
                progress(f"{n} spheres, {law}, {boundary}")
                instance = discovery.case("granular-gas").at(n=str(n), boundary=boundary, **given)
                # The step is a power of two: exact in every code.
                longest = instance.scales.tau / STEPS_PER_TAU
                step = float(2.0 ** np.floor(np.log2(longest)))
                gas = Gas(instance, step)
                able = [crowd for crowd in crowds() if crowd.unsupported(gas) is None]
                all_costs += _of_gas(gas, law, able, rounds)
    return all_costs


def _of_gas(gas: Gas, law: str, able: Sequence[Crowd], rounds: int) -> list[Cost]:
    """The costs of all codes on one gas, measured in turns."""
    n = len(gas.position)
    steps = {}
    for crowd in able:
        once = crowd.seconds(gas, FEWEST_STEPS) / FEWEST_STEPS
        steps[crowd] = max(FEWEST_STEPS, int(LONG / max(once, 1e-9)))
    taken: dict[Crowd, list[float]] = {crowd: [] for crowd in able}
    for _ in range(rounds):
        for crowd in able:
            seconds = crowd.seconds(gas, steps[crowd])
            taken[crowd].append(1e9 * seconds / steps[crowd] / n)
    of_reference = next(taken[crowd] for crowd in able if crowd.is_reference)
    if gas.periodic:
        boundary = "periodic"
    else:
        boundary = "walls"
    return [
        Cost(n, law, boundary, crowd.name, crowd.note, taken[crowd], of_reference) for crowd in able
    ]


def table(costs_found: Sequence[Cost]) -> Table:
    """The costs as a table: a line for each code in each gas."""
    header = ("gas", "code", "ns a body and step", "least to most", "times the reference", "note")
    rows = []
    for cost in costs_found:
        gas = f"{cost.n} {cost.law}, {cost.boundary}"
        median = two(statistics.median(cost.rounds))
        extremes = f"{two(min(cost.rounds))} to {two(max(cost.rounds))}"
        rows.append((gas, cost.name, median, extremes, two(cost.ratio), cost.note))
    return Table("Cost of a body and step in a gas of spheres", header, rows)
