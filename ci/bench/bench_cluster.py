"""Runs a second through a cluster of this machine, and what passing a run on costs.

usage: python ci/bench/bench_cluster.py [--runs N] [--workers N] [--turns N]

The runs are as short as they can be: two samples of a harmonic oscillator. The same runs are made
in this process, in worker processes of the schedule, and in workers of Dask with one thread each,
in turns, so that a busy moment falls on all of them; medians are printed.
"""

import argparse
import statistics
import time

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.execution import remote, worker
from refdem.execution.cluster import Cluster
from refdem.execution.schedule import InProcess, Job, Schedule, Scheduler

LIMIT = 60.0
"""Seconds a run; none takes a hundredth of one."""
WARM = 500
"""Runs before the clock starts: processes start and import the engine."""
FEWER = 20
"""Times fewer runs are made outside of the cluster, where a run costs the same however many."""


def request() -> bytes:
    """Packed, the shortest run that an engine steps through."""
    instance = discovery.case("harmonic-oscillator").at(samples="2", duration="1")
    asked = Request(problem=instance.problem, method="velocity-verlet", step=0.25)
    return asked.packed()


def jobs(number: int) -> list[Job]:
    """So many runs, all the same: nothing here looks at what they are."""
    arguments = ("reference", request(), float("inf"))
    return [Job(key, worker.run, arguments, computes=True) for key in range(number)]


def seconds_of(schedule: Scheduler, asked: list[Job]) -> tuple[float, float]:
    """Seconds by the clock, and of CPU time of this process, that a schedule takes for jobs."""
    start = time.perf_counter()
    start_here = time.process_time()
    made = sum(1 for _, result in schedule.results(asked) if isinstance(result, bytes))
    assert made == len(asked)
    return time.perf_counter() - start, time.process_time() - start_here


def main() -> None:
    """Prints a line for each way to make the runs."""
    from distributed import LocalCluster

    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=100_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--turns", type=int, default=5)
    arguments = parser.parse_args()
    workers = arguments.workers
    in_cluster = jobs(arguments.runs // arguments.turns)
    elsewhere = in_cluster[: len(in_cluster) // FEWER]
    expected = remote.code_state([discovery.engine("reference")])
    with (
        LocalCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address=":0"
        ) as local_cluster,
        Cluster(local_cluster.scheduler_address, expected, LIMIT, Schedule(1, LIMIT)) as cluster,
        Schedule(workers, LIMIT) as schedule,
    ):
        ways: list[tuple[str, Scheduler, int, list[Job]]] = [
            ("this process", InProcess(), 1, elsewhere),
            (f"{workers} worker processes", schedule, workers, elsewhere),
            (f"{workers} workers of Dask", cluster, workers, in_cluster),
        ]
        seconds: dict[str, list[tuple[float, float]]] = {name: [] for name, *_ in ways}
        for _, way, _, _ in ways:
            seconds_of(way, jobs(WARM))
        for _ in range(arguments.turns):
            for name, way, _, asked in ways:
                seconds[name].append(seconds_of(way, asked))
    for name, _, processes, asked in ways:
        passed = statistics.median(clock for clock, _ in seconds[name]) / len(asked)
        here = statistics.median(cpu for _, cpu in seconds[name]) / len(asked)
        print(
            f"{name:20s} {1 / passed:6.0f} runs/s; a run takes {1e3 * processes * passed:6.3f} ms"
            f" of a worker, and {1e3 * here:6.3f} ms of CPU in the process that asks"
        )


if __name__ == "__main__":
    main()
