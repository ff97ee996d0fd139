"""Writes the goals of reports/bench.md from the tables below them.

usage: ci/bench/bench_goals.py [--check]

One work has one number: what a table of the bench shows is read from there, and never measured a
second time for the goals.
`--check` changes nothing, and ends with 1 where the page says something else than its tables.
"""

import re
import sys
from dataclasses import dataclass
from pathlib import Path

PAGE = Path(__file__).parents[2] / "reports" / "bench.md"
BEGIN = "<!-- ci/bench/bench_goals.py -->"
END = "<!-- end -->"
HEAD = "| work | goal | measured | met |\n| --- | --- | --- | --- |\n"


@dataclass(frozen=True)
class Goal:
    """A work of the bench: its section, our method, and what is wanted of it.

    `ratios` has how many times faster than the best peer at which error (0: shown, and no goal).
    `error` is the largest that is allowed,
    `part` the same as a part of that of the peer `beside`. `rival` is another engine and how many
    times faster than it.
    """

    work: str
    section: str
    method: str
    ratios: dict[str, float]
    beside: str
    error: float = 0.0
    part: float = 0.0
    rival: tuple[str, float] = ("", 0.0)

    @property
    def words(self) -> str:
        """The goal."""
        parts = [f"{ratio:g}x at {level}" for level, ratio in self.ratios.items() if ratio]
        if self.rival[0]:
            parts.append(f"{self.rival[1]:g}x {self.rival[0]}")
        if self.error:
            parts.append(f"error {self.error:g}")
        if self.part:
            parts.append(
                f"error 1/{1 / self.part:g} of that of {self.beside}"
                if self.part < 1
                else f"error of {self.beside}"
            )
        return ", ".join(parts)


GOALS = (
    Goal(
        "free rigid body at t = 100",
        "free-rigid-body[duration=100 samples=2]",
        "exact-free-body",
        {"1e-3": 12, "1e-12": 50},
        "heyoka taylor",
    ),
    Goal(
        "the same, 1e-4 from the unstable axis",
        "free-rigid-body[omega_body=0.0001,1,0.0001 duration=100 samples=2]",
        "exact-free-body",
        {"1e-3": 0, "1e-9": 0},
        "heyoka taylor",
        part=1 / 40,
    ),
    Goal(
        "pendulum, 100 periods",
        "pendulum[duration=214.5 samples=2]",
        "exact-pendulum",
        {"1e-3": 700, "1e-12": 1400},
        "heyoka taylor",
        error=1e-14,
    ),
    Goal(
        "Coulomb, 32 periods, heyoka's events",
        "coulomb-oscillator[friction_force=0.01 duration=200 samples=2]",
        "exact-coulomb",
        {"1e-3": 100, "1e-12": 100},
        "heyoka taylor-events",
    ),
    Goal(
        "Kepler, 100 orbits",
        "two-body-orbit[duration=628.3 samples=2]",
        "exact-kepler",
        {"1e-3": 1000, "1e-9": 1000},
        "rebound ias15",
        part=1,
        rival=("rebound whfast", 1.5),
    ),
)


def cells(page: str, section: str, title: str, method: str) -> dict[str, str]:
    """One row of one table of a section, by the names of its columns."""
    after = page.split(f"\n## {section}\n", 1)[1].split("\n## ", 1)[0]
    lines = after.split(f"{title}:\n", 1)[1].strip().split("\n\n", 1)[0].split("\n")
    rows = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in lines]
    for row in rows[2:]:
        if re.sub(r" \((reference|peer)\)$", "", row[0]) == method:
            return dict(zip(rows[0], row, strict=True))
    raise SystemExit(f"bench_goals: no row {method!r} in {title!r} of {section!r}")


def seconds(cell: str) -> float:
    """The median of a cell like `15 us (12 us to 19 us)`."""
    number, unit = cell.split()[:2]
    return float(number) * {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[unit]


def row(page: str, goal: Goal) -> str:
    """The row of a goal."""
    faster = cells(page, goal.section, "Faster than the best peer by", f"reference {goal.method}")
    ours = cells(page, goal.section, "Time to an error", f"reference {goal.method}")
    theirs = cells(page, goal.section, "Time to an error", goal.beside)
    found = [faster[f"to {level}"] for level in goal.ratios]
    is_met = [
        float(cell.split("x")[0]) >= ratio
        for cell, ratio in zip(found, goal.ratios.values(), strict=True)
    ]
    error = float(ours["least error"])
    other = float(theirs["least error"])
    if goal.error:
        is_met.append(error <= goal.error)
    if goal.part:
        is_met.append(error <= goal.part * other)
    parts = [f"{cell} at {level}" for cell, level in zip(found, goal.ratios, strict=True)]
    rival, wanted = goal.rival
    if rival:
        ratio = seconds(cells(page, goal.section, "Time to an error", rival)["to 1e-3"]) / seconds(
            ours["to 1e-3"]
        )
        is_met.append(ratio >= wanted)
        parts.append(f"{ratio:.2g}x {rival}")
    seen = ", ".join(parts)
    measured = (
        f"{seen}; {ours['to 1e-3'].split(' (')[0]}; error {ours['least error']}, of {goal.beside}"
        f" {theirs['least error']}"
    )
    return f"| {goal.work} | {goal.words} | {measured} | {'yes' if all(is_met) else 'no'} |\n"


def filled(page: str) -> str:
    """The page with its goals as its tables have them."""
    before, rest = page.split(BEGIN, 1)
    _, after = rest.split(END, 1)
    rows = "".join(row(page, goal) for goal in GOALS)
    return f"{before}{BEGIN}\n\n{HEAD}{rows}\n{END}{after}"


def main() -> int:
    """Writes the page, or says whether it is as it should be."""
    page = PAGE.read_text()
    made = filled(page)
    if "--check" in sys.argv[1:]:
        return int(made != page)
    PAGE.write_text(made)
    return 0


if __name__ == "__main__":
    sys.exit(main())
