"""The sheets of a campaign, stored under a digest of everything that they depend on. If nothing has
changed, nothing is planned, read or judged again.
"""

import hashlib
import platform

import msgspec

from refdem.core import discovery, fingerprint
from refdem.core.engine import Engine
from refdem.core.finding import Sheet
from refdem.core.store import Store
from refdem.planning.specification import Specification, validation_folder

_DECODER = msgspec.msgpack.Decoder(list[Sheet])


def key_of(specification: Specification, engines: list[Engine]) -> str | None:
    """sha256 of everything that the sheets depend on: code, stored data, platform, specification,
    engines.

    None if another package provides cases or checks, whose code is not part of the digest.
    """
    if discovery.has_others("cases") or discovery.has_others("checks"):
        return None
    folders = [validation_folder() / name for name in ("expected", "truth")]
    code = [fingerprint.of_refdem(), *map(fingerprint.of_tree, folders)]
    libraries = map(fingerprint.version_of, ("numpy", "python-flint", "msgspec"))
    environment = [platform.python_version(), *libraries, fingerprint.of_machine()]
    of_engines = [_of_engine(engine) for engine in engines]
    content = [code, environment, specification, of_engines]
    try:
        encoded = msgspec.json.encode(content, order="deterministic")
    except UnicodeEncodeError:
        # The path of a refdem.toml may contain any bytes; such sheets are computed every time.
        return None
    return hashlib.sha256(encoded).hexdigest()


def _of_engine(engine: Engine) -> list[object]:
    """The identity and claims of an engine, and the fingerprint of its code for every method."""
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
