"""Any program that a refdem.toml describes: requests go in as files, trajectories come back as
files.
"""

import hashlib
import os
from functools import cached_property
from pathlib import Path

from refdem.core import codes, fingerprint
from refdem.core.engine import Default, Method, ProgramEngine, Stages
from refdem.core.outside import one_line
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.external.description import AuditTable, Description, EngineTable
from refdem.engines.external.features import DIMENSIONS, IMPLIED
from refdem.engines.external.program import Program
from refdem.engines.external.sense import read
from refdem.engines.external.served_program import ServedProgram


class External(ProgramEngine):
    """The program described by the refdem.toml at `path`."""

    licence = "its own"

    def __init__(self, path: Path) -> None:
        self.path = path.resolve()
        self.description: Description = read(self.path)
        table = self.description.engine
        self.name = self.title = table.name
        self.methods = tuple(method.method(table) for method in table.methods)
        self.time_limit = longest(table)
        self.budget = table.budget
        self.expected = tuple(self.description.expected)
        self.audit = tuple(audited(line) for line in self.description.audit)
        self.may_refuse = frozenset(table.may_refuse)
        kind = Program
        if table.serve:
            kind = ServedProgram
        self.program = kind(table, self.path)

    @property
    def address(self) -> str:
        """The path of its refdem.toml."""
        return str(self.path)

    def missing(self) -> str | None:
        """None if the program is there, else what to do."""
        reason = self.program.missing()
        if reason is None:
            return None
        return reason + codes.advice(self.path)

    @cached_property
    def _version(self) -> str:
        return self.program.version() or f"files {self.fingerprint(self.methods[0])[:12]}"

    def version(self) -> str:
        """The output of its version command, or part of the digest of its files.

        It is computed once, at the first call, because a run may change or delete the files.
        """
        return self._version

    def fingerprint(self, method: Method) -> str:
        """sha256 of refdem.toml, every file that the command names, every file that `inputs`
        matches, and the machine.
        """
        digest = hashlib.sha256(fingerprint.of_files([self.path]).encode())
        for file in self.program.files():
            digest.update(os.fsencode(f"{file}\0{fingerprint.of_files([file])}"))
        source = fingerprint.of_source(
            "engines/external",
            "core/request_text.py",
            "core/trajectory_csv.py",
            "core/trajectory_npy.py",
            "core/answer_csv.py",
            "core/sensitivities_csv.py",
            "core/static_problems.py",
            "scene",
        )
        digest.update(f"{source}\0{fingerprint.of_machine()}".encode())
        return digest.hexdigest()

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None, or the feature of the scene that `supports` does not name."""
        if problem.interval < 0 and not method.backward:
            return "negative steps"
        supports = set(self.description.engine.supports)
        needs = problem.scene.features
        if problem.scene.has_bodies_file:
            needs = needs | {"bodies_file"}
        if supports & DIMENSIONS:
            anywhere = set()
        else:
            anywhere = DIMENSIONS
        missing = sorted(needs - IMPLIED - anywhere - supports)
        if missing:
            return f"{', '.join(missing)} (not in `supports` of {self.path.name})"
        return None

    def stages(self, request: Request) -> Stages[tuple[Trajectory, Cost]]:
        """One run in an empty folder of its own."""
        return self.program.stages(request)


def audited(line: AuditTable) -> Default:
    """A line of the audit of defaults, of printable words."""
    return Default(
        setting=one_line(line.setting),
        default=one_line(line.default),
        used=one_line(line.used),
        why=one_line(line.why),
    )


def longest(table: EngineTable) -> float:
    """The longest time [s] that a run may take.

    A program that stays alive may have to be started for the run. It is started again for two
    repeated requests, those of this run and of an earlier one.
    """
    if not table.serve:
        return table.timeout
    request = table.warm_up + table.timeout
    # If the answers differ, a third process shows whether any two processes differ.
    return 3 * table.start_timeout + 4 * request


def load(path: Path) -> External:
    """The program that a refdem.toml describes; raises UsageError if the file is not well
    formed.
    """
    return External(path)
