"""What a program or a notebook calls: runs of a case, and an integrator of one's own that is
judged.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any

from refdem.campaign.campaign import Campaign
from refdem.campaign.specification import Entry, Specification
from refdem.cli.summary import lines
from refdem.core.engine import Method
from refdem.core.finding import BROKEN, Finding, Record, Sheet, findings_of
from refdem.core.outside import one_line
from refdem.core.parameters import text_of
from refdem.core.store import Store, default_path
from refdem.gate import in_process
from refdem.gate.own_step import OwnStep, Step
from refdem.report.tables import tables

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class Judged:
    """The sheets of judged runs; it prints as the summary of `refdem run`, and a notebook shows a
    table of its findings.
    """

    sheets: tuple[Sheet, ...]

    @property
    def records(self) -> list[Record]:
        """A record for each engine and method, with its findings."""
        return [sheet for sheet in self.sheets if isinstance(sheet, Record)]

    @property
    def outcomes(self) -> dict[str, int]:
        """How many findings have each outcome."""
        return dict(Counter(finding.outcome for finding in self._findings()))

    @property
    def holds(self) -> bool:
        """True if something was judged, and no finding failed or is an error."""
        found = Counter(finding.outcome for finding in self._findings())
        return found["pass"] > 0 and not any(found[outcome] for outcome in BROKEN)

    @cached_property
    def findings(self) -> "pd.DataFrame":
        """A row for each finding, with its bound and sentence."""
        return tables(self.sheets).findings

    @cached_property
    def tolerance(self) -> "pd.DataFrame":
        """A row of the tolerance table for each engine, method and quantity."""
        return tables(self.sheets).tolerance

    @cached_property
    def levels(self) -> "pd.DataFrame":
        """A row a refinement level, with its step, error, bound and cost."""
        return tables(self.sheets).levels

    def _findings(self) -> Iterable[Finding]:
        """All findings, record by record."""
        return (finding for _, finding in findings_of(self.records))

    def __repr__(self) -> str:
        return "\n".join(lines(list(self.sheets)))

    def _repr_html_(self) -> str:
        """A table of the findings, for a notebook."""
        rows = [
            (
                record.engine,
                record.method,
                f"{finding.check}/{finding.quantity}",
                finding.outcome,
                finding.sentence,
            )
            for record, finding in findings_of(self.records)
        ]
        body = [f"<tr>{''.join(f'<td>{_shown(cell)}</td>' for cell in row)}</tr>" for row in rows]
        head = ("engine", "method", "finding", "outcome", "sentence")
        titles = "".join(f"<th>{title}</th>" for title in head)
        return f"<table><tr>{titles}</tr>{''.join(body)}</table>"


def _shown(text: str) -> str:
    """Text of a program as a cell of HTML."""
    return escape(one_line(text))


def run(
    case: str,
    engine: str | Iterable[str] = "reference",
    *,
    method: str = "",
    step: float | None = None,
    levels: int = 4,
    **parameters: Any,
) -> Judged:
    """Runs a case in one engine or several and judges it: `run("pendulum", "mujoco", theta0=2.0)`.

    `method` keeps only that one; `step` [s] is the first of at most `levels`, each half of the one
    before. Parameters are texts, numbers or several; a float stands for its exact value. Runs are
    made in this process, and kept in the store of `refdem run`.
    """
    if isinstance(engine, str):
        engines = [engine]
    else:
        engines = list(engine)
    specification = Specification(
        name="run",
        case=[Entry(case, _texts(parameters))],
        engines=engines,
        method=method,
        step=step,
        levels=levels,
    )
    store = Store(default_path())
    try:
        return Judged(tuple(Campaign(specification, store, jobs=0).sheets()))
    finally:
        store.close()


def judge(
    step: Step,
    case: str,
    *,
    order: int,
    conserves: Iterable[str] = (),
    symplectic: bool = False,
    reversible: bool = False,
    levels: int = 4,
    **parameters: Any,
) -> Judged:
    """Judges an integrator of one's own, of which `step(t, r, v, h, a)` makes one step.

    It gets the time t [s], places r [m] and velocities v [m/s] of all bodies (N, 3), the step h [s]
    and the function a(t, r, v) of their accelerations (N, 3) [m/s^2]; it returns the places and
    velocities at t + h. `order`, `conserves` (energy, momentum, angular-momentum), `symplectic` and
    `reversible` are what it claims. Scenes with more than points in forces are unsupported.
    """
    method = Method(
        name=step.__name__,
        summary=f"the function {step.__name__}",
        control="step",
        order=order,
        conserves=frozenset(conserves),
        symplectic=symplectic,
        reversible=reversible,
    )
    settings = " ".join(f"{name}={text}" for name, text in _texts(parameters).items())
    label = case
    if settings:
        label = f"{case}[{settings}]"
    return Judged(tuple(in_process.records(OwnStep(step, method), [label], levels=levels)))


def _texts(parameters: dict[str, Any]) -> dict[str, str]:
    """Parameters as the texts that cases take."""
    return {name: text_of(value) for name, value in parameters.items()}
