"""Cases by the words that people type: parts of their ids and titles, and the `words` they give."""

import re

from refdem.core import discovery

WORD = re.compile(r"[a-z]+")
"""A word in lower case; what stands between words are spaces, hyphens and apostrophes."""


def cases_about(text: str) -> list[str]:
    """Ids of the cases and selections that have all words of a text; none for a text without words.

    A word is had where a word of the case begins with it. A plural finds the singular.
    """
    wanted = [word.removesuffix("s") for word in WORD.findall(text.lower())]
    if not wanted:
        return []
    return [name for name in discovery.names("cases") if _has(name, wanted)]


def _has(name: str, wanted: list[str]) -> bool:
    """True if the case with this id has all of the words."""
    case = discovery.case(name)
    own = WORD.findall(" ".join((name, case.title, *case.words)).lower())
    return all(any(word.startswith(beginning) for word in own) for beginning in wanted)
