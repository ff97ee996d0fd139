"""Programs that run elsewhere: their requests are exported as folders, and the returned
trajectories are judged.

A folder holds a manifest, a copy of each refdem.toml, and one folder per run with request.json and
request.txt, in which its trajectory.csv (and events.csv) is to be put. The folder of a run is named
after its case, program, method and step. A run that continues from the end of another one needs
that one's trajectory, so that its request is written by a second export into the same folder.

A program that stays alive gets its requests as lines in a file NAME-requests.jsonl, whose ids are
the folders of the runs. Its answers may be returned in files *answers*.jsonl.
"""

import contextlib
import json
import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace as replaced
from pathlib import Path
from typing import Any, BinaryIO

import msgspec

import refdem
from refdem.core import discovery
from refdem.core.answer_csv import read_answer
from refdem.core.engine import Engine, Method
from refdem.core.finding import Sheet
from refdem.core.named_file import replace
from refdem.core.outside import in_file_name, one_line, opened
from refdem.core.problem import Motion, Request
from refdem.core.reading import content, json_as
from refdem.core.request_text import request_text
from refdem.core.sensitivities_csv import with_sensitivities
from refdem.core.store import Store
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.external import External
from refdem.engines.external.program import FILES
from refdem.engines.external.sense import NAME
from refdem.engines.external.serving import line_of
from refdem.errors import UNREADABLE, EngineError, StoreError, UnsupportedError, UsageError
from refdem.execution.schedule import Progress
from refdem.planning.campaign import Campaign
from refdem.planning.runs import RequestedRun
from refdem.planning.specification import Entry, Specification
from refdem.scene import bodies_file

MANIFEST = "manifest.json"
RUNS = "runs.txt"
ANSWERS = "*answers*.jsonl"
"""Names of the files with answers of programs that stay alive, one answer per line."""
REFUSED = "unsupported.txt"
"""The file in a run's folder, in place of a trajectory, with the reason of exit status 77 (not
supported).
"""
LAST_WORDS = 200
"""Most characters of a reason that are shown, the last ones."""
SHORT = 40
"""Most characters of the name of a program or method in the name of a run's folder."""
DIGITS = 16
"""Hexadecimal digits of a request's digest in the name of its folder: 64 bits, by which 1e5 runs
have equal names with a probability of 3e-10.
"""
FORMAT = 2
"""Version of the format of a manifest."""


class Manifest(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The content of an export: the version of refdem, the cases and levels to be judged, and the
    version of each program at that time.
    """

    format: int = FORMAT
    refdem: str
    case: list[Entry]
    levels: int
    versions: dict[str, str]


class Elsewhere(Engine):
    """A program that runs elsewhere, known here by its description and a folder for each run.

    `described` is the engine of its refdem.toml, from which the claims are taken. If `writes` is
    true, missing requests are written.
    """

    def __init__(self, described: Engine, version: str, folder: Path, *, writes: bool) -> None:
        """Takes over the description of an engine; `folder` is that of the export."""
        self.name = described.name
        self.title = described.title
        self.licence = described.licence
        self.methods = described.methods
        self.expected = described.expected
        self.may_refuse = described.may_refuse
        self.stays_alive = isinstance(described, External) and described.description.engine.serve
        self.described = described
        self.at = version
        self.folder = folder
        self.writes = writes
        self.labels: dict[str, str] = {}
        self.requests: Counter[str] = Counter()
        self.waiting: list[str] = []
        self.lines: list[str] = []
        self.answers = answers(folder)

    def missing(self) -> str | None:
        """None: the program runs elsewhere and need not be here."""
        return None

    def version(self) -> str:
        """The version of the program when it was exported."""
        return self.at

    def fingerprint(self, method: Method) -> str:
        """The name of the program: what runs elsewhere cannot be fingerprinted."""
        return self.name

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """The reason why the description of the program refuses the problem, or None."""
        return self.described.unsupported_motion(problem, method)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The returned trajectory of a request.

        Raises EngineError if it is missing or its request is not exported yet, and UnsupportedError
        if the folder has the reason why the program refused.
        """
        name = self._folder_of(request)
        folder = self.folder / name
        if folder.is_symlink():
            raise EngineError(f"{name} is a link; expected the folder that `refdem export` made")
        if not (folder / "request.json").is_file():
            if not self.writes:
                raise EngineError(
                    "this run goes on from another and is not exported yet; `refdem export` into"
                    " the same folder writes it"
                )
            written(request, folder)
        refused = opened(folder / REFUSED)
        if refused is not None:
            reason = _last_words(refused)
            raise UnsupportedError(reason or f"the program wrote {REFUSED}")
        answer = self.answers.get(name, {})
        if "unsupported" in answer:
            raise UnsupportedError(
                one_line(str(answer["unsupported"]))[-LAST_WORDS:] or "not supported"
            )
        if "failed" in answer:
            raise EngineError(f"{name} failed: {one_line(str(answer['failed']))[-LAST_WORDS:]}")
        if not any((folder / FILES[file]).is_file() for file in ("trajectory", "trajectory_npy")):
            self.waiting.append(name)
            paths = {file: f"{name}/{place}" for file, place in FILES.items()}
            self.lines.append(line_of(name, request.method, paths))
            raise EngineError(f"{name}/trajectory.csv is missing")
        trajectory = read_answer(request.problem, folder / "trajectory.csv", folder / "events.csv")
        trajectory = with_sensitivities(
            trajectory, folder / FILES["sensitivities"], request.sensitivities
        )
        if request.step:
            steps = request.stride * (len(request.problem.times) - 1)
        else:
            steps = 0
        return trajectory, Cost(seconds=0.0, steps=steps)

    def note(self, label: str, request: Request) -> None:
        """Notes the case of a request; one that several cases share keeps the first of them."""
        self.labels.setdefault(self._key(request), label)

    def _key(self, request: Request) -> str:
        """The key of a request, equal for its repetitions."""
        return replaced(request, repeat=0).key(self.name)

    def _folder_of(self, request: Request) -> str:
        """The name of the folder of the run of a request.

        An example is `pendulum-theta0=2_far_leapfrog_step=0.05_0f3c5a7e9b1d2468`.

        Labels that differ may read the same there, so the digest of the request is its end. Equal
        requests are numbered from 2 on.
        """
        key = self._key(request)
        words = [
            in_file_name(self.labels[key]),
            in_file_name(self.name, SHORT),
            in_file_name(request.method, SHORT),
        ]
        if request.step is not None:
            words.append(f"step={request.step:.6g}")
        if request.tolerance is not None:
            words.append(f"tolerance={request.tolerance:.6g}")
        name = "_".join([*words, key[:DIGITS]])
        self.requests[key] += 1
        if self.requests[key] > 1:
            name += f"-{self.requests[key]}"
        return name


def _last_words(file: BinaryIO) -> str:
    """The last 200 characters of a file, as one line; no more of it is read."""
    with file:
        end = file.seek(0, os.SEEK_END)
        file.seek(max(0, end - 4 * LAST_WORDS))
        return one_line(file.read().decode(errors="replace").strip()[-LAST_WORDS:])


def plain(path: Path) -> Path:
    """The path; raises UsageError if it is a link, a pipe or a device, since the folder was filled
    on another machine.
    """
    try:
        file = opened(path)
    except EngineError as error:
        raise UsageError(f"{path}: {error}") from None
    if file is not None:
        file.close()
    return path


def answers(folder: Path) -> dict[str, dict[str, Any]]:
    """The answers of programs that stay alive, by the folder of the run.

    Lines that are no answers are ignored, since only trajectories are judged.
    """
    found: dict[str, dict[str, Any]] = {}
    for path in sorted(folder.glob(ANSWERS)):
        for line in content(plain(path), "the lines that a program answered").splitlines():
            try:
                answer = json.loads(line)
            except UNREADABLE:
                continue
            if isinstance(answer, dict) and isinstance(answer.get("id"), str):
                found[answer["id"]] = answer
    return found


def written(request: Request, folder: Path) -> None:
    """Writes request.json and request.txt; raises StoreError if that cannot be done."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        replace(folder / "request.txt", request_text(request).encode())
        replace(folder / "request.json", request.to_json())
        file = request.bodies_file
        if file is not None:
            replace(folder / bodies_file.NAME, file)
    except OSError as error:
        raise StoreError(
            f"{folder} cannot be written: {error.strerror}; choose another folder"
        ) from None


def exported(
    folder: Path,
    tomls: Iterable[Path],
    cases: list[Entry],
    levels: int,
    store: Store,
    progress: Progress,
) -> list[str]:
    """Writes the requests that can be written now.

    Returns the names of the runs whose trajectories have not been returned yet.
    """
    engines = {path: discovery.engine(str(path)) for path in tomls}
    versions = {}
    for engine in engines.values():
        if engine.missing() is None:
            versions[engine.name] = engine.version()
        else:
            versions[engine.name] = "unknown"
    manifest = Manifest(refdem=refdem.__version__, case=cases, levels=levels, versions=versions)
    if os.path.lexists(folder / MANIFEST):
        # Another version of a program may go on with the same export.
        before = msgspec.structs.replace(read(folder), versions=versions)
        if before != manifest:
            raise UsageError(
                f"{folder} holds the export of other cases, programs or levels; choose an empty"
                " folder"
            )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, engine in engines.items():
            replace(folder / f"{engine.name}.toml", path.read_bytes())
        replace(folder / MANIFEST, msgspec.json.format(msgspec.json.encode(manifest)))
    except OSError as error:
        raise StoreError(
            f"{folder} cannot be written: {error.strerror}; choose another folder"
        ) from None
    _, elsewhere = _campaign(folder, manifest, store, progress, writes=True)
    waiting = [name for engine in elsewhere for name in engine.waiting]
    replace(folder / RUNS, "".join(f"{name}\n" for name in waiting).encode())
    for engine in elsewhere:
        if engine.stays_alive:
            text = "".join(f"{line}\n" for line in engine.lines)
            replace(folder / requests_of(engine.name), text.encode())
    return waiting


def requests_of(name: str) -> str:
    """The file with the requests to a program that stays alive, as lines."""
    return f"{name}-requests.jsonl"


def judged(folder: Path, store: Store, progress: Progress) -> list[Sheet]:
    """The findings on the trajectories in a folder; a missing trajectory is an error."""
    sheets, _ = _campaign(folder, read(folder), store, progress, writes=False)
    return sheets


def read(folder: Path) -> Manifest:
    """The manifest of an export; raises UsageError if there is none, or if another refdem wrote
    it.
    """
    path = plain(folder / MANIFEST)
    manifest = json_as(Manifest, content(path, "a folder that `refdem export` wrote"), str(path))
    if manifest.format != FORMAT:
        raise UsageError(f"{path} has format {manifest.format}; expected {FORMAT}: export again")
    if not manifest.case or not manifest.versions:
        missing = "case"
        if manifest.case:
            missing = "program"
        raise UsageError(f"{path} names no {missing}, so there is nothing to judge; export again")
    for name in manifest.versions:
        if not NAME.fullmatch(name):
            raise UsageError(
                f"{path}: {one_line(name, 80)!r} is not a valid name of a program; expected"
                " letters, digits and . _ + -"
            )
    if manifest.refdem != refdem.__version__:
        raise UsageError(
            f"{path} was written by refdem {manifest.refdem}, this is {refdem.__version__}; export"
            " again"
        )
    return manifest


def _campaign(
    folder: Path, manifest: Manifest, store: Store, progress: Progress, *, writes: bool
) -> tuple[list[Sheet], list[Elsewhere]]:
    """The campaign of an export in this process, and its programs, which record the missing
    trajectories.
    """
    names = list(manifest.versions)
    with contextlib.ExitStack() as here:
        engines = []
        for name in names:
            path = plain(folder / f"{name}.toml")
            described = discovery.engine(str(path))
            if described.name != name:
                raise UsageError(
                    f"{path} describes {described.name!r}; expected {name!r}, as {MANIFEST} says:"
                    " export again"
                )
            engine = Elsewhere(described, manifest.versions[name], folder, writes=writes)
            engines.append(engine)
            here.enter_context(discovery.engine_here(engine))
        by_name = {engine.name: engine for engine in engines}
        specification = Specification(
            name=f"judgement of {', '.join(names)}",
            case=manifest.case,
            engines=names,
            levels=manifest.levels,
        )

        def note(requested: RequestedRun) -> None:
            label = requested.task.subject.instance.label
            by_name[requested.task.engine.name].note(label, requested.request)

        campaign = Campaign(
            specification, store, jobs=0, use_store=False, progress=progress, on_request=note
        )
        sheets = campaign.sheets()
    return sheets, engines
