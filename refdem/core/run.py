"""A run: one request to one engine, and the trajectory or the failure that came of it."""

from dataclasses import dataclass

import msgspec

from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory


class Failure(msgspec.Struct, frozen=True, kw_only=True):
    """Why there is no trajectory: crash, hang, contract or refusal, and one sentence.

    A run that was not begun, because another one had failed before it, is no cause of its own.
    """

    kind: str
    sentence: str
    is_begun: bool = True


@dataclass(frozen=True, eq=False, kw_only=True)
class Run:
    """A request with its outcome: exactly one of trajectory and failure is there."""

    key: str
    request: Request
    engine: str
    version: str
    trajectory: Trajectory | None = None
    failure: Failure | None = None
    cost: Cost | None = None
    from_store: bool = False
