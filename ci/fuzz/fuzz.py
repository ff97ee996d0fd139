"""Gives refdem inputs that are wrong, and looks how it ends: ci/fuzz/fuzz.py [OPTIONS].

Every input must be refused by one sentence (a RefdemError, exit status 2), or give a right answer.
An exception of another kind, a hang, and something broken that is taken for good are findings; the
input is kept in tests/corpus and is from then on a test (tests/ci/fuzz/test_fuzz.py).

Half of the inputs are bytes that a seed changes (fuzz_bytes.py), half are documents that
Hypothesis draws (fuzz_documents.py), where what is read has documents. With --grow, an input that
is refused in words that no other was refused in is kept too: it is where later ones begin.

  ci/fuzz/fuzz.py --minutes 10                 for that long, from a seed of the day
  ci/fuzz/fuzz.py --inputs 20000 --seed 1      so many, always the same
  ci/fuzz/fuzz.py --target baselines --minutes 1
"""

import argparse
import contextlib
import datetime
import hashlib
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

import fuzz_bytes
import fuzz_documents
import fuzz_targets
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

HANGING = 60
"""Seconds of CPU after which an input is one that hangs; the longest takes two."""
BATCH = 400
"""Inputs of a target before the next has its turn."""
LARGEST = 20_000
"""Bytes of an input that is kept because its words are new."""
QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"|`[^`]*`|\S*\d\S*|[^\x20-\x7e]+")
"""What of a sentence depends on the input."""


class HangError(Exception):
    """An input took too long."""


@dataclass
class Tally:
    """What was seen of one target."""

    refused: int = 0
    right: int = 0
    shapes: set[str] = field(default_factory=set)
    findings: Counter[str] = field(default_factory=Counter)
    grown: int = 0


@contextlib.contextmanager
def within(seconds: int) -> Iterator[None]:
    """Raises HangError in a body that takes more CPU time."""

    def late(_: int, __: FrameType | None) -> None:
        raise HangError(f"it was not done after {seconds} s of CPU")

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


class Fuzz:
    """One run over some targets."""

    def __init__(self, targets: list[fuzz_targets.Target], folder: Path, *, grows: bool) -> None:
        self.targets = targets
        self.folder = folder
        self.grows = grows
        self.tallies = {target.name: Tally() for target in targets}

    def looked_at(self, target: fuzz_targets.Target, data: bytes) -> None:
        """Judges one input; raises what makes it a finding."""
        tally = self.tallies[target.name]
        own = self.folder / target.name
        own.mkdir(exist_ok=True)
        with within(HANGING):
            sentence = target.ends(data, own)
        if not sentence:
            tally.right += 1
            return
        tally.refused += 1
        shape = QUOTED.sub("_", sentence.replace(str(self.folder), ""))[:300]
        if shape not in tally.shapes:
            tally.shapes.add(shape)
            if self.grows and len(data) <= LARGEST:
                tally.grown += keep(target, data)

    def known(self) -> None:
        """Judges the seeds and the corpus, whose words are then known."""
        for target in self.targets:
            for data in [*target.seeds, *target.corpus]:
                self.tried(target, data, known=True)

    def tried(self, target: fuzz_targets.Target, data: bytes, *, known: bool = False) -> None:
        """Judges one input, and keeps it if it is a finding."""
        grows = self.grows
        self.grows = grows and not known
        try:
            self.looked_at(target, data)
        except Exception as error:
            self.found(target, data, error)
        finally:
            self.grows = grows

    def found(self, target: fuzz_targets.Target, data: bytes, error: Exception) -> None:
        """Tells a finding once for every place that it comes from, and keeps its input."""
        findings = self.tallies[target.name].findings
        frames = traceback.extract_tb(error.__traceback__)
        if frames:
            place = f"{Path(frames[-1].filename).name}:{frames[-1].lineno}"
        else:
            place = "?"
        name = f"{type(error).__name__} in {place}"
        if isinstance(error, fuzz_targets.WrongAnswerError):
            words = re.sub(r"^\S*\.\S*", "_", str(error))
            name = f"silent: {QUOTED.sub('_', words)[:120]}"
        findings[name] += 1
        if findings[name] > 1:
            return
        keep(target, data)
        print(f"FINDING {target.name}: {name}: {str(error)[:300]!r}\n  {data[:400]!r}", flush=True)

    def bytes_changed(self, target: fuzz_targets.Target, draw: random.Random, count: int) -> None:
        """Inputs by the changes of bytes."""
        both = [*target.seeds, *target.corpus]
        for _ in range(count):
            # Of the corpus most is refused at once: half of the inputs begin with good ones.
            inputs = draw.choice((target.seeds, both))
            self.tried(target, fuzz_bytes.mutated(inputs, draw))

    def documents_drawn(self, target: fuzz_targets.Target, number: int, count: int) -> None:
        """Inputs by Hypothesis, which makes the first finding as small as it can."""
        if target.tree is None:
            return
        read, write = target.tree
        roots = [read(data) for data in target.seeds]
        last: list[bytes] = []

        @seed(number)
        @settings(
            max_examples=count,
            database=None,
            deadline=None,
            phases=(Phase.generate, Phase.shrink),
            suppress_health_check=list(HealthCheck),
        )
        @given(st.sampled_from(roots).flatmap(fuzz_documents.wrong))
        def drawn(document: Any) -> None:
            data = write(document)
            last[:] = [data]
            self.looked_at(target, data)

        try:
            drawn()
        except Exception as error:
            if isinstance(error, ExceptionGroup):
                shown = error.exceptions[0]
            else:
                shown = error
            self.found(target, last[0], shown)

    def turn(self, number: int) -> None:
        """A batch for every target, from a seed."""
        for target in self.targets:
            count = max(2, round(BATCH * target.weight))
            draw = random.Random(f"{number} {target.name}")
            self.bytes_changed(target, draw, count if target.tree is None else count // 2)
            self.documents_drawn(target, draw.randrange(2**32), count // 2)

    @property
    def inputs(self) -> int:
        """How many were judged."""
        return sum(
            tally.refused + tally.right + tally.findings.total() for tally in self.tallies.values()
        )

    def told(self) -> str:
        """A line a target."""
        lines = []
        for name, tally in self.tallies.items():
            lines.append(
                f"{name:14} {tally.refused + tally.right:7} inputs, {tally.right:6} right,"
                f" {len(tally.shapes):4} sentences, {tally.grown:3} kept,"
                f" {len(tally.findings)} findings"
            )
        return "\n".join(lines)


def keep(target: fuzz_targets.Target, data: bytes) -> int:
    """Puts an input into the corpus; how many files that made."""
    place = fuzz_targets.CORPUS / target.name
    place.mkdir(parents=True, exist_ok=True)
    path = place / hashlib.sha256(data).hexdigest()[:16]
    if path.exists():
        return 0
    path.write_bytes(data)
    target.corpus.append(data)
    return 1


def main() -> int:
    """Exit status 1 if there is a finding."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=None)
    parser.add_argument("--inputs", type=int, default=None)
    parser.add_argument("--seed", type=int, default=None)
    parser.add_argument("--target", action="append", default=[])
    parser.add_argument("--grow", action="store_true")
    asked = parser.parse_args()
    warnings.simplefilter("error")
    today = datetime.datetime.now(tz=datetime.UTC).toordinal()
    if asked.seed is None:
        number = today
    else:
        number = asked.seed
    until = time.monotonic() + 60 * (1.0 if asked.minutes is None else asked.minutes)
    with tempfile.TemporaryDirectory() as folder:
        targets = fuzz_targets.targets(Path(folder))
        chosen = [one for one in targets if not asked.target or one.name in asked.target]
        if not chosen:
            print(f"no target of that name; known: {', '.join(one.name for one in targets)}")
            return 2
        fuzz = Fuzz(chosen, Path(folder), grows=asked.grow)
        fuzz.known()
        turn = 0
        while fuzz.inputs < asked.inputs if asked.inputs else time.monotonic() < until:
            fuzz.turn(number * 1_000_000 + turn)
            turn += 1
        print(fuzz.told())
    findings = sum(len(tally.findings) for tally in fuzz.tallies.values())
    print(f"fuzz: {fuzz.inputs} inputs from seed {number}, {findings} findings")
    if findings:
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
