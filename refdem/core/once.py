"""What many ask of one object, an instance of a case or the contents of a report, found once for
each object.
"""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

Owner = TypeVar("Owner")
Found = TypeVar("Found")


def once_for_each(find: Callable[[Owner], Found]) -> Callable[[Owner], Found]:
    """The same function, which finds its answer once for each object and forgets it with the
    object; objects are distinguished by their identity.
    """
    known: WeakKeyDictionary[Owner, Found] = WeakKeyDictionary()

    @wraps(find)
    def known_answer(owner: Owner) -> Found:
        """The answer, from `known` where it is there."""
        if owner not in known:
            known[owner] = find(owner)
        return known[owner]

    return known_answer
