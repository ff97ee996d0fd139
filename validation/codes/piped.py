"""LAMMPS and its kin, kept alive from run to run: their commands come from a pipe."""

import os
import subprocess
import sys
import time
from pathlib import Path

PAUSE = 5e-4
"""Time [s] between two looks for the end of a run."""


class Piped:
    """A program that takes its commands from a pipe, and is started again after it has ended."""

    def __init__(self, program):
        self.program = program
        self.process = None

    def run(self, script):
        """Runs the commands of a script from a clear start; raises RuntimeError with the end of
        what the program printed if it ended meanwhile.
        """
        end, screen = Path("end"), Path("screen")
        end.unlink(missing_ok=True)
        if self.process is None or not screen.exists():
            self.start(screen)
        self.process.stdin.write(f'clear\n{script}\nprint "" file {end} screen no\n')
        self.process.stdin.flush()
        while not end.exists():
            if self.process.poll() is not None:
                self.process = None
                raise RuntimeError(screen.read_text()[-2000:])
            time.sleep(PAUSE)

    def start(self, screen):
        """Starts the program in the working directory."""
        if self.process is not None:
            self.process.kill()
        with screen.open("w") as printed:
            self.process = subprocess.Popen(
                [self.program, "-log", "none"],
                env=environment(),
                stdin=subprocess.PIPE,
                stdout=printed,
                stderr=subprocess.STDOUT,
                text=True,
            )


def environment():
    """The environment of the program: one thread, and a TMPDIR of its own, since runs of Open MPI
    in one TMPDIR disturb each other.
    """
    return os.environ | {
        "OMP_NUM_THREADS": "1",
        "LD_LIBRARY_PATH": f"{sys.prefix}/lib",
        "TMPDIR": str(Path.cwd()),
    }


def printed(program, *words):
    """What the program prints with these words on its command line."""
    done = subprocess.run(
        [program, *words],
        env=environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


def states(path):
    """The frames of a dump: of each the rows of numbers, by their first, which is the body's."""
    frames = [frame.split("\n") for frame in Path(path).read_text().split("ITEM: TIMESTEP\n")[1:]]
    return [
        sorted([float(x) for x in line.split()] for line in frame[8:] if line) for frame in frames
    ]
