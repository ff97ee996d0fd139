"""The other installation of a paired comparison: there `python -m refdem.bench.interleaving` makes
the requested runs, one at a time.

Lines of JSON: first a list of places, answered by null or a reason not to run for each; then the
number of a place, answered by seconds.
"""

import sys
from typing import Any, TextIO

import msgspec

from refdem.bench.measurement import median_cost
from refdem.bench.peers import peers
from refdem.core import discovery
from refdem.core.engine import Engine
from refdem.core.problem import Request
from refdem.errors import RefdemError


class Place(msgspec.Struct, frozen=True):
    """One level of one method: address of its engine, whether that is a peer, the request, and what
    its first run took [s].
    """

    engine: str
    is_peer: bool
    request: msgspec.Raw
    seconds: float

    def runnable(self) -> tuple[Engine, Request]:
        """The engine as it is here, and the request; raises RefdemError if there is none."""
        engine: Engine | None
        if self.is_peer:
            engine = next((peer for peer in peers() if peer.name == self.engine), None)
        else:
            engine = discovery.engine(self.engine)
        if engine is None:
            raise RefdemError(f"{self.engine} is not installed there")
        return engine, Request.from_json(bytes(self.request))


def serve(lines: TextIO, answers: TextIO) -> None:
    """Loads the places that the first line asks for, then times one for every line that follows."""

    def say(value: Any) -> None:
        answers.write(msgspec.json.encode(value).decode() + "\n")
        answers.flush()

    places = msgspec.json.decode(lines.readline(), type=list[Place])
    ready: dict[int, tuple[Engine, Request]] = {}
    reasons: list[str | None] = []
    for number, place in enumerate(places):
        try:
            engine, request = place.runnable()
            engine.run(request)
        except (RefdemError, ArithmeticError) as error:
            reasons.append(str(error))
        else:
            ready[number] = engine, request
            reasons.append(None)
    say(reasons)
    for line in lines:
        say(_seconds(*ready[int(line)], places[int(line)].seconds))


def _seconds(engine: Engine, request: Request, first: float) -> float:
    """The seconds of a run now; `first` are those of its first run."""
    return median_cost(lambda: engine.run(request)[1], first).seconds


if __name__ == "__main__":
    serve(sys.stdin, sys.stdout)
