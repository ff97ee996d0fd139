"""The public names, which `__init__.py` imports when they are first used, for type checkers."""

from refdem.api import judge as judge
from refdem.api import run as run
from refdem.api import sampled as sampled
from refdem.api import sensitivities_of as sensitivities_of
from refdem.core.discovery import truth_of as truth_of
from refdem.errors import RefdemError as RefdemError
from refdem.report import records as records
from refdem.scene import Body as Body
from refdem.scene import Scene as Scene

__version__: str
