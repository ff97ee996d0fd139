"""A run: one request to one engine, and the resulting trajectory or failure."""

from dataclasses import dataclass

import msgspec

from refdem.core.problem import Request
from refdem.core.trajectory import Cost, Trajectory


class Failure(msgspec.Struct, frozen=True, kw_only=True):
    """The reason why a run has no trajectory: its kind (such as crash, hang, contract) and one
    sentence.

    `is_begun` is False for a run that was not started because another one had failed.
    """

    kind: str
    sentence: str
    is_begun: bool = True


@dataclass(frozen=True, eq=False, kw_only=True)
class Run:
    """A request with its outcome: a trajectory, unless it is stored elsewhere, or a failure."""

    key: str
    request: Request
    engine: str
    version: str
    trajectory: Trajectory | None = None
    failure: Failure | None = None
    cost: Cost | None = None
    from_store: bool = False
