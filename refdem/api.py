"""What a program or a notebook calls: certified values, runs of a case, and an integrator of one's
own that is judged.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from html import escape
from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

from refdem.cli.summary import lines
from refdem.core import discovery
from refdem.core.discovery import truth_of
from refdem.core.engine import Method
from refdem.core.finding import BROKEN, Finding, Record, Sheet, findings_of
from refdem.core.moved import unit_of_derivative
from refdem.core.outside import one_line
from refdem.core.parameters import text_of
from refdem.core.store import Store, default_path
from refdem.errors import UsageError
from refdem.gate import in_process
from refdem.gate.own_step import OwnStep, Step
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification
from refdem.report import chart_data, charts
from refdem.report.contents import contents_of
from refdem.report.tables import Tables, tables
from refdem.report.tolerance import rows_of

DIGITS = 24
"""Digits to which derivatives are proved before they are rounded to doubles."""

if TYPE_CHECKING:
    import altair as alt
    import pandas as pd


class Sampled(NamedTuple):
    """Certified values as DataFrames with a row for each time t [s] and a column for each quantity:
    the doubles nearest to the middles, and radii about these doubles that contain the true values.
    """

    middles: "pd.DataFrame"
    radii: "pd.DataFrame"


class Slopes(NamedTuple):
    """Certified derivatives as DataFrames with a row for each time t [s] and quantity, and a column
    for each number of the case: the doubles nearest to the middles, and radii about these doubles
    that contain the true derivatives. `units` has a row for each quantity.

    NaN where there is no derivative: the motion is of another kind on either side of the number.
    """

    middles: "pd.DataFrame"
    radii: "pd.DataFrame"
    units: "pd.DataFrame"


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
        """A row for each finding, with its bound and sentence, and the parameters of the case."""
        return self._with_parameters(self._tables.findings)

    @cached_property
    def tolerance(self) -> "pd.DataFrame":
        """A row of the tolerance table for each engine, method and quantity, with the parameters of
        the case.
        """
        return self._with_parameters(self._tables.tolerance)

    @cached_property
    def levels(self) -> "pd.DataFrame":
        """A row a refinement level, with its step, error, bound and cost, and the parameters of the
        case.
        """
        return self._with_parameters(self._tables.levels)

    @cached_property
    def _tables(self) -> Tables:
        """The sheets as DataFrames."""
        return tables(self.sheets)

    def _with_parameters(self, frame: "pd.DataFrame") -> "pd.DataFrame":
        """A DataFrame with a column for each parameter behind its own: numbers where all its values
        are numbers, else texts as they were given. A name that is taken ends in `_set`.
        """
        import pandas as pd

        of_labels = {record.label: record.parameters for record in self.records}
        parameters = pd.DataFrame([of_labels[label] for label in frame["label"]], dtype=object)
        for name in parameters.columns:
            numbers = pd.to_numeric(parameters[name], errors="coerce")
            if numbers.notna().all():
                parameters[name] = numbers
        taken = {name: f"{name}_set" for name in parameters.columns if name in frame.columns}
        return frame.join(parameters.rename(columns=taken))

    def chart(self) -> "alt.TopLevelMixin":
        """Error against step, with the bounds, as the report draws it; a notebook shows it.

        Raises UsageError where no run has an error.
        """
        import altair as alt

        contents = contents_of(self.sheets)
        rows = [row for sheet in contents.cases for row in rows_of(contents, sheet.label)]
        data = chart_data.errors(contents, rows)
        if data is None:
            raise UsageError(f"there is nothing to draw, as no error was measured: {self!r}")
        chart: alt.TopLevelMixin = alt.Chart.from_dict(charts.specification(data))
        return chart

    def plot(self, axes: Any) -> None:
        """Draws the largest error of each method against its step into axes of matplotlib, with its
        bound dashed.
        """
        worst = self.levels.groupby(["engine", "method", "level"], as_index=False)[
            ["error", "bound"]
        ].max()
        for (engine, method), curve in worst.groupby(["engine", "method"]):
            (line,) = axes.plot(curve["level"], curve["error"], "o-", label=f"{engine} {method}")
            axes.plot(curve["level"], curve["bound"], "--", color=line.get_color())
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("step [s], or tolerance")
        axes.set_ylabel("largest error, of the scale of its quantity")
        axes.legend()

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


def sampled(case: str, times: Iterable[Any], **parameters: Any) -> Sampled:
    """Certified values of a case at times [s], each a number or a text such as "1/3":
    `sampled("pendulum", [0, 0.5, 1], theta0=2.0).middles["x"].to_numpy()`.

    Raises NotCertifiedError for a time beyond which nothing is certified.
    """
    import pandas as pd

    truth = truth_of(case, **parameters)
    # A float is the number that it is, as it is for parameters.
    exact = [Fraction(text_of(t)) for t in times]
    balls = [truth.at(t) for t in exact]
    index = pd.Index([float(t) for t in exact], name="t")
    pairs = [{name: ball.rounded() for name, ball in row.items()} for row in balls]
    middles = [{name: middle for name, (middle, _) in row.items()} for row in pairs]
    radii = [{name: radius for name, (_, radius) in row.items()} for row in pairs]
    return Sampled(pd.DataFrame(middles, index=index), pd.DataFrame(radii, index=index))


def sensitivities_of(case: str, times: Iterable[Any], **parameters: Any) -> Slopes:
    """Certified derivatives of the quantities of a case at times [s] by every number of it, each
    time a number or a text such as "1/3": the matrix of quantities by numbers at 0.5 s is
    `sensitivities_of("pendulum", [0.5], theta0=2.0).middles.loc[0.5].to_numpy()`.

    Raises NotCertifiedError where derivatives are not certified.
    """
    import pandas as pd

    from refdem.truth.sensitivities import sensitivities

    instance = discovery.case(case).at(**_texts(parameters))
    p = instance.case.written_out(instance.p)
    middles: dict[tuple[float, str], dict[str, float]] = {}
    radii: dict[tuple[float, str], dict[str, float]] = {}
    for t in times:
        # A float is the number that it is, as it is for parameters.
        exact = Fraction(text_of(t))
        found = sensitivities(instance.case.truth, p, exact, DIGITS)
        for quantity, by_number in found.of.items():
            pairs = {number: ball.rounded() for number, ball in by_number.items()}
            missing = dict.fromkeys(found.missing, nan)
            row = float(exact), quantity
            middles[row] = {number: middle for number, (middle, _) in pairs.items()} | missing
            radii[row] = {number: radius for number, (_, radius) in pairs.items()} | missing
    index = pd.MultiIndex.from_tuples(list(middles), names=["t", "quantity"])
    middle_rows = pd.DataFrame(list(middles.values()), index=index)
    radius_rows = pd.DataFrame(list(radii.values()), index=index)
    units = {
        quantity.name: {
            number: unit_of_derivative(quantity.unit, p.declared[number.partition(".")[0]].unit)
            for number in middle_rows.columns
        }
        for quantity in instance.quantities.values()
    }
    return Slopes(middle_rows, radius_rows, pd.DataFrame.from_dict(units, orient="index"))


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
