"""Names that a shell completes: cases, engines and kinds of motion, as `refdem
--install-completion` makes a shell ask for them.
"""

from typing import get_args


def cases(incomplete: str) -> list[str]:
    """The cases whose names begin so."""
    from refdem.core import discovery

    return [name for name in discovery.names("cases") if name.startswith(incomplete)]


def engines(incomplete: str) -> list[str]:
    """The engines and codes whose names begin so, installed or not."""
    from refdem.core import codes, discovery

    known = [*discovery.names("engines"), *codes.descriptions()]
    return [name for name in known if name.startswith(incomplete)]


def motions(incomplete: str) -> list[str]:
    """The kinds of motion that `refdem advise` knows whose names begin so."""
    return [name for name in known_motions() if name.startswith(incomplete)]


def known_motions() -> list[str]:
    """The kinds of motion of the cases that are motions."""
    from refdem.core.case import Moving

    return [name for name in get_args(Moving) if name not in ("formula", "other")]
