"""What is fuzzed: everything that refdem reads. Each input must be refused by one sentence of a
RefdemError, or give a right answer, which an independent look at the same bytes confirms.
"""

import contextlib
import csv
import io
import json
import math
import os
import sys
import tomllib
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

import fuzz_documents as documents
import msgspec

import refdem.cli
from refdem.core import discovery
from refdem.core.answer_csv import read_solids
from refdem.core.finding import CampaignSheet, EngineSheet, Finding, Level, Record, Series
from refdem.core.outside import one_line
from refdem.core.problem import Request, Solid
from refdem.core.sensitivities_csv import with_sensitivities
from refdem.core.store import Store
from refdem.core.trajectory_csv import read_trajectory
from refdem.engines.external import sense
from refdem.errors import RefdemError
from refdem.gate import baseline
from refdem.planning import deviations, exchange, required, specification
from refdem.report import read_records, write_report
from refdem.scene import Scene

ROOT = Path(__file__).parents[2]
CORPUS = ROOT / "tests" / "corpus"
LONGEST = 20_000
"""Characters of a sentence."""
ENTRIES = {f"key {number}": bytes([number]) * (50 * number) for number in range(1, 13)}
"""Of a store that is damaged."""
SAMPLES = 4
"""Rows that a correct trajectory file of the fuzzed program has; few keep a try short."""
ANNOUNCED = "the proof will take about"
"""What `refdem truth` says before it takes long."""


class WrongAnswerError(Exception):
    """Something broken was taken for good, or was refused without a sentence."""


@dataclass(frozen=True)
class Target:
    """One kind of input: good ones, and what judges any. `tree` has how its documents are read and
    written, where it has any.
    """

    name: str
    seeds: list[bytes]
    judge: Callable[[bytes, Path], None]
    tree: "tuple[Callable[[bytes], Any], Callable[[Any], bytes]] | None" = None
    weight: float = 1.0
    """Share of the inputs: less for what takes long."""
    corpus: list[bytes] = field(default_factory=list)

    def ends(self, data: bytes, folder: Path) -> str:
        """The sentence by which an input was refused, "" where the answer is right; raises
        WrongAnswerError, or whatever refdem raised that it should not have.
        """
        try:
            self.judge(data, folder)
        except RefdemError as error:
            sentence = str(error)
            if not sentence.strip() or len(sentence) > LONGEST or not one_line(sentence).strip():
                raise WrongAnswerError(f"no sentence, but {sentence[:200]!r}") from None
            return sentence
        return ""


def expect(holds: bool, what: str) -> None:
    """Raises WrongAnswerError if something does not hold."""
    if not holds:
        raise WrongAnswerError(what)


def kept(came: Any, went: Any, where: str = "") -> None:
    """Raises WrongAnswerError unless all that came in a document went into what was made of it."""
    if isinstance(came, dict):
        expect(isinstance(went, dict), f"{where} is {went!r}, and {came!r} came")
        for name, part in came.items():
            expect(name in went, f"{where}.{name} was ignored")
            kept(part, went[name], f"{where}.{name}")
    elif isinstance(came, list):
        expect(len(came) == len(went), f"{where} has {len(went)} of {len(came)} parts")
        for number, part in enumerate(came):
            kept(part, went[number], f"{where}.{number}")
    else:
        is_rounded = isinstance(came, int) and isinstance(went, float)
        if is_rounded and abs(came) <= sys.float_info.max:
            came = float(came)
        expect(came == went, f"{where} is {went!r}, and {came!r} came")


def all_finite(document: Any, where: str = "") -> None:
    """Raises WrongAnswerError for a number that is none."""
    if isinstance(document, dict):
        for name, part in document.items():
            all_finite(part, f"{where}.{name}")
    elif isinstance(document, (list, tuple)):
        for number, part in enumerate(document):
            all_finite(part, f"{where}.{number}")
    elif isinstance(document, float):
        expect(math.isfinite(document), f"{where} is {document}")


def plain(found: Any) -> Any:
    """What was read, as a document."""
    return msgspec.to_builtins(found)


# Scenes and requests -------------------------------------------------------------------------


def scene(data: bytes, _: Path) -> None:
    """A scene."""
    found = Scene.from_json(data)
    again = found.to_json()
    kept(json.loads(data), json.loads(again))
    all_finite(json.loads(again))
    expect(Scene.from_json(again).to_json() == again, "a scene that was written reads otherwise")


def request(data: bytes, _: Path) -> None:
    """A request."""
    found = Request.from_json(data)
    again = found.to_json()
    kept(json.loads(data), json.loads(again))
    all_finite(json.loads(again))


# Trajectories, events and solids -------------------------------------------------------------


def rows_of(data: bytes) -> list[list[str]]:
    """The cells of a CSV file, by another way than refdem's own; lines that are empty left out."""
    text = data.decode("utf-8", errors="replace")
    return [row for row in csv.reader(io.StringIO(text, newline="")) if row]


def number(cell: str) -> float:
    """A number as C or Fortran writes it."""
    return float(cell.strip().lower().replace("d", "e"))


def same(cells: list[str], values: list[float], where: str) -> None:
    """Raises WrongAnswerError unless cells hold the values."""
    for cell, value in zip(cells, values, strict=True):
        expect(math.isfinite(value), f"{where} has {value}")
        expect(number(cell) == value, f"{where} has {value!r} where the file has {cell!r}")


def trajectory(data: bytes, folder: Path) -> None:
    """A trajectory of two bodies."""
    path = folder / "trajectory.csv"
    path.write_bytes(data)
    found = read_trajectory(path, SAMPLES, 2)
    rows = rows_of(data)[1:]
    expect(len(rows) == 2 * SAMPLES, f"{len(rows)} rows were taken for {2 * SAMPLES}")
    for place, row in enumerate(rows):
        sample, body = divmod(place, 2)
        at = (sample, body)
        expect(number(row[1]) == body, f"row {place} is of another body")
        columns = [[found.t[sample]], found.position[at], found.velocity[at]]
        values = [float(value) for part in columns for value in part]
        same([row[0], *row[2:8]], values, f"row {place}")
        if any(cell.strip() for cell in row[8:15]):
            omega = [float(value) for value in found.omega[at]]
            same(row[12:15], omega, f"row {place}")
            attitude = [float(value) for value in found.attitude[at]]
            same(row[8:12], attitude, f"row {place}")


def derivatives(data: bytes, folder: Path) -> None:
    """Derivatives beside a good trajectory."""
    path = folder / "trajectory.csv"
    path.write_bytes(TRAJECTORY)
    beside = folder / "sensitivities.csv"
    beside.write_bytes(data)
    found = with_sensitivities(read_trajectory(path, SAMPLES, 2), beside, ASKED)
    rows = rows_of(data)[1:]
    expect(len(rows) == len(ASKED) * 2 * SAMPLES, f"{len(rows)} rows were taken")
    expect(tuple(found.derivatives) == ASKED, f"there are derivatives by {list(found.derivatives)}")
    for place, row in enumerate(rows):
        of_number, of_sample = divmod(place, 2 * SAMPLES)
        sample, body = divmod(of_sample, 2)
        key = ASKED[of_number]
        where = f"row {place}"
        expect(row[0].strip() == key, f"{where} is by {row[0]!r}, and {key} was asked for")
        late = abs(number(row[1]) - found.t[sample])
        expect(late <= 1e-9 * max(found.t), f"{where} is of another time")
        expect(number(row[2]) == body, f"{where} is of another body")
        slopes = [float(value) for value in found.derivatives[key][sample, body]]
        same(row[3:9], slopes[:6], where)
        if any(cell.strip() for cell in row[9:]):
            same(row[9:], slopes[6:], where)
        else:
            expect(not any(slopes[6:]), f"{where} turns where the file has nothing")


def events(data: bytes, folder: Path) -> None:
    """Events beside a good trajectory."""
    path = folder / "trajectory.csv"
    path.write_bytes(TRAJECTORY)
    beside = folder / "events.csv"
    beside.write_bytes(data)
    found = read_trajectory(path, SAMPLES, 2, beside)
    rows = rows_of(data)[1:]
    expect(len(rows) == len(found.events), f"{len(found.events)} of {len(rows)} events were read")
    for row, event in zip(rows, found.events, strict=True):
        same([row[0], row[2]], [event.time, float(event.body)], "an event")
        expect(event.kind == one_line(row[1], 40), f"the kind {row[1]!r} became {event.kind!r}")


def solids(data: bytes, folder: Path) -> None:
    """Mass properties of solids."""
    path = folder / "trajectory.csv"
    path.write_bytes(data)
    problem = discovery.case("moments-of-inertia").at().problem
    assert isinstance(problem, Solid)
    read_solids(path, problem)
    rows = rows_of(data)[1:]
    expect(len(rows) == len(problem.content.solids), f"{len(rows)} rows were taken")
    for row in rows:
        for cell in row[1:]:
            expect(not cell.strip() or math.isfinite(number(cell)), f"{cell!r} was taken")


# Files in TOML -------------------------------------------------------------------------------


def toml(name: str, read: Callable[[Path], Any]) -> Callable[[bytes, Path], None]:
    """A judge of a TOML file of a name."""

    def judge(data: bytes, folder: Path) -> None:
        path = folder / name
        path.write_bytes(data)
        found = plain(read(path))
        kept(tomllib.loads(data.decode()), found)
        all_finite(found)

    return judge


def campaign(path: Path) -> Any:
    """The campaign of a file, without the cases of others that it includes."""
    return specification.named(str(path))


def expected(path: Path) -> Any:
    """Deviations that an engine of this name is expected to have."""
    engine = discovery.engine("reference")
    home = path.parents[1]
    with mock.patch.object(deviations, "validation_folder", return_value=home):
        found = deviations.of_engine(engine)
    return {"expected": found}


def in_expected(data: bytes, folder: Path) -> None:
    """Expected deviations, in their folder."""
    (folder / "expected").mkdir(exist_ok=True)
    toml("expected/reference.toml", expected)(data, folder)


# Files that refdem wrote ---------------------------------------------------------------------


def manifest(data: bytes, folder: Path) -> None:
    """The manifest of an export."""
    (folder / exchange.MANIFEST).write_bytes(data)
    found = exchange.read(folder)
    kept(json.loads(data), plain(found))
    for name in found.versions:
        is_inside = (folder / f"{name}.toml").resolve().parent == folder.resolve()
        expect(is_inside, f"the program {name!r} is read from another folder")


def accepted(data: bytes, folder: Path) -> None:
    """A baseline, whose first line is made to fit the others: what follows is to be read."""
    path = folder / "refdem-baseline.jsonl"
    first, *others = data.splitlines() or [b""]
    document = None
    with suppress(ValueError, RecursionError):
        document = json.loads(first)
    if isinstance(document, dict):
        of_others = {"findings": len(others), "sha256": baseline.digest(others)}
        first = json.dumps(document | of_others | {"format": baseline.FORMAT}).encode()
    path.write_bytes(b"\n".join([first, *others]) + b"\n")
    header, found = baseline.read(path)
    lines = [json.loads(line) for line in [first, *others]]
    kept(lines[0], plain(header))
    expect(len(found) == len(lines) - 1, f"{len(found)} of {len(lines) - 1} findings were read")
    for line in lines[1:]:
        kept(line, plain(found[line["id"]]))
        all_finite(plain(found[line["id"]]))


def must_exist(data: bytes, folder: Path) -> None:
    """A list of the findings that a campaign must make."""
    path = folder / "reference.txt"
    path.write_bytes(data)
    found = required.read(path)
    for name in found:
        expect(name.count("/") >= 4, f"{name!r} is no finding")
        expect(name.isprintable(), f"{name!r} does not print")


def records(data: bytes, folder: Path) -> None:
    """Records, and the report that is made of them."""
    (folder / "records.jsonl").write_bytes(data)
    sheets = read_records(folder)
    lines = [line for line in data.splitlines() if line.strip()]
    expect(len(sheets) == len(lines), f"{len(sheets)} of {len(lines)} sheets were read")
    write_report(folder / "out", sheets)


def store(data: bytes, folder: Path) -> None:
    """A damaged store: an entry is what was put there, or none."""
    for path in folder.glob("store.sqlite*"):
        path.unlink()
    path = folder / "store.sqlite"
    path.write_bytes(data)
    with contextlib.redirect_stderr(io.StringIO()) as said:
        found = Store(path)
        for name, content in ENTRIES.items():
            read = found.get("run", name)
            expect(read is None or read == content, f"{name} has another content")
        found.put("run", "new", b"new")
        again = found.get("run", "new")
        expect(again in (None, b"new"), "what is put has another content")
        found.close()
    for line in said.getvalue().splitlines():
        expect(line.startswith("refdem: store "), f"it said {line!r}")


# Command lines: those that would run something end where the work begins ---------------------


@contextlib.contextmanager
def standing_in(folder: Path) -> Iterator[None]:
    """In a folder, with a store of its own there."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        with mock.patch.dict(os.environ, {"REFDEM_STORE": str(folder / "own.sqlite")}):
            yield
    finally:
        os.chdir(before)


WORK = [
    "refdem.planning.campaign.Campaign.sheets",
    "refdem.smoke.battery.smoke",
    "refdem.kills.trials.FaultTrial.matrix",
    "refdem.certification.proofs.Certification.run",
    "refdem.certification.reproof.contradictions",
    "refdem.cli.diagnose._trajectory",
    "refdem.bench.session.Bench.record",
    "refdem.bench.crowd.costs",
    "refdem.stress.session.Stress.record",
    "refdem.gallery.gallery.recorded",
    "refdem.manual.pages.pages",
]
"""What commands call when they have understood what is asked."""


class BegunError(BaseException):
    """A command was understood, and its work would begin."""


def begun(*_: object, **__: object) -> None:
    """In place of work."""
    raise BegunError


@contextlib.contextmanager
def without_work() -> Iterator[None]:
    """Commands are read, checked and not carried out."""
    with contextlib.ExitStack() as stack:
        for name in WORK:
            stack.enter_context(mock.patch(name, begun))
        yield


def command(data: bytes, folder: Path) -> None:
    """A command line, a word a line."""
    words = data.decode("utf-8", errors="surrogateescape").split("\n")
    # Neither the system nor a shell can hand over a NUL.
    words = [word.replace("\0", "") for word in words]
    out = io.StringIO()
    err = io.StringIO()
    status: Any = 0
    with contextlib.ExitStack() as stack:
        stack.enter_context(standing_in(folder))
        stack.enter_context(contextlib.redirect_stdout(out))
        stack.enter_context(contextlib.redirect_stderr(err))
        stack.enter_context(mock.patch.object(sys, "argv", ["refdem", *words]))
        stack.enter_context(without_work())
        try:
            refdem.cli.main()
        except SystemExit as end:
            status = end.code or 0
        except BegunError:
            print("begun")
    said = err.getvalue()
    expect("Traceback" not in said, said[-2000:])
    expect(status in (0, 2), f"status {status}: {said[-500:]}")
    if status:
        expect(bool(said.strip()), "refused without a word")
        raise RefdemError(said[:LONGEST])
    expect(bool(out.getvalue().strip()), "done without a word")


# Good inputs ---------------------------------------------------------------------------------


HEADER = b"t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz"
TRAJECTORY = HEADER + b"\n"
for _number in range(SAMPLES):
    _t = f"{_number / 2},".encode()
    TRAJECTORY += _t + b"0,1.5,0,0,-1.0,0.5,0,,,,,,,\n"
    TRAJECTORY += _t + b"1,2,3.25,0,0,1e-3,0,0.8,0.6,0,0,1,2,3\n"
WITH_CHANNEL = b"\n".join(
    line + (b",overlap" if number == 0 else b",0.5")
    for number, line in enumerate(TRAJECTORY.splitlines())
)
ASKED = ("scene.bodies.0.mass", "scene.elements.0.stiffness")
"""Numbers of the scene by which the fuzzed program differentiates."""
DERIVATIVES = b"number," + HEADER + b"\n"
for _key in ASKED:
    for _row in TRAJECTORY.splitlines()[1:]:
        DERIVATIVES += _key.encode() + b"," + _row + b"\n"
EVENTS = b"time,kind,body\n0.25,contact,0\n5D-1,release,1\n"
COMMANDS = [
    "list cases",
    "list engines --json",
    "list checks",
    "doctor",
    "schema toml",
    "explain pendulum --set theta0=2 --engine reference",
    "explain harmonic-oscillator[mass=2 gravity=1] --engine reference",
    "truth harmonic-oscillator --set mass=2 --at 1,5/2 --digits 20 --json",
    "truth coulomb-oscillator --set friction_force=0.2 --at 5/2",
    "truth --list",
    "truth pendulum --set theta0=2",
    "truth logistic --set eta=3.5",
    "truth two-spheres --set damping=1/2 --at 1",
    "truth moments-of-inertia",
    "report nowhere",
    "judge nowhere --out there",
    "export there harmonic-oscillator --engine refdem.toml --levels 3",
    "run --set theta0=2",
    "run pendulum --campaign nope",
    "run pendulm",
    "gate refdem.toml --bless",
    "bench pendulm --rounds 3",
    "stress --battery nope",
    "smoke nope",
    "certify --check nope",
    "certify --check pendulum --jobs 1",
    "run pendulum --engine reference --steps-per-tau 64 --jobs 2",
    "bench pendulum --engine reference --rounds 2 --crowd 100,200",
    "stress two-spheres --engine reference --battery frame",
    "gallery 1.15 --out there",
    "manual there",
    "faults --seeds 2 --fault friction",
    "diagnose pendulum/mujoco/euler --level 2",
    "diagnose nope",
    "--help",
]


def of_requests() -> list[bytes]:
    """A request of every kind of question that programs get, and some others."""
    found = []
    for name in ("harmonic-oscillator", "two-spheres", "pendulum", "free-rigid-body"):
        problem = discovery.case(name).at(samples="4").problem
        asked = Request(problem=problem, method="m", step=problem.interval / 4)
        found.append(asked.to_json())
    for name in ("logistic", "moments-of-inertia", "rotations", "phase-flow"):
        problem = discovery.case(name).at().problem
        found.append(Request(problem=problem, method="m").to_json())
    return [data for data in found if len(data) < 20_000]


def of_scenes() -> list[bytes]:
    """Scenes that together have most elements."""
    names = [
        "harmonic-oscillator",
        "two-spheres",
        "pendulum",
        "free-rigid-body",
        "coulomb-oscillator",
        "stick-slip",
        "block-on-slope",
        "heavy-top",
        "kapitza-pendulum",
        "asymmetric-field",
        "captured-mass",
        "double-pendulum",
        "wedge-collision",
        "pendulum-wheel-mass",
        "two-body-orbit",
        "dissipating-body",
        "van-der-pol",
    ]
    return [discovery.case(name).at().problem.scene.to_json() for name in names]


def of_solids() -> bytes:
    """A table that says what a program would."""
    problem = discovery.case("moments-of-inertia").at().problem
    assert isinstance(problem, Solid)
    rows = [f"{piece.name},1,0,0,0,1.5,2,3,0,0,," for piece in problem.content.solids]
    head = "solid,mass,x,y,z,xx,yy,zz,xy,xz,yz"
    return "\n".join([head, *(row.rstrip(",") + "," for row in rows)]).encode() + b"\n"


def of_store(folder: Path) -> bytes:
    """The bytes of a store with ENTRIES in it."""
    path = folder / "seed.sqlite"
    found = Store(path)
    for name, content in ENTRIES.items():
        found.put("run", name, content)
    found.close()
    return path.read_bytes()


def of_records() -> list[bytes]:
    """A record and what goes with it, of each kind of sheet."""
    curve = Series(t=[0.0, 1.0], value=[0.0, 1e-12], bound=[1e-10, 1e-10])
    level = Level(level=0.5, error=1e-9, bound=1e-6, seconds=0.25, counts=True)
    finding = Finding(
        check="error",
        quantity="x",
        outcome="pass",
        sentence="It holds.",
        value=1e-12,
        bound=1e-10,
        basis="round-off",
        levels=(level,),
        series=curve,
        order_seen=2.0,
    )
    record = Record(
        case="pendulum",
        label="pendulum[theta0=2]",
        parameters={"theta0": "2"},
        engine="small",
        version="1.0",
        method="rk4",
        is_reference=False,
        runs=("0123",),
        findings=(finding,),
    )
    engine = EngineSheet(
        engine="small",
        title="Small",
        version="1.0",
        licence="BSD",
        is_reference=False,
        methods={"rk4": "Runge and Kutta"},
        audit=(("a", "b", "c", "d"),),
    )
    whole = CampaignSheet(name="own", refdem="0.1.0", runs_made=1, runs_read=0, seconds=0.5)
    sheets = [msgspec.json.encode(sheet) for sheet in (record, engine, whole)]
    return [b"\n".join(sheets) + b"\n"]


MANIFEST = {
    "format": exchange.FORMAT,
    "refdem": refdem.__version__,
    "case": [{"id": "pendulum", "set": {"theta0": "2"}}],
    "levels": 4,
    "versions": {"small": "1.0"},
}
BASELINE = (
    b'{"format":1,"engine":"small","version":"1.0","why":"first"}\n'
    b'{"id":"pendulum[theta0=2]/small/rk4/error/x","outcome":"pass","value":1e-9,"constant":0.5}\n'
    b'{"id":"pendulum/small/rk4/order/x","outcome":"fail","value":3.5,"constant":null}\n'
)
CAMPAIGN = b"""name = "own"
engines = ["reference"]
levels = 3
most_steps = 1e5
timeout = 20.0
[[case]]
id = "pendulum"
set = {theta0 = "2"}
[[case]]
id = "harmonic-oscillator"
"""
EXPECTED = b"""[[expected]]
case = "pendulum"
parameters = "theta0=2"
method = "rk4"
check = "error"
quantity = "*"
versions = "4.*"
low = 1e-9
high = 1.0
reason = "it is known"
link = "https://example.org"
"""
LISTED = b"""# What must be decided.
pendulum[theta0=2]/rk4
  error: theta, omega
  order: theta
harmonic-oscillator/rk4
  error: x
"""
DESCRIPTION = b"""[engine]
name = "small"
command = ["python3", "small.py", "{request}", "{trajectory}"]
inputs = ["small.py"]
supports = ["spring", "dimension:1"]
timeout = 60.0
memory = 2.0
[[engine.methods]]
name = "rk4"
order = 4
conserves = ["momentum"]
order_with = {contact = 1}
[gate]
cases = ["harmonic-oscillator[mass=2]"]
levels = 4
[[expected]]
case = "harmonic-oscillator"
method = "rk4"
check = "error"
quantity = "x"
versions = "*"
low = 0.0
high = 1.0
reason = "known"
"""


def targets(folder: Path) -> list[Target]:
    """All of them, with the corpus of each."""
    json_tree = (documents.from_json, documents.as_json)
    toml_tree = (documents.from_toml, documents.as_toml)
    lines = [" ".join(words.split()).replace(" ", "\n").encode() for words in COMMANDS]
    lines = [line.replace(b"[mass=2\n", b"[mass=2 ") for line in lines]
    manifests = [json.dumps(MANIFEST).encode()]
    inputs = [
        Target("scenes", of_scenes(), scene, json_tree),
        Target("requests", of_requests(), request, json_tree),
    ]
    answers = [
        Target("trajectories", [TRAJECTORY, WITH_CHANNEL], trajectory),
        Target("derivatives", [DERIVATIVES], derivatives),
        Target("events", [EVENTS], events),
        Target("solids", [of_solids()], solids),
    ]
    settings = [
        Target("descriptions", [DESCRIPTION], toml("refdem.toml", sense.read), toml_tree),
        Target("campaigns", [CAMPAIGN], toml("own.toml", campaign), toml_tree),
        Target("deviations", [EXPECTED], in_expected, toml_tree),
    ]
    kept = [
        Target("manifests", manifests, manifest, json_tree),
        Target("baselines", [BASELINE], accepted),
        Target("lists", [LISTED], must_exist),
        Target("records", of_records(), records, weight=0.02),
        Target("stores", [of_store(folder)], store, weight=0.1),
    ]
    commands = [Target("commands", lines, command, weight=0.03)]
    found = inputs + answers + settings + kept + commands
    for target in found:
        place = CORPUS / target.name
        if place.is_dir():
            target.corpus.extend(path.read_bytes() for path in sorted(place.iterdir()))
    return found
