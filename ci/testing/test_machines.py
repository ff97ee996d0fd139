"""Runs the tests as other machines would: `make test-machines`.

usage: ci/testing/test_machines.py [--only NAME...] [--jobs N] [PATH...]

Other code paths of OpenBLAS, numpy, the C library and the kernels; a busy machine; another order;
other seeds. It also watches how close every comparison with a small tolerance comes to it
(margins.py): a tolerance about rounding has a factor of 10 of room above what was seen in any of
these runs, and a line that cannot have it says why in a comment, `# sharp: <reason>`.
"""

import argparse
import ctypes
import json
import linecache
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOM = 10.0
"""A tolerance is at least so many times what was measured."""
SHARP = "# sharp: "
BUSY = 8
"""Processes that compute beside the tests."""
TESTS = (
    "kernels",
    "solvers",
    "mechanics",
    "scene",
    "core",
    "cases",
    "checks",
    "engines",
    "faults",
    "bench",
    "stress",
    "execution",
    "planning",
    "smoke",
    "certification",
    "truth",
    "cli",
    "properties",
    "attacks",
    "by_hand",
)
"""Folders of tests whose numbers, or whose time, could depend on the machine."""


@dataclass(frozen=True)
class Machine:
    """One other machine: its environment variables, options of pytest, which kernels it runs, what
    its processor must have.
    """

    name: str
    environment: dict[str, str] = field(default_factory=dict)
    options: tuple[str, ...] = ()
    kernels: str = ""
    needs: tuple[str, ...] = ()
    is_busy: bool = False


def machines(seed: int) -> list[Machine]:
    """All of them; the seed is of those that take another order or other numbers."""
    v3 = ("avx2", "fma")
    v4 = ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl")
    found = [Machine("as-it-is")]
    for core, needs in (("Nehalem", ()), ("Haswell", v3), ("Zen", v3), ("SkylakeX", v4)):
        found.append(Machine(f"openblas-{core}", {"OPENBLAS_CORETYPE": core}, needs=needs))
    for name, words in (
        ("avx512", ("AVX512", "X86_V4")),
        ("avx2", ("AVX512", "X86_V4", "AVX2", "FMA3", "X86_V3")),
    ):
        found.append(
            Machine(f"numpy-without-{name}", {"NPY_DISABLE_CPU_FEATURES": disabled(words)})
        )
    without_fma = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX512F"
    found.append(Machine("libm-without-fma", {"GLIBC_TUNABLES": without_fma}))
    for kernels, needs in (("x86-64", ()), ("x86-64-v3", v3), ("x86-64-v4", v4)):
        found.append(Machine(f"kernels-{kernels}", kernels=kernels, needs=needs))
    found.append(Machine("busy", is_busy=True))
    found.append(Machine("random-order", options=("-p", "randomly", f"--randomly-seed={seed}")))
    other = {"REFDEM_SEED": str(seed), "PYTHONHASHSEED": str(seed % 2**32)}
    found.append(
        Machine(
            "another-seed",
            other,
            ("--hypothesis-profile=another-seed", f"--hypothesis-seed={seed}"),
        )
    )
    return found


def disabled(words: tuple[str, ...]) -> str:
    """Features that numpy chooses among when it is loaded, of those named by these words, that this
    processor has.
    """
    from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

    return " ".join(
        name for name in __cpu_dispatch__ if name.startswith(words) and __cpu_features__.get(name)
    )


def lacking(machine: Machine) -> list[str]:
    """What this processor lacks for it."""
    flags = set(Path("/proc/cpuinfo").read_text().split())
    return [name for name in machine.needs if name not in flags]


def tree_with(kernels: str) -> Path:
    """A copy of the package whose kernels were built for one kind of processor alone."""
    folder = ROOT / "build" / f"kernels-{kernels}"
    arguments = [f"-Dc_args=-DREFDEM_ONE_CPU={kernels}"]
    if not (folder / "build.ninja").exists():
        subprocess.run(
            ["meson", "setup", str(folder), *arguments],
            cwd=ROOT,
            check=True,
            stdout=subprocess.DEVNULL,
        )
    subprocess.run(
        ["meson", "compile", "-C", str(folder)], cwd=ROOT, check=True, stdout=subprocess.DEVNULL
    )
    tree = ROOT / "build" / f"tree-{kernels}"
    shutil.rmtree(tree, ignore_errors=True)
    without_kernels = shutil.ignore_patterns("*.so", "__pycache__")
    for package in ("refdem", "validation"):
        shutil.copytree(ROOT / package, tree / package, ignore=without_kernels)
    for made in folder.glob("_*.so"):
        shutil.copy(made, tree / "refdem" / "kernels")
    return tree


@contextmanager
def busy(processes: int) -> Iterator[None]:
    """So many processes compute meanwhile; they end with whoever started them."""
    dies_with_us = ctypes.CDLL(None).prctl
    command = [sys.executable, "-c", "while True: pass"]
    started = [
        subprocess.Popen(command, preexec_fn=lambda: dies_with_us(1, 9)) for _ in range(processes)
    ]
    try:
        yield
    finally:
        for process in started:
            process.kill()
            process.wait()


def run(machine: Machine, jobs: int, paths: list[str], margins: Path) -> bool:
    """True if the tests are green there; the margins are added to the file."""
    path = [str(ROOT / "ci" / "testing")]
    if machine.kernels:
        path.append(str(tree_with(machine.kernels)))
    known = os.environ.get("PYTHONPATH", "")
    environment = os.environ | machine.environment | {"REFDEM_MARGINS": str(margins)}
    environment["PYTHONPATH"] = os.pathsep.join([*path, *([known] if known else [])])
    options = [
        "-q",
        "-p",
        "margins",
        "-p",
        "no:cacheprovider",
        "-n",
        str(jobs),
        "--tb=short",
        *machine.options,
    ]
    command = [sys.executable, "-P", "-m", "pytest", *options, *paths]
    with busy(BUSY if machine.is_busy else 0):
        return subprocess.run(command, cwd=ROOT, env=environment).returncode == 0


def crowded(margins: Path) -> list[str]:
    """Lines of tests with less room than ROOM, and no reason beside them, the least room first."""
    worst: dict[str, dict[str, float]] = {}
    for line in margins.read_text().splitlines() if margins.exists() else ():
        noted = json.loads(line)
        known = worst.get(noted["place"])
        if known is None or noted["used"] > known["used"]:
            worst[noted["place"]] = noted
    told = []
    for place, noted in sorted(worst.items(), key=lambda pair: -pair[1]["used"]):
        path, _, number = place.rpartition(":")
        if noted["used"] * ROOM > 1 and not has_reason(ROOT / path, int(number)):
            told.append(
                f"{place}: measured {noted['measured']:.3g} of {noted['tolerance']:.3g}, room"
                f" {1 / noted['used']:.3g}"
            )
    return told


def has_reason(path: Path, line: int) -> bool:
    """True if the line, or the one above it, says why its tolerance is sharp."""
    return any(SHARP in linecache.getline(str(path), number) for number in (line - 1, line))


def main() -> int:
    """Exit status: 0 if every machine is green and every tolerance has its room."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="*", default=[], help="names of machines")
    parser.add_argument("--jobs", default=2, type=int)
    parser.add_argument(
        "--seed",
        default=int(time.time()),
        type=int,
        help="of the random order and of other numbers; printed",
    )
    parser.add_argument(
        "--margins",
        type=Path,
        help="a file of margins to add to, so that runs can be made piece by piece",
    )
    parser.add_argument(
        "paths",
        nargs="*",
        help="tests; by default all whose numbers or time could depend on the machine",
    )
    given = parser.parse_args()
    every = machines(given.seed)
    chosen = [machine for machine in every if not given.only or machine.name in given.only]
    unknown = set(given.only) - {machine.name for machine in every}
    if unknown:
        parser.error(
            f"no machine is named {', '.join(sorted(unknown))}; there are"
            f" {', '.join(machine.name for machine in every)}"
        )
    print(f"seed {given.seed}")
    red = []
    with tempfile.TemporaryDirectory() as nest:
        margins = given.margins or Path(nest) / "margins.jsonl"
        for machine in chosen:
            missing = lacking(machine)
            if missing:
                print(
                    f"{machine.name}: not run, this processor lacks {' '.join(missing)}", flush=True
                )
                continue
            print(f"{machine.name}:", flush=True)
            if not run(
                machine, given.jobs, given.paths or [f"tests/{name}" for name in TESTS], margins
            ):
                red.append(machine.name)
        tight = crowded(margins)
    print("\n".join(f"too little room: {line}" for line in tight))
    print(f"red: {' '.join(red) or 'none'}; tolerances with less room than {ROOM:g}: {len(tight)}")
    if red or tight:
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
