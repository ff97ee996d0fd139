"""Peak memory of a run, measured in a separate process."""

import multiprocessing
from collections.abc import Sequence
from pathlib import Path

from refdem.bench.peers import peers
from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.core.problem import Request

STATUS = Path("/proc/self/status")
RESET = Path("/proc/self/clear_refs")


def peaks(runs: Sequence[tuple[str, bool, Request, Request]]) -> list[int | None]:
    """Bytes by which each finest run lifts the peak of resident memory, after the coarsest has
    loaded everything.

    Each run is (address of the engine, is it a peer, coarsest request, finest request). The result
    is None where the system does not report the peak, or the run fails.
    """
    jobs = [(engine, peer, coarse.packed(), fine.packed()) for engine, peer, coarse, fine in runs]
    if not jobs or not RESET.exists():
        return [None] * len(jobs)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        bytes_lifted: list[int | None] = pool.starmap(_peak, jobs, chunksize=1)
    return bytes_lifted


def _peak(name: str, is_peer: bool, coarse: bytes, fine: bytes) -> int | None:
    """Bytes by which the fine run lifts the peak of this process; None if a run fails."""
    engine: Engine
    if is_peer:
        engine = next(peer for peer in peers() if peer.name == name)
    else:
        engine = discovery.engine(name)
    try:
        engine.run(Request.unpacked(coarse))
        request = Request.unpacked(fine)
        reset_peak()
        before = resident("VmRSS")
        engine.run(request)
    except Exception:  # the failure of a run is reported in its curve
        return None
    return max(0, resident("VmHWM") - before)


def reset_peak() -> None:
    """Resets the peak memory of this process to its current memory (Linux, proc(5))."""
    RESET.write_text("5")


def resident(field: str) -> int:
    """A field of this process's status [bytes]: VmRSS is what it holds, VmHWM its peak."""
    line = next(line for line in STATUS.read_text().splitlines() if line.startswith(field))
    return 1024 * int(line.split()[1])
