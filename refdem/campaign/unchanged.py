"""The sheets of a campaign of which nothing has changed: kept whole, so that nothing is planned,
read or judged again.
"""

import hashlib
import platform
from importlib.metadata import version as installed

import msgspec

from refdem.campaign.specification import Specification, validation_folder
from refdem.core import discovery, fingerprint
from refdem.core.engine import Engine
from refdem.core.finding import Sheet
from refdem.core.store import Store

_DECODER = msgspec.msgpack.Decoder(list[Sheet])


def key_of(specification: Specification, engines: list[Engine]) -> str | None:
    """sha256 of all that sheets follow from.

    None where another package brings cases or checks, whose code is not known here.
    """
    if discovery.has_others("cases") or discovery.has_others("checks"):
        return None
    code = [
        fingerprint.of_refdem(),
        *(fingerprint.of_tree(validation_folder() / part) for part in ("expected", "truth")),
    ]
    under = [
        platform.python_version(),
        *map(installed, ("numpy", "python-flint", "msgspec")),
        fingerprint.of_machine(),
    ]
    asked = [_of_engine(engine) for engine in engines]
    return hashlib.sha256(
        msgspec.json.encode([code, under, specification, asked], order="deterministic")
    ).hexdigest()


def _of_engine(engine: Engine) -> list[object]:
    """What an engine is and claims, and the state of its code for every method."""
    states = [engine.fingerprint(method) for method in engine.methods]
    return [
        engine.name,
        engine.address,
        engine.version(),
        engine.is_reference,
        engine.methods,
        states,
        engine.expected,
    ]


def kept(store: Store, key: str) -> list[Sheet] | None:
    """The sheets kept under a key, or None."""
    return store.read("sheets", key, _DECODER.decode)


def keep(store: Store, key: str, sheets: list[Sheet]) -> None:
    """Keeps the sheets under their key, for a campaign of which nothing has changed."""
    store.put("sheets", key, msgspec.msgpack.encode(sheets))
