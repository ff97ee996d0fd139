"""Numbers of an instance that many checks ask for, computed once for each instance."""

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    from refdem.core.case import Instance


def once_per_instance(number: Callable[["Instance"], float]) -> Callable[["Instance"], float]:
    """The same function, which computes its number once for each instance and forgets it with the
    instance.
    """
    known: WeakKeyDictionary[Instance, float] = WeakKeyDictionary()

    @wraps(number)
    def known_number(instance: "Instance") -> float:
        """The number, from `known` where it is there."""
        if instance not in known:
            known[instance] = number(instance)
        return known[instance]

    return known_number
