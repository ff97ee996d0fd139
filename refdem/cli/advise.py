"""refdem advise: which method, and which step, for a number of correct digits."""

import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from refdem.cli import completion, options
from refdem.errors import UsageError

if TYPE_CHECKING:
    from refdem.planning.specification import Specification
    from refdem.report.advice import Choice, Loss, Recommendation
    from refdem.report.contents import Contents

MOST_DIGITS = 15.0
"""Largest number of digits that can be requested: binary64 has no more."""
DIGITS = 3.0
"""Correct digits that are wanted if none are given."""
MOST_ROWS = 40
"""Largest number of settings that a table shows separately, one screen of them."""
CHECKS = ("error", "order")
"""Checks whose runs measure the error at every step and its order."""


def command(
    case: Annotated[
        list[str] | None,
        typer.Argument(
            autocompletion=completion.cases,
            help=(
                "Cases such as `pendulum` or `pendulum[theta0=2]`, or search words such as"
                " satellite. Alternatively, use --motion."
            ),
        ),
    ] = None,
    engine: options.Engines = None,
    motion: Annotated[
        str,
        typer.Option(
            autocompletion=completion.motions,
            help=(
                "Kind of motion: spinning, swinging, oscillating, rubbing, colliding, orbiting or"
                " flying. Selects all cases of campaign main with this motion."
            ),
        ),
    ] = "",
    digits: Annotated[
        float | None,
        typer.Option(
            help="Required number of correct digits.",
            min=0.0,
            max=MOST_DIGITS,
            show_default=f"{DIGITS:g}",
        ),
    ] = None,
    set: options.Settings = None,
    rules: Annotated[
        bool,
        typer.Option(
            "--rules",
            help="Show the time steps that DEM codes choose or accept for these contacts.",
        ),
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="With --rules: folder for steps.md, the table as a page.")
    ] = None,
    jobs: options.Jobs = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Recommends a method and a step for a given accuracy.

    The cost of each is reported.

    A method holds d digits if its error against certified truth is at most 10^-d of the scale of
    each quantity over the whole run. Measurements are stored and used again by later calls. Exit
    status 1 if no method holds the digits in all settings.

    With --rules: the time steps that YADE, exaDEM, MFIX-Exa, MercuryDPM, Lethe and LIGGGHTS choose,
    accept or display for the contacts of these cases, each as a fraction of the stability limit
    2/omega of velocity Verlet, and the error of velocity Verlet with that step.

    Example: refdem advise --motion spinning --engine mujoco --digits 3
    """
    from refdem.report import advice

    if rules:
        from refdem.cli.step_rules import print_step_rules, refuse_without_use

        refuse_without_use({"--engine": engine, "--digits": digits, "--jobs": jobs})
        print_step_rules(requested_campaign(case or [], set or [], motion), out, json=json)
        return
    if out is not None:
        raise UsageError("got --out without --rules; expected both, or neither")
    contents = measured(
        requested_campaign(case or [], set or [], motion), engine or [], jobs, CHECKS
    )
    if digits is None:
        digits = DIGITS
    found = advice.recommendations(advice.choices(contents, digits))
    losses = advice.losses(contents)
    if json:
        print_json(digits, found, losses, advice.without(contents))
    else:
        # Names of engines and methods may come from a file, which is not trusted.
        printed = lines(contents, digits, found, losses)
        print("\n".join(shown(line) for line in printed))
    if not found:
        raise typer.Exit(2)
    raise typer.Exit(int(not any(one.holds for one in found)))


def requested_campaign(cases: list[str], pairs: list[str], motion: str) -> "Specification":
    """The named cases, or those of the campaign main with the kind of motion `motion`.

    Raises UsageError for neither, both, or an unknown kind of motion.
    """
    import msgspec

    from refdem.cli.run import specification_of
    from refdem.core import discovery
    from refdem.core.case import Canonical
    from refdem.core.parameters import nearest
    from refdem.planning.specification import named

    if bool(cases) == bool(motion):
        raise UsageError(
            "expected either cases, as in `refdem advise pendulum`, or `--motion swinging`; got"
            f" {'both' if cases else 'neither'}"
        )
    if cases:
        return specification_of(labels_found(cases), pairs, "")
    if pairs:
        raise UsageError(
            "--set cannot be combined with --motion, whose cases set their own parameters"
        )
    known = completion.known_motions()
    if motion not in known:
        raise UsageError(f"no motion is named {motion!r}; {nearest(motion, known)}")

    def has_motion(name: str) -> bool:
        case = discovery.case(name)
        return isinstance(case, Canonical) and case.motion == motion

    main = named("main")
    entries = [entry for entry in main.case if has_motion(entry.id)]
    return msgspec.structs.replace(main, case=entries, required="", is_part=True)


def labels_found(texts: list[str]) -> list[str]:
    """The labels among the texts unchanged, and the ids of the cases that match the other texts.

    A case must match all of these words; if none does, the cases that match each word are taken. A
    text without a match is returned unchanged.
    """
    from refdem.core import discovery

    known = discovery.names("cases")
    labels = [text for text in texts if text.partition("[")[0] in known]
    words = [text for text in texts if text not in labels]
    found = motions_about(" ".join(words))
    if not found:
        for word in words:
            found += motions_about(word) or [word]
    # Two words may find the same case.
    return labels + [name for name in dict.fromkeys(found) if name not in labels]


def motions_about(text: str) -> list[str]:
    """Ids of the cases, without selections, that match a text."""
    from refdem.core import discovery
    from refdem.core.case import Canonical

    return [
        name for name in discovery.cases_about(text) if isinstance(discovery.case(name), Canonical)
    ]


def measured(
    specification: "Specification",
    engines: list[str],
    jobs: int | None,
    checks: tuple[str, ...],
) -> "Contents":
    """The results of a campaign of these cases; unchanged runs are read from the store."""
    import msgspec

    from refdem.cli.progress import Progress
    from refdem.cli.run import workers
    from refdem.core.store import Store, default_path
    from refdem.planning.campaign import Campaign
    from refdem.report.contents import contents_of

    chosen = msgspec.structs.replace(specification, engines=engines, checks=list(checks))
    campaign = Campaign(chosen, Store(default_path()), workers(jobs), True, Progress())
    return contents_of(campaign.sheets())


def lines(
    contents: "Contents",
    digits: float,
    found: "list[Recommendation]",
    losses: "list[Loss]",
) -> list[str]:
    """The advice, line by line: methods, then every setting, then what the default step loses."""
    settings = len(contents.cases)
    printed = [
        f"{digits:g} digits: errors of at most {10.0**-digits:.1g} of each quantity's scale, in"
        f" {count_text(settings, 'setting')}",
        "",
    ]
    for one in found:
        printed.append(recommended(one, digits, settings))
    without = unmeasured(contents)
    if without:
        printed += ["", *without]
    if found:
        printed += ["", *table(found), "tau: the shortest time of the motion in its setting"]
    if losses:
        printed.append("")
    for loss in losses:
        printed.append(lost(loss))
    return printed


def unmeasured(contents: "Contents") -> list[str]:
    """For every engine the number of settings in which none of its methods was measured, then one
    line for each reason, with the cases to which it applies.
    """
    from refdem.report import advice

    printed = []
    for engine, labels in advice.without(contents).items():
        of_reason: dict[str, list[str]] = {}
        for label in labels:
            of_reason.setdefault(reason(contents, label, engine), []).append(label)
        printed.append(f"{engine}: not measured in {len(labels)} of {len(contents.cases)}")
        for sentence, own in sorted(of_reason.items(), key=lambda item: -len(item[1])):
            printed.append(f"    {sentence} ({listed(own)})")
    return printed


def reason(contents: "Contents", label: str, engine: str) -> str:
    """Why no method of an engine was measured in a setting: the reason that most of its methods
    give, and how many others there are.
    """
    from refdem.core.outside import one_line

    sentences = Counter(
        finding.sentence
        for record in contents.of(label)
        if record.engine == engine
        for finding in record.findings
    )
    if not sentences:
        return "No check of errors applies."
    (sentence, _), *others = sentences.most_common()
    text = one_line(sentence)
    if others:
        text += f" And {count_text(len(others), 'other reason')} in other methods."
    return text


def recommended(one: "Recommendation", digits: float, settings: int) -> str:
    """The sentence about one method in all of its settings, of so many that there are."""
    of_all = len(one.held) + len(one.missed)
    name = f"{one.engine}/{one.method}"
    if not one.held:
        best = min(choice.error for choice in one.missed)
        return (
            f"{name}: does not hold {digits:g} digits in {every(of_all)} that it can run; its"
            f" smallest error is {best:.1e}"
        )
    if one.holds and of_all == settings:
        where = every(of_all)
    elif one.holds:
        where = f"{every(of_all)} that it can run, of {settings}"
    else:
        labels = [choice.record.label for choice in one.missed]
        where = f"{len(one.held)} of {of_all} settings, not in {listed(labels)}"
    if one.tolerance is not None:
        how = f"a tolerance of {one.tolerance:.2g}"
    elif one.steps_per_tau is None:
        how = "exact at any step"
    else:
        how = f"{math.ceil(one.steps_per_tau)} steps per tau"
    extrapolated = ""
    if one.extrapolated:
        extrapolated = f" ({one.extrapolated} extrapolated)"
    return (
        f"{name}: {how}{extrapolated}, in {where}; a second of motion takes at most"
        f" {one.cost:.1e} s to compute"
    )


def table(found: "list[Recommendation]") -> list[str]:
    """Every method in every setting in which it holds the digits: step, steps in tau, error,
    cost.

    Of more than MOST_ROWS of these, one a case: the setting that asks for the most steps.
    """
    held = [choice for one in found for choice in one.held]
    is_shortened = len(held) > MOST_ROWS
    if is_shortened:
        held = hardest(held)
    rows = [("setting", "method", "step [s]", "steps per tau", "error", "cost [s/s]")]
    rows += [cells(choice) for choice in held]
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    printed = []
    for row in rows:
        # Words begin at the left of their column, numbers end at its right.
        words = [text.ljust(width) for text, width in zip(row[:2], widths[:2], strict=True)]
        numbers = [text.rjust(width) for text, width in zip(row[2:], widths[2:], strict=True)]
        printed.append("  ".join([*words, *numbers]).rstrip())
    if is_shortened:
        printed.append(
            "one row per case, for its most demanding setting; --json lists every setting"
        )
    if any(choice.is_extrapolated for choice in held):
        printed.append("~ extrapolated with the measured order; no run used a step this small")
    if any(choice.is_coarsest for choice in held):
        printed.append(">= the largest step that was run; a larger one may suffice")
    return printed


def hardest(held: "Iterable[Choice]") -> "list[Choice]":
    """The most demanding choice for each case and method: the most steps per tau, or the smallest
    tolerance, and among equals the highest cost.
    """

    def demand(choice: "Choice") -> tuple[float, float]:
        if choice.steps_per_tau is not None:
            return choice.steps_per_tau, choice.cost
        # An exact method has no level; a smaller tolerance is more demanding.
        return -(choice.level or 0.0), choice.cost

    of_case: dict[tuple[str, str], Choice] = {}
    for choice in held:
        key = (choice.name, choice.record.case)
        if key not in of_case or demand(choice) > demand(of_case[key]):
            of_case[key] = choice
    return list(of_case.values())


def cells(choice: "Choice") -> tuple[str, str, str, str, str, str]:
    """The cells of one choice in the table."""
    mark = ""
    if choice.is_extrapolated:
        mark = "~"
    elif choice.is_coarsest and choice.control == "step":
        mark = ">= "
    if choice.control == "exact":
        level = "any"
    elif choice.control == "tolerance":
        level = f"tolerance {choice.level:.2g}"
    else:
        level = f"{mark}{choice.level:.2g}"
    steps = ""
    if choice.steps_per_tau is not None:
        steps = f"{choice.steps_per_tau:.3g}"
    return (
        choice.record.label,
        choice.name,
        level,
        steps,
        f"{choice.error:.1e}",
        f"{choice.cost:.1e}",
    )


def lost(loss: "Loss") -> str:
    """The sentence about the default step of an engine with one method."""
    about = ""
    if loss.is_least:
        about = "at least "
    elif loss.is_extrapolated:
        about = "about "
    return (
        f"{loss.record.engine}/{loss.record.method} at its default step of {loss.step:g} s: the"
        f" largest error is {about}{loss.error:.1e}, in {loss.finding}"
    )


def shown(line: str) -> str:
    """A line without control characters, which could move the cursor or change colours."""
    return "".join(c if c.isprintable() else "?" for c in line)


def listed(labels: list[str]) -> str:
    """The cases that settings are of, with their numbers: `pendulum, heavy-top (3 settings)`."""
    of_case = Counter(label.partition("[")[0] for label in labels)
    words = []
    for case, number in of_case.items():
        if number == 1:
            words.append(case)
        else:
            words.append(f"{case} ({number} settings)")
    return ", ".join(words)


def every(number: int) -> str:
    """The settings, all of them: `the setting`, `each of the 3 settings`."""
    if number == 1:
        return "the only setting"
    return f"each of the {number} settings"


def count_text(number: int, noun: str) -> str:
    """A number with its noun: `1 setting`, `2 settings`."""
    if number == 1:
        return f"1 {noun}"
    return f"{number} {noun}s"


def print_json(
    digits: float,
    found: "list[Recommendation]",
    losses: "list[Loss]",
    missing: dict[str, list[str]],
) -> None:
    """The same as JSON: methods, each with its settings; what default steps lose; what is not
    measured.
    """
    import json as format

    methods = [as_json(one) for one in found]
    defaults = [
        {
            "engine": loss.record.engine,
            "method": loss.record.method,
            "step": loss.step,
            "error": loss.error,
            "is_least": loss.is_least,
            "is_extrapolated": loss.is_extrapolated,
            "finding": loss.finding,
        }
        for loss in losses
    ]
    answer = {"digits": digits, "methods": methods, "defaults": defaults, "unmeasured": missing}
    print(format.dumps(answer, indent=1, allow_nan=False))


def as_json(one: "Recommendation") -> dict[str, Any]:
    """One method with all of its settings."""
    settings = [
        {
            "label": choice.record.label,
            "level": choice.level,
            "control": choice.control,
            "steps_per_tau": choice.steps_per_tau,
            "error": choice.error,
            "cost": choice.cost if math.isfinite(choice.cost) else None,
            "is_extrapolated": choice.is_extrapolated,
            "is_coarsest": choice.is_coarsest,
        }
        for choice in (*one.held, *one.missed)
    ]
    return {
        "engine": one.engine,
        "method": one.method,
        "holds": one.holds,
        "steps_per_tau": one.steps_per_tau,
        "tolerance": one.tolerance,
        "settings": settings,
    }
