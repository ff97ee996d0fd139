"""Caches for functions of an object: the result is computed once for each object.

Examples of such objects are an instance of a case, a run, and the contents of a report.
"""

from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

Owner = TypeVar("Owner")
Found = TypeVar("Found")
More = ParamSpec("More")


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


def once_with_arguments(
    find: Callable[Concatenate[Owner, More], Found],
) -> Callable[Concatenate[Owner, More], Found]:
    """The same for a function of an object and of further arguments, which must be hashable and are
    held as long as the object lives.
    """
    return _with_arguments(find, keeps_all=True)


def once_for_latest(
    find: Callable[Concatenate[Owner, More], Found],
) -> Callable[Concatenate[Owner, More], Found]:
    """The same, but only the results for the latest object are kept: for objects that live long."""
    return _with_arguments(find, keeps_all=False)


def _with_arguments(
    find: Callable[Concatenate[Owner, More], Found], *, keeps_all: bool
) -> Callable[Concatenate[Owner, More], Found]:
    """The function with a cache by its first argument, and for each of these by the others."""
    known: WeakKeyDictionary[Owner, dict[tuple[Any, ...], Found]] = WeakKeyDictionary()

    @wraps(find)
    def known_answer(owner: Owner, /, *args: More.args, **kwargs: More.kwargs) -> Found:
        """The result for `owner` and these arguments, from the cache if it is there."""
        answers = known.get(owner)
        if answers is None:
            if not keeps_all:
                known.clear()
            answers = known[owner] = {}
        key = (*args, *kwargs.items())
        if key not in answers:
            answers[key] = _unwritable(find(owner, *args, **kwargs))
        return answers[key]

    return known_answer


def _unwritable(found: Found) -> Found:
    """The same result; arrays, alone or in a mapping, raise ValueError if they are written to,
    since all who ask share them.
    """
    parts = found.values() if isinstance(found, Mapping) else (found,)
    for part in parts:
        if isinstance(part, np.ndarray):
            part.flags.writeable = False
    return found
