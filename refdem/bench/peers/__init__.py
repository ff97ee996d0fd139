"""Integrators for comparison only: one per file, each with a PEER that is an engine. Only the bench
discovers them.
"""

from importlib import import_module
from pathlib import Path

from refdem.core.engine import Engine


def peers() -> list[Engine]:
    """The peers that are installed here."""
    names = sorted(
        path.stem for path in Path(__file__).parent.glob("*.py") if not path.name.startswith("_")
    )
    installed: list[Engine] = [import_module(f"refdem.bench.peers.{name}").PEER for name in names]
    return [peer for peer in installed if peer.missing() is None]
