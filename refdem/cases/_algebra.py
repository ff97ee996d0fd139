"""What the cases of rotation algebra share: from rows of operations to the problem, its quantities,
and their values in an engine's answer.
"""

from abc import abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from refdem.core.algebra import SIZES
from refdem.core.case import Canonical
from refdem.core.parameters import Parameters
from refdem.core.problem import Identity
from refdem.core.quantity import Quantity, Scales
from refdem.core.static_problems import IdentityDocument, Operation
from refdem.core.trajectory import Trajectory

Array = NDArray[np.float64]
Row = tuple[str, str, list[Any]]
"""Name, operation, operands: numbers, or names of earlier rows."""

X = [1.0, 0.0, 0.0]
Y = [0.0, 1.0, 0.0]
Z = [0.0, 0.0, 1.0]


class AlgebraCase(Canonical):
    """A case of operations in rows. Each result is a quantity; one of several numbers is several
    quantities, `name.0`, `name.1` ...

    `angles` are the names of the rows whose numbers are angles, `units` those of the numbers that
    have one.
    """

    angles: ClassVar[frozenset[str]] = frozenset()
    units: ClassVar[Mapping[str, str]] = MappingProxyType({})

    @abstractmethod
    def rows(self, p: Parameters) -> list[Row]:
        """The rows of operations at these parameters, in their order."""

    def sizes(self, p: Parameters) -> dict[str, float]:
        """The magnitude of the numbers of a row, by its name, or of one number, by that of the
        number, where it is not 1: its scale.
        """
        return {}

    def problem(self, p: Parameters) -> Identity:
        """The problem of all rows: each operation with its operands."""
        operations = [
            Operation(name=name, operation=operation, operands=operands)
            for name, operation, operands in self.rows(p)
        ]
        return Identity(IdentityDocument(operations=operations))

    def scales(self, p: Parameters) -> Scales:
        """Scales of 1: the numbers are near 1, and there is no time."""
        return Scales(length=1.0, tau=1.0, duration=1.0)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """One quantity for every number of every result."""
        magnitudes = self.sizes(p)
        quantities_of_rows = []
        for name, operation, _ in self.rows(p):
            count = SIZES[operation][1]
            if count == 1:
                labels = [name]
            else:
                labels = [f"{name}.{i}" for i in range(count)]
            quantities_of_rows += [
                Quantity(
                    label,
                    self.units.get(label, "1"),
                    magnitudes.get(label, magnitudes.get(name, 1.0)),
                    angle=name in self.angles,
                )
                for label in labels
            ]
        return tuple(quantities_of_rows)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The numbers of every result that the engine could give."""
        observed: dict[str, Array] = {}
        for name, values in trajectory.values.items():
            count = values.shape[1]
            if count == 1:
                observed[name] = values[:, 0]
                continue
            for i in range(count):
                observed[f"{name}.{i}"] = values[:, i]
        return observed
