"""refdem: verification and validation of rigid-body and discrete element codes against certified
truth.
"""

from importlib import import_module
from typing import Any

__version__ = "0.2.0"

_HOMES = {
    "Scene": "refdem.scene",
    "Body": "refdem.scene",
    "RefdemError": "refdem.errors",
    "judge": "refdem.api",
    "records": "refdem.report",
    "run": "refdem.api",
    "sampled": "refdem.api",
    "sensitivities_of": "refdem.api",
    "truth_of": "refdem.core.discovery",
}


def __getattr__(name: str) -> Any:
    """The public names, imported when first used, so that `import refdem` stays cheap."""
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'refdem' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
