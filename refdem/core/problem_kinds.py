"""The kinds of problems: `Motion` of a scene and `Iteration` of a map.

Problems with many starts are in core/ensemble.py, those without time in core/static_problems.py.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.maps import AnyMap, Map
from refdem.errors import UsageError
from refdem.scene import Scene, SceneDocument
from refdem.scene.element import Link

Array = NDArray[np.float64]

LATEST = 1e250
"""Largest time [s]: sums of any number of samples are then within the range of binary64."""
FIT = 1e-10
"""A tenth of the largest relative error of the length of a rod or string at the start."""
DENSE = 128
"""Every iterate up to this one is a sample: errors of a chaotic map grow from round-off to the size
of the map within so many iterates.
"""
PER_OCTAVE = 8
"""Samples in each octave of iterates after DENSE, and one at the last iterate."""


class Problem(ABC):
    """One problem for an engine to solve.

    `times` (T,) are the samples: times [s] of a motion, numbers of iterates of an iteration,
    numbers without a unit otherwise. Only motions and ensembles have a `scene`. A new kind of
    problem is a subclass with a document of its own in problem.OTHERS.
    """

    kind: ClassVar[str]
    words: ClassVar[str]
    scene: Scene
    times: Array

    def __getattr__(self, name: str) -> Any:
        if name == "scene":
            raise UsageError(f"{self.words} has no scene")
        raise AttributeError(name)

    @property
    @abstractmethod
    def features(self) -> frozenset[str]:
        """Names of what an engine must support to answer, derived from the content."""

    @property
    def interval(self) -> float:
        """The time [s] from the first sample to the second, negative for a run backwards."""
        return float(self.times[1] - self.times[0])

    @abstractmethod
    def document(self) -> Any:
        """The content in the form that is written to JSON, without times."""

    @abstractmethod
    def perturbed(self, ulps: int) -> Self:
        """The same question with its start moved by some units in the last place."""

    @abstractmethod
    def when(self, sample: float) -> str:
        """A sample in words, for sentences."""


@dataclass(frozen=True, eq=False)
class Motion(Problem):
    """A scene, whose state holds at times[0], and the times (T,) [s] at which states are requested;
    may run backwards.
    """

    kind: ClassVar[str] = "motion"
    words: ClassVar[str] = "a motion"
    scene: Scene
    times: Array

    def __post_init__(self) -> None:
        """Raises UsageError for times that are not finite, or neither all rising nor all
        falling.
        """
        if not np.all(np.abs(self.times) <= LATEST):
            raise UsageError(f"times holds a number that is not finite, or beyond {LATEST:g} s")
        gaps = np.diff(self.times)
        is_monotonic = np.all(gaps > 0) or np.all(gaps < 0)
        if self.times.ndim != 1 or len(self.times) < 2 or not is_monotonic:
            raise UsageError(
                f"times has shape {self.times.shape}; expected (T,) with T >= 2, all rising or all"
                " falling"
            )

    @property
    def features(self) -> frozenset[str]:
        """The features that an engine must support: those of the scene."""
        return self.scene.features

    def document(self) -> SceneDocument:
        """The scene, as written to JSON."""
        return self.scene.document()

    def perturbed(self, ulps: int) -> "Motion":
        """The motion whose start is moved by a relative eps = ulps 2^-52.

        Positions and omegas are multiplied by 1 + eps, components of velocities alternately by
        1 - eps and 1 + eps. With one factor for all, a system with linear forces would have the
        same motion on another scale, and errors would not grow. If eps is too large for constraints
        to hold, the bodies are rotated about an anchor in the world instead.
        """
        bodies = self.scene.bodies
        eps = ulps * 2.0**-52
        if abs(eps) > FIT and "constraint" in self.features:
            return self._rotated(eps)
        # Signs -1, 1, -1, ... in the order of the components.
        signs = np.where(np.arange(bodies.velocity.size) % 2, 1.0, -1.0)
        signs = signs.reshape(bodies.velocity.shape)
        scene = self.scene.with_state(
            position=bodies.position * (1 + eps),
            velocity=bodies.velocity * (1 + signs * eps),
            omega=bodies.omega * (1 + eps),
        )
        return Motion(scene, self.times)

    def _rotated(self, angle: float) -> "Motion":
        """Positions and velocities of the bodies rotated about z by a small angle [rad].

        The axis passes through the first anchor of a link in the world, or through the origin. This
        does not change the lengths of rods between bodies, or from a body to that anchor.
        """
        anchors = [link.anchor_b for link in self.scene.all(Link) if link.b < 0]
        # r <- p + Rz (r - p),   v <- Rz v.
        pivot = np.zeros(3)
        if anchors:
            pivot = np.array(anchors[0])
        c = np.cos(angle)
        s = np.sin(angle)
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        bodies = self.scene.bodies
        position = pivot + (bodies.position - pivot) @ rotation.T
        velocity = bodies.velocity @ rotation.T
        return Motion(self.scene.with_state(position=position, velocity=velocity), self.times)

    def when(self, sample: float) -> str:
        """A time [s] in words, for sentences."""
        return f"t = {sample:.4g} s"


class IterationDocument(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag="iteration",
    tag_field="kind",
    forbid_unknown_fields=True,
):
    """An iteration as JSON has it."""

    map: AnyMap
    start: list[float]
    n: int


@dataclass(frozen=True, eq=False)
class Iteration(Problem):
    """A map, its start (D,), and the number n of its applications; the iterates with the numbers
    `times` (T,), integers from 0 to n, are requested.
    """

    kind: ClassVar[str] = "iteration"
    words: ClassVar[str] = "an iteration"
    map: Map
    start: Array
    n: int

    def __post_init__(self) -> None:
        """Raises UsageError for n < 1, or a start that the map cannot have."""
        if (
            self.n < 1
            or self.start.shape != (self.map.dimension,)
            or not np.all(np.isfinite(self.start))
        ):
            raise UsageError(
                f"iteration: n = {self.n} and a start of shape {self.start.shape}; expected n >= 1"
                f" and {self.map.dimension} finite numbers"
            )

    @property
    def times(self) -> Array:  # type: ignore[override]
        """Numbers (T,) of the requested iterates: 0, 1, ... DENSE, DENSE 2^(k/PER_OCTAVE) for k =
        1, 2, ... below n, and n.
        """
        octaves = max(0.0, np.log2(self.n / DENSE))
        k = np.arange(1, int(octaves * PER_OCTAVE) + 1)
        sparse = np.round(DENSE * 2.0 ** (k / PER_OCTAVE))
        numbers = [*np.arange(min(self.n, DENSE) + 1), *sparse[sparse < self.n]]
        if self.n > DENSE:
            numbers.append(self.n)
        return np.array(numbers, float)

    @property
    def features(self) -> frozenset[str]:
        """The features that an engine must support: the name of the map."""
        return frozenset({f"map:{self.map.kind}"})

    def document(self) -> IterationDocument:
        """The map, start and number of iterates, as written to JSON."""
        return IterationDocument(map=self.map, start=self.start.tolist(), n=self.n)  # type: ignore[arg-type]

    def perturbed(self, ulps: int) -> "Iteration":
        """The numbers of the start multiplied alternately by 1 + eps and 1 - eps, eps = ulps 2^-52.

        One factor for all would not change the direction of a vector.
        """
        signs = np.where(np.arange(len(self.start)) % 2, -1.0, 1.0)
        start = self.start * (1 + signs * ulps * 2.0**-52)
        return Iteration(self.map, self.map.admitted(start), self.n)

    def when(self, sample: float) -> str:
        """The index of an iterate in words, for sentences."""
        return f"n = {sample:.0f}"
