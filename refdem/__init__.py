"""refdem: verification and validation of rigid-body and discrete element codes against certified
truth.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from refdem.api import judge as judge
    from refdem.api import run as run
    from refdem.api import sampled as sampled
    from refdem.core.discovery import truth_of as truth_of
    from refdem.errors import RefdemError as RefdemError
    from refdem.report import records as records
    from refdem.scene import Body as Body
    from refdem.scene import Scene as Scene

__version__ = "0.2.0"

_HOMES = {
    "Scene": "refdem.scene",
    "Body": "refdem.scene",
    "RefdemError": "refdem.errors",
    "judge": "refdem.api",
    "records": "refdem.report",
    "run": "refdem.api",
    "sampled": "refdem.api",
    "truth_of": "refdem.core.discovery",
}


def __getattr__(name: str) -> Any:
    """The public names, imported when first used, so that `import refdem` stays cheap."""
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'refdem' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
