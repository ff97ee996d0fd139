"""The functions that a worker process runs: one truth or one run, with bytes as input and output.
An exception of an engine becomes a Failure.
"""

import contextlib
import math
import os
import time
from collections.abc import Iterator
from fractions import Fraction

import msgspec

from refdem.core import discovery
from refdem.core.engine import Engine, ProgramEngine, Stages, finished
from refdem.core.outside import one_line
from refdem.core.problem import Request
from refdem.core.run import Failure
from refdem.core.trajectory import Cost, Trajectory
from refdem.core.truth import Ball, SampledTruth, Truth
from refdem.errors import (
    HangError,
    LeakError,
    NotCertifiedError,
    RefdemError,
    UnsupportedError,
)

COUNT_BYTES = 4
"""Bytes of a number of certified times."""


class Reply(msgspec.Struct, frozen=True, kw_only=True):
    """Exactly one of a packed trajectory (with its cost) and a failure."""

    # Decoded, it is a view of the bytes of the reply: a copy of them may be 50 MB.
    trajectory: memoryview = memoryview(b"")
    cost: Cost | None = None
    failure: Failure | None = None

    def unpacked(self) -> Trajectory | None:
        """The trajectory, unless the run failed; raises ValueError for bytes that are none."""
        if self.failure is not None:
            return None
        return Trajectory.from_bytes(self.trajectory)


def sampled_truth(
    case: str,
    given: dict[str, str],
    delays: tuple[float, ...] = (),
    most: int | None = None,
    counter: tuple[str, int] | None = None,
) -> bytes:
    """The truth of an instance at its samples, and `delays` [s] before them, as MessagePack of
    SampledTruth.

    If nothing is certified, `until` is 0 and `reason` states why. `most` limits the number of
    samples; there are then no scalars. `counter` is (path, row) of a file into which the number of
    certified samples is written during the proof, in case this process is killed.
    """
    from refdem.truth.balls import UndecidedError
    from refdem.truth.sampled import sampled

    instance = discovery.case(case).at(**given)
    times = instance.times.tolist()
    proof = instance.truth()
    try:
        with contextlib.ExitStack() as stack:
            if counter:
                stack.enter_context(telling(proof, *counter))
            if most is not None:
                # Scalars may depend on an end that the proof did not reach.
                vars(proof)["scalars"] = dict[str, Ball]
            truth = sampled(proof, times[:most], delays)
        truth = msgspec.structs.replace(truth, t=times)
    except (NotCertifiedError, UndecidedError) as error:
        truth = no_truth(str(error))
    return msgspec.msgpack.encode(truth)


def no_truth(reason: str) -> SampledTruth:
    """An empty truth, certified nowhere, with the reason."""
    return SampledTruth(
        t=[],
        values={},
        radii={},
        sensitivity=[],
        scalars={},
        method="not certified",
        witness="",
        until=0,
        reason=reason,
    )


@contextlib.contextmanager
def telling(proof: Truth, place: str, row: int) -> Iterator[None]:
    """Within this context the number of times that `proof` has certified so far is kept up to date
    in a row, of COUNT_BYTES, of the file `place`.
    """
    try:
        file = os.open(place, os.O_WRONLY)
    except OSError:
        # Without /proc the number is not stored, and the samples of a killed proof are lost.
        yield
        return
    original = proof.sensitivity
    latest = Fraction(-1)
    count = 0

    def sensitivity(t: Fraction) -> float:
        """S(t), unchanged; each time later than all previous ones counts as one more certified."""
        nonlocal latest, count
        bound = original(t)
        if t > latest:
            latest = t
            count += 1
            os.pwrite(file, count.to_bytes(COUNT_BYTES, "little"), COUNT_BYTES * row)
        return bound

    # S is the last value computed at a sample, so that the wrapper counts completed samples. It is
    # set on this object only.
    vars(proof)["sensitivity"] = sensitivity
    try:
        yield
    finally:
        del vars(proof)["sensitivity"]
        os.close(file)


def run(engine: str, request: bytes, deadline: float = math.inf) -> bytes:
    """One run of an engine, as MessagePack of Reply; it is not started after the deadline [s] of
    the monotonic clock.
    """
    return finished(stages(engine, request, deadline))


def stages(engine: str, request: bytes, deadline: float = math.inf) -> Stages[bytes]:
    """The run in stages, so that other runs may proceed while it waits for its program."""
    # The monotonic clock is the same in all processes of the system.
    if time.monotonic() > deadline:
        failure = Failure(
            kind="budget",
            sentence=(
                "the time budget of the campaign was spent; raise engine.budget or run fewer cases"
            ),
        )
        return msgspec.msgpack.encode(Reply(failure=failure))
    return msgspec.msgpack.encode((yield from reply_of(engine, Request.unpacked(request))))


def reply_of(address: str, request: Request, engine: Engine | None = None) -> Stages[Reply]:
    """The reply to a request; the only place where exceptions of an engine become a Failure.

    An `engine` that is given need not be discoverable.
    """
    try:
        runner = engine or discovery.engine(address)
        if isinstance(runner, ProgramEngine):
            trajectory, cost = yield from runner.stages(request)
        else:
            trajectory, cost = runner.run(request)
        request.refuse_misaligned(trajectory.t, runner.method(request.method).round_off)
    except UnsupportedError as error:
        return Reply(failure=Failure(kind="unsupported", sentence=one_line(str(error))))
    except HangError as error:
        return Reply(failure=Failure(kind="hang", sentence=one_line(str(error))))
    except LeakError as error:
        return Reply(failure=Failure(kind="leak", sentence=one_line(str(error))))
    except RefdemError as error:
        return Reply(failure=Failure(kind="contract", sentence=one_line(str(error))))
    except Exception as error:
        sentence = one_line(f"{address} raised {type(error).__name__}: {error}")
        return Reply(failure=Failure(kind="exception", sentence=sentence))
    return Reply(trajectory=memoryview(trajectory.to_bytes()), cost=cost)
