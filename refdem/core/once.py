"""A cache for functions of one object: the result is computed once for each object.

Examples of such objects are an instance of a case and the contents of a report.
"""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

Owner = TypeVar("Owner")
Found = TypeVar("Found")


def once_for_each(find: Callable[[Owner], Found]) -> Callable[[Owner], Found]:
    """The function `find` with a cache, whose entries are removed together with their objects.

    Objects must be hashable and weakly referenceable; those meant here compare by identity.
    """
    known: WeakKeyDictionary[Owner, Found] = WeakKeyDictionary()

    @wraps(find)
    def known_answer(owner: Owner) -> Found:
        """The result for `owner`, from the cache if it is there."""
        if owner not in known:
            known[owner] = find(owner)
        return known[owner]

    return known_answer
