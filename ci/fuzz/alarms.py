"""Right programs at settings drawn over the whole range of every parameter.

usage: ci/fuzz/alarms.py --pairs N

A pair is a method of a program of tests/foreign/right and a setting of a case that it supports. Its
findings are those of `refdem run`; one that fails, or is an error, is an alarm: the program is not
as right as it claims, or refdem is wrong. Each alarm is printed with the command that repeats it.
A third of the settings are marginal: numbers that are equal, zero, or exactly at a border.
"""

import argparse
import collections
import contextlib
import fcntl
import os
import shlex
import signal
import sys
import time
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from types import FrameType

import msgspec
import numpy as np

ROOT = Path(__file__).parents[2]
# Behind what is installed: the tree has no kernels unless they are built in place.
sys.path.append(str(ROOT))

from refdem.core import discovery, refinement  # noqa: E402
from refdem.core.case import Case, Instance  # noqa: E402
from refdem.core.engine import Engine, Method  # noqa: E402
from refdem.core.parameters import Parameter, labelled  # noqa: E402
from refdem.core.problem import Motion  # noqa: E402
from refdem.core.selection import Selection  # noqa: E402
from refdem.core.truth import SampledTruth  # noqa: E402
from refdem.errors import UsageError  # noqa: E402
from refdem.execution import worker  # noqa: E402
from refdem.planning import in_process, plan  # noqa: E402
from refdem.planning.specification import Specification  # noqa: E402
from refdem.scene.elements.rod import Rod  # noqa: E402
from tests.foreign.right.programs import PROGRAMS  # noqa: E402

FOLDER = ROOT / "build" / "right"
"""Where the programs are compiled."""
LEVELS = 3
MOST_STEPS = 2000.0
METHODS_A_SETTING = 6
"""Pairs made of one setting: its truth is proved once."""
TRUTH_SECONDS = 3.0
PAIR_SECONDS = 20.0
"""Seconds after which a proof, or a pair, is given up and counted."""
REPEATED_SECONDS = 100.0
"""The same limit where only one pair was requested."""
DECADES = (0.5, 1.0, 3.0)
"""A setting multiplies its numbers by up to 10 to one of these powers, either way."""
DRAWS = 200
"""Sets that are drawn until one is of numbers that go together."""
MOST_LOST = 1e-3
"""Part of the impulses of rods that rounding may spoil: a program that loses more in each step is
not right there, whatever it is made of.
"""
MARGINAL = 1 / 3
MARGINS: Mapping[str, tuple[Mapping[str, str], ...]] = {
    # The mass stops where the spring pulls exactly as much as friction holds, or in the middle.
    "coulomb-oscillator": (
        {"friction_force": "1/4", "x0": "5/4"},
        {"friction_force": "1/8", "x0": "1"},
        {"friction_force": "1", "x0": "1"},
        {"friction_force": "0"},
    ),
    # Critical damping, and none.
    "viscous-oscillator": ({"delta": "1"}, {"delta": "0"}, {"delta": "1", "x0": "0", "v0": "1"}),
    "driven-oscillator": (
        {"delta": "1"},
        {"delta": "0", "drive": "1"},
        {"drive": "0"},
        {"f0": "0"},
    ),
    "two-spheres": (
        {"damping": "16"},
        {"damping": "16", "cutoff": "zero_force"},
        {"damping": "0", "friction": "1/4", "angle": "0"},
        {"damping": "0", "friction": "1/4", "angle": "1.5"},
    ),
    # A graze, a miss by a hair, head on, and balls that stay together.
    "hard-spheres": (
        {"offset": "1,0"},
        {"offset": "0.999999,0"},
        {"offset": "1.000001,0"},
        {"offset": "0,0", "restitution": "0"},
        {"offset": "0,0", "masses": "1,1", "restitution": "1"},
    ),
    # Along the wall, at the wall from the start, and a touch at the end of a step.
    "hard-wall": (
        {"velocity": "1,0,0"},
        {"position": "0,1/2,0"},
        {"velocity": "0,-1,0", "duration": "2", "samples": "17"},
        {"restitution": "0"},
    ),
    "bouncing-ball": (
        {"gravity": "8", "height": "1", "duration": "2", "samples": "17"},
        {"restitution": "1"},
    ),
    "two-body-orbit": ({"eccentricity": "0"}, {"eccentricity": "0.9"}, {"stiffness": "1"}),
    "free-rigid-body": (
        {"inertia": "1,1,1"},
        {"inertia": "1,1,2"},
        {"inertia": "1,2,3", "omega_body": "0,1,0"},
        {"omega_body": "0,0,0"},
        {"inertia": "1,1.000001,2"},
    ),
    "intermediate-axis": ({"offset": "1"}, {"inertia": "1,1,2"}),
    # Rolling from the start, at rest, and the steepest slope on which it rolls.
    "rolling": (
        {"speed": "1", "spin": "-2"},
        {"speed": "0", "spin": "0"},
        {"slope": "7/8", "friction": "1/4", "speed": "0"},
        {"friction": "0"},
    ),
    # At the saddle, and on the way to it.
    "duffing": (
        {"alpha": "1", "beta": "-1", "amplitude": "1"},
        {"alpha": "-1", "beta": "1", "amplitude": "1"},
        {"alpha": "0"},
        {"beta": "0"},
    ),
    "newtons-cradle": ({"restitution": "0"}, {"velocities": "1,0,0,0,0,0,-1"}),
    "stick-slip": ({"belt": "0"}, {"v0": "1"}, {"gamma": "0", "v0": "1"}),
}
"""Marginal settings of a case, beside those that `marginal` makes of any parameter."""
CASES = [
    name
    for name in discovery.names("cases")
    if isinstance(discovery.case(name), Case) and not isinstance(discovery.case(name), Selection)
]
CHEAP: Mapping[str, Mapping[str, str]] = {"granular-gas": {"n": "8"}}


class OutOfTimeError(BaseException):
    """A proof or a pair takes longer than its limit."""


class ProofError(Exception):
    """A proof ended with an unhandled exception: a fault of refdem."""


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises OutOfTimeError in this context after so many seconds."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise OutOfTimeError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def drawn_number(parameter: Parameter, default: float, rng: np.random.Generator) -> float:
    """A number within the bounds of a parameter, uniform over decades from its default where these
    leave it free.
    """
    decades = rng.choice(DECADES)
    scale = abs(default) or 1.0
    value = scale * 10.0 ** rng.uniform(-decades, decades)
    least = parameter.above if parameter.above is not None else parameter.at_least
    if least is not None and parameter.at_most is not None and rng.random() < 0.5:
        return float(rng.uniform(least, parameter.at_most))
    may_be_negative = least is None or least < 0
    if may_be_negative and rng.random() < 0.5:
        value = -value
    if parameter.at_most is not None:
        value = min(value, parameter.at_most)
    if least is not None:
        value = max(value, least)
    return float(value)


def marginal_numbers(
    parameter: Parameter, numbers: list[float], rng: np.random.Generator
) -> list[float]:
    """The numbers of a parameter at a border: all equal, zero, at a bound, or with other signs."""
    bounds = [b for b in (parameter.at_least, parameter.at_most) if b is not None]
    kind = rng.integers(4)
    if kind == 0:
        return [numbers[0]] * len(numbers)
    if kind == 1 and (parameter.above is None or parameter.above < 0):
        place = int(rng.integers(len(numbers)))
        return [0.0 if i == place else number for i, number in enumerate(numbers)]
    if kind == 2 and bounds:
        return [float(rng.choice(bounds))] * len(numbers)
    if kind == 3 and parameter.above is None and parameter.at_least is None:
        return [-number for number in numbers]
    return numbers


def drawn_value(parameter: Parameter, rng: np.random.Generator, is_marginal: bool) -> str:
    """A value as text; "" where the case decides."""
    if parameter.choices:
        return str(rng.choice(parameter.choices))
    if parameter.default == "":
        return ""
    exact = parameter.parsed(parameter.default)
    if isinstance(exact, tuple):
        numbers = [float(number) for number in exact]
    else:
        numbers = [float(Fraction(exact or 0))]
    if is_marginal:
        numbers = marginal_numbers(parameter, numbers, rng)
    else:
        numbers = [drawn_number(parameter, number, rng) for number in numbers]
    if parameter.whole:
        return ",".join(str(round(number)) for number in numbers)
    return ",".join(f"{number:.3g}" for number in numbers)


def drawn_instance(name: str, rng: np.random.Generator) -> Instance | None:
    """A case at the first set of parameters drawn that it accepts; None if none is."""
    case = discovery.case(name)
    for _ in range(DRAWS):
        is_marginal = bool(rng.random() < MARGINAL)
        given = dict(CHEAP.get(name, {}))
        named = MARGINS.get(name, ())
        if is_marginal and named and rng.random() < 0.5:
            given |= named[rng.integers(len(named))]
        else:
            part = rng.choice([0.2, 0.5, 1.0])
            for parameter in case.parameters:
                is_free = parameter.name not in (*given, "duration", "samples")
                if is_free and rng.random() < part:
                    given[parameter.name] = drawn_value(parameter, rng, is_marginal)
        given = {key: value for key, value in given.items() if value != ""}
        try:
            if "duration" not in given:
                tau = case.at(**given).scales.tau
                turns = float(rng.choice([1.0, 3.0, 10.0]))
                given |= {"duration": f"{turns * tau:.4g}", "samples": "16"}
            instance = case.at(**given)
            instance.refuse_unjudgeable()
            instance.problem  # noqa: B018 (made once, so that numbers that do not go together show)
        except UsageError:
            continue
        return instance
    return None


def specification(
    method: Method, levels: int = LEVELS, most_steps: float = MOST_STEPS
) -> Specification:
    """A short campaign of one method."""
    return Specification(
        name="alarms", case=[], levels=levels, most_steps=most_steps, method=method.name
    )


@dataclass
class Count:
    """What came of a run of pairs."""

    pairs: int = 0
    judged: int = 0
    unsupported: int = 0
    out_of_time: int = 0
    uncertified: int = 0
    outcomes: collections.Counter[str] = field(default_factory=collections.Counter)
    alarms: list[str] = field(default_factory=list)

    def add_alarm(
        self, kind: str, sentence: str, instance: Instance, engine: Engine, method: Method
    ) -> None:
        """Counts an alarm and prints it with the command that repeats it."""
        self.alarms.append(sentence)
        print(f"{kind} {sentence}\n    {command_of(instance, engine, method)}", flush=True)

    def summary(self) -> str:
        """A line of counts."""
        found = ", ".join(f"{n} {name}" for name, n in sorted(self.outcomes.items()))
        return (
            f"{self.judged} of {self.pairs} pairs were judged ({self.unsupported} refused,"
            f" {self.out_of_time} out of time); {self.uncertified} settings without certified truth"
            f" were left out; {found}; {len(self.alarms)} alarms"
        )


def engines() -> list[Engine]:
    """The programs, compiled where they are not or their sources are newer.

    One process at a time: another one would read a file that is half written.
    """
    sources = Path(ROOT / "tests" / "foreign").glob("[cr]*/*.[chp]*")
    newest = max(path.stat().st_mtime for path in sources)
    found = []
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for program in PROGRAMS:
            description = FOLDER / program.name / "refdem.toml"
            if not description.exists() or description.stat().st_mtime < newest:
                program.built(FOLDER)
            found.append(discovery.engine(str(description)))
    return found


def are_rods_solved(instance: Instance, method: Method) -> bool:
    """False where rods stand so, as those of a cluster that is nearly flat, that their impulses
    cannot be computed in the precision u of the method.

    They solve G M^-1 G^T x = b, with the directions G of the rods. From a matrix of condition K, x
    is known to the part K u.
    """
    problem = instance.problem
    if not isinstance(problem, Motion) or not problem.scene.all(Rod):
        return True
    masses = np.repeat(problem.scene.bodies.mass, 3)
    directions = refinement.rod_directions(problem.scene)
    condition = float(np.linalg.cond(directions / np.sqrt(masses))) ** 2
    return condition * method.round_off <= MOST_LOST


def delays(instance: Instance, campaigns: list[tuple[Engine, Specification]]) -> tuple[float, ...]:
    """The delays [s] > 0 by which velocities of some of these methods lag at one of their levels,
    sorted.
    """
    found: set[float] = set()
    for engine, asked in campaigns:
        for subject, _ in plan.subjects(asked, instance, engine):
            levels = refinement.order_levels(instance, subject.method, subject.levels)
            found |= {subject.method.delay(level) for level in levels}
    return tuple(sorted(found - {0.0}))


def proved(
    instance: Instance, lags: tuple[float, ...], seconds: float = TRUTH_SECONDS
) -> SampledTruth | None:
    """The certified samples of an instance, and so many seconds before them; None if there are none
    within the limit.
    """
    try:
        with limited(seconds):
            data = worker.sampled_truth(instance.case.id, instance.p.given, lags)
    except OutOfTimeError:
        return None
    except Exception:
        last = traceback.format_exc().splitlines()[-1]
        raise ProofError(f"the truth of {instance.label}: {last}") from None
    truth = msgspec.msgpack.decode(data, type=SampledTruth)
    if truth.until == 0:
        return None
    return truth


def command_of(instance: Instance, engine: Engine, method: Method) -> str:
    """The command that repeats a pair."""
    program = Path(engine.address).parent.name
    words = [".venv/bin/python", "ci/fuzz/alarms.py", "--case", instance.label]
    return shlex.join([*words, "--program", program, "--method", method.name])


def repeated(label: str, program: str, method_name: str, levels: int, most_steps: float) -> Count:
    """Judges one pair: the setting as its label has it."""
    name, given = labelled(label)
    instance = discovery.case(name).at(**given)
    (engine,) = [engine for engine in engines() if engine.name == f"right-{program}"]
    method = engine.method(method_name)
    asked = specification(method, levels, most_steps)
    count = Count()
    truth = proved(instance, delays(instance, [(engine, asked)]), REPEATED_SECONDS)
    if truth is None:
        count.uncertified += 1
    else:
        judge(instance, engine, method, truth, count, asked)
    return count


def judge(
    instance: Instance,
    engine: Engine,
    method: Method,
    truth: SampledTruth,
    count: Count,
    asked: Specification,
) -> None:
    """Judges one pair, and prints its alarms."""
    count.pairs += 1
    try:
        with limited(PAIR_SECONDS):
            (task,) = plan.tasks(asked, instance, (), engine, truth, truth.reason)
            record = in_process.record_of(task)
    except OutOfTimeError:
        count.out_of_time += 1
        return
    except Exception:
        # An unhandled exception is a fault of refdem: it is counted, and the other pairs continue.
        last = traceback.format_exc().splitlines()[-1]
        count.add_alarm(
            "EXCEPTION", f"{instance.label}/{engine.name}: {last}", instance, engine, method
        )
        return
    outcomes = collections.Counter(finding.outcome for finding in record.findings)
    if outcomes["unsupported"] and not outcomes["fail"]:
        count.unsupported += 1
        return
    count.judged += bool(outcomes["pass"] or outcomes["fail"])
    count.outcomes += outcomes
    for finding in record.findings:
        if finding.outcome in ("fail", "error"):
            sentence = f"{record.id(finding)}: {finding.sentence}"
            count.add_alarm(finding.outcome.upper(), sentence, instance, engine, method)


def settings_of(cases: list[str], seed: int, count: int) -> list[Instance]:
    """So many settings drawn with a seed."""
    rng = np.random.default_rng(seed)
    drawn = [drawn_instance(str(rng.choice(cases)), rng) for _ in range(count)]
    return [instance for instance in drawn if instance is not None]


def alarms(pairs: int, seed: int, seconds: float = float("inf"), case: str = "") -> Count:
    """Judges so many pairs drawn with a seed, or as many as the time allows."""
    rng = np.random.default_rng(seed)
    of_methods = [(engine, method) for engine in engines() for method in engine.methods]
    cases = [case] if case else CASES
    defaults = {name: discovery.case(name).at(**CHEAP.get(name, {})).problem for name in cases}
    cases = [
        name
        for name in cases
        if any(engine.unsupported(defaults[name], method) is None for engine, method in of_methods)
        or name in MARGINS
    ]
    count = Count()
    end = time.monotonic() + seconds
    while count.pairs < pairs and time.monotonic() < end:
        instance = drawn_instance(str(rng.choice(cases)), rng)
        if instance is None:
            continue
        problem = instance.problem
        able = [
            (engine, method)
            for engine, method in of_methods
            if engine.unsupported(problem, method) is None and are_rods_solved(instance, method)
        ]
        if not able:
            continue
        most = min(len(able), METHODS_A_SETTING, pairs - count.pairs)
        chosen = [able[place] for place in rng.permutation(len(able))[:most]]
        try:
            truth = proved(instance, delays(instance, [(e, specification(m)) for e, m in chosen]))
        except ProofError as error:
            count.alarms.append(str(error))
            print(f"EXCEPTION {error}", flush=True)
            continue
        if truth is None:
            count.uncertified += 1
            continue
        for engine, method in chosen:
            judge(instance, engine, method, truth, count, specification(method))
    return count


def main() -> int:
    """Prints alarms and counts; exit status 1 if there are alarms."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=300)
    parser.add_argument("--seed", type=int, default=int.from_bytes(os.urandom(4), "big"))
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--case", default="", help="a case, or with --program its label")
    parser.add_argument("--program", default="", help="one pair: the name of a program")
    parser.add_argument("--method", default="", help="one pair: the method")
    parser.add_argument("--levels", type=int, default=LEVELS, help="of one pair")
    parser.add_argument("--most-steps", type=float, default=MOST_STEPS, help="of one pair")
    given = parser.parse_args()
    if given.program:
        count = repeated(given.case, given.program, given.method, given.levels, given.most_steps)
        print(count.summary())
        return int(bool(count.alarms))
    print(f"seed {given.seed}", flush=True)
    count = alarms(given.pairs, given.seed, given.seconds, given.case)
    print(count.summary())
    return int(bool(count.alarms))


if __name__ == "__main__":
    sys.exit(main())
