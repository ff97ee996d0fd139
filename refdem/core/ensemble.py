"""The motion of one scene from many starts at once: an outline, or a cloud, carried through phase
space.
"""

import math
from dataclasses import dataclass
from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.problem_kinds import Motion, Problem
from refdem.errors import UsageError
from refdem.scene import Scene, SceneDocument

Array = NDArray[np.float64]


class EnsembleDocument(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="ensemble",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """An ensemble as JSON has it; starts are little-endian doubles (M, N, 3)."""

    scene: SceneDocument
    times: list[float]
    position: bytes
    velocity: bytes


@dataclass(frozen=True, eq=False)
class Ensemble(Problem):
    """A scene of N bodies, M starts of it at times[0]: position, velocity (M, N, 3) [m, m/s], and
    the requested times (T,) [s].

    The answer has `position` and `velocity` (T, M, N, 3). The starts replace the state of the scene
    itself. No body rotates.
    """

    kind: ClassVar[str] = "ensemble"
    words: ClassVar[str] = "an ensemble of motions"
    scene: Scene
    times: Array
    position: Array
    velocity: Array

    def __post_init__(self) -> None:
        """Raises UsageError for starts of another shape, or that are not finite, and for times that
        a motion cannot have.
        """
        shape = (len(self.position), len(self.scene.bodies), 3)
        if self.position.shape != shape or self.velocity.shape != shape or not shape[0]:
            raise UsageError(
                f"ensemble: starts have shapes {self.position.shape} and {self.velocity.shape};"
                f" expected {shape}, at least one"
            )
        if not (np.all(np.isfinite(self.position)) and np.all(np.isfinite(self.velocity))):
            raise UsageError("ensemble: a start is not finite")
        # The constructor of a motion checks the times.
        Motion(self.scene, self.times)

    @classmethod
    def read(cls, document: EnsembleDocument) -> "Ensemble":
        """The ensemble of a document; raises UsageError if its starts have the wrong length."""
        scene = Scene.of_document(document.scene)
        count = 3 * len(scene.bodies)
        # A number has 8 bytes; bytes beyond the last whole number are left out.
        raw = [
            np.frombuffer(column[: len(column) // 8 * 8], dtype="<f8").astype(float)
            for column in (document.position, document.velocity)
        ]
        if any(column.size % count for column in raw) or raw[0].size != raw[1].size:
            raise UsageError(
                f"ensemble: starts of {raw[0].size} and {raw[1].size} numbers; expected as many,"
                f" {count} to a start"
            )
        position, velocity = (column.reshape(-1, len(scene.bodies), 3) for column in raw)
        return cls(scene, np.array(document.times), position, velocity)

    @property
    def features(self) -> frozenset[str]:
        """The features of the scene that all motions share."""
        return self.scene.features

    def document(self) -> EnsembleDocument:
        """The scene, times and starts, as written to JSON."""
        starts = {
            name: np.ascontiguousarray(getattr(self, name), dtype="<f8").tobytes()
            for name in ("position", "velocity")
        }
        return EnsembleDocument(
            scene=self.scene.document(math.inf), times=self.times.tolist(), **starts
        )

    def perturbed(self, ulps: int) -> "Ensemble":
        """The ensemble with every start moved as by `Motion.perturbed`."""
        # r <- r (1 + eps),   v_k <- v_k (1 -+ eps) in turn, eps = ulps 2^-52.
        eps = ulps * 2.0**-52
        one_start = self.velocity[0]
        signs = np.where(np.arange(one_start.size) % 2, 1.0, -1.0).reshape(one_start.shape)
        position = self.position * (1 + eps)
        velocity = self.velocity * (1 + signs * eps)
        return Ensemble(self.scene, self.times, position, velocity)

    def when(self, sample: float) -> str:
        """A time [s] in words, for sentences."""
        return f"t = {sample:.4g} s"

    def motion(self, member: int) -> Motion:
        """The motion that starts from one member."""
        return Motion(
            self.scene.with_state(position=self.position[member], velocity=self.velocity[member]),
            self.times,
        )
