"""A program that stays alive (`serve = true`) as an engine: each request has its own folder.

Some requests are repeated, in a fresh process and in another order, to detect state that the
program keeps between requests.
"""

import os
from collections import defaultdict
from contextlib import suppress
from pathlib import Path

from refdem.core.answer_csv import read_answer
from refdem.core.engine import Stages
from refdem.core.outside import put_new
from refdem.core.problem import Request
from refdem.core.sensitivities_csv import with_sensitivities
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.external.folders import run_folder
from refdem.engines.external.leaks import Answer, Sample, difference, words
from refdem.engines.external.program import Program, most_bytes, steps_of, written
from refdem.engines.external.serving import Exchange, Identity, Reply, ServedLimits, WrittenRequest
from refdem.errors import EngineError, LeakError, UnsupportedError

BEFORE = "request-before.json"
"""Beside the files of a failed run: the other request, which changes the answer to this one."""
KEEPS = "keeps state from one request to the next"
ADVICE = "Reset all state at each request, or remove `serve`"
_SAMPLES: defaultdict[tuple[Identity, str], Sample] = defaultdict(Sample)
"""The samples of each method of each program that stays alive, in this process."""


class ServedProgram(Program):
    """The program of an engine table with `serve = true`."""

    def _stages(self, request: Request, folder: Path) -> Stages[tuple[Trajectory, Cost]]:
        """Yields the exchange with the program that stays alive, and reads its answer; repeats some
        requests.
        """
        identity = self._identity()
        sample = _SAMPLES[identity, request.method]
        if sample.leak:
            # Its answers depend on earlier requests, so that no further one can be judged.
            raise LeakError(f"{sample.leak}; nothing more was asked of this method")
        written_request = self._written_request(request, folder)
        exchange = Exchange(self.table.name, self._command(), identity, [written_request])
        result = yield exchange.made
        result()
        (reply,) = exchange.replies
        # The program still runs, and may have taken the name: then its output is not shown.
        with suppress(EngineError):
            put_new(folder / "stderr.txt", reply.messages.encode(errors="replace"))
        answer = answered(written_request, reply)
        if self._is_deterministic(request.method):
            if sample.takes(request, reply.before):
                yield from self._compared_with_fresh(written_request, answer, reply, sample)
                sample.keep(request, answer)
            elif sample.earlier is None:
                sample.keep(request, answer)
        if answer.trajectory is None:
            raise UnsupportedError(answer.refusal)
        cost = Cost(seconds=reply.seconds, setup=reply.setup, steps=steps_of(request))
        return answer.trajectory, cost

    def _compared_with_fresh(
        self, written_request: WrittenRequest, answer: Answer, reply: Reply, sample: Sample
    ) -> Stages[None]:
        """Repeats the request in a fresh process, and then an earlier one, in reverse order.

        Raises EngineError if either answer differs from the one that was given before.
        """
        before = reply.before
        # Other runs go on while this one waits, and keep others in the sample.
        kept_earlier = sample.earlier
        again = yield from self._fresh(written_request.request, kept_earlier)
        name = self.table.name
        place = written_request.paths["request"].with_name(BEFORE)
        differs = difference(answer, again[0])
        if differs and before is not None:
            twice = yield from self._fresh(written_request.request, None)
            changing = difference(again[0], twice[0])
            if changing:
                raise EngineError(
                    f"{name} answers one request differently in two fresh processes: {changing};"
                    " expected the same bits, or deterministic = false of the method"
                )
            put_new(place, before.to_json())
            sample.leak = (
                f"{name} {KEEPS}: asked after another request, and then in a fresh process,"
                f" {differs}. The request before it: {words(before)} ({BEFORE}). {ADVICE}"
            )
            raise LeakError(sample.leak)
        if kept_earlier is None:
            return
        earlier, first_answer = kept_earlier
        differs = difference(first_answer, again[1])
        if differs:
            put_new(place, earlier.to_json())
            sample.leak = (
                f"{name} {KEEPS}: another request ({words(earlier)}; {BEFORE}) was asked again"
                f" after this one, in a fresh process, and was answered otherwise: {differs}."
                f" {ADVICE}"
            )
            raise LeakError(sample.leak)

    def _fresh(
        self, request: Request, earlier: tuple[Request, Answer] | None
    ) -> Stages[list[Answer]]:
        """The answers of a fresh process to a request, and to an `earlier` one after it."""
        name = self.table.name
        with run_folder(name) as first, run_folder(name) as second:
            requests = [self._written_request(request, first)]
            if earlier is not None:
                requests.append(self._written_request(earlier[0], second))
            exchange = Exchange(
                self.table.name, self._command(), self._identity(), requests, is_fresh=True
            )
            result = yield exchange.made
            try:
                result()
                pairs = zip(requests, exchange.replies, strict=True)
                return [answered(one, reply) for one, reply in pairs]
            except EngineError as error:
                which = "this request, asked again in a fresh process"
                if exchange.replies and len(requests) > 1:
                    which = "another request, asked again after this one in a fresh process"
                raise type(error)(f"{which}: {error}") from None

    def _written_request(self, request: Request, folder: Path) -> WrittenRequest:
        """A request whose files are written into its folder."""
        table = self.table
        limits = ServedLimits(
            timeout=table.timeout,
            file_bytes=most_bytes(request),
            memory=self.memory(),
            start_timeout=table.start_timeout,
            warm_up=table.warm_up,
        )
        return WrittenRequest(request=request, paths=written(request, folder), limits=limits)

    def _command(self) -> list[str]:
        """The command of a program that stays alive."""
        return [self.placed(word) for word in self.table.command]

    def _identity(self) -> Identity:
        """The state of the program; if it changes, a process of the old one is not used again."""
        stats: list[object] = []
        for path in [self.description, *self.files()]:
            with suppress(OSError):
                status = os.stat(path)
                stats.append((str(path), status.st_mtime_ns, status.st_size, status.st_ino))
        return (*self._command(), *stats)

    def _is_deterministic(self, name: str) -> bool:
        """Whether a method claims the same bits for the same request."""
        return any(method.deterministic for method in self.table.methods if method.name == name)


def answered(written_request: WrittenRequest, reply: Reply) -> Answer:
    """The answer of a program that stays alive; raises EngineError for a malformed trajectory."""
    if reply.answer == "unsupported":
        reason = reply.reason or "the program answers that the scene is not supported"
        return Answer(trajectory=None, refusal=reason)
    paths = written_request.paths
    problem = written_request.request.problem
    trajectory = read_answer(problem, paths["trajectory"], paths["events"])
    requested = written_request.request.sensitivities
    return Answer(trajectory=with_sensitivities(trajectory, paths["sensitivities"], requested))
