"""The reference's own method for many spheres, by one thread."""

import numpy as np

from refdem.bench.crowds._crowd import Crowd, Gas
from refdem.core import discovery
from refdem.core.problem import Motion, Request


class Reference(Crowd):
    """The gas of the reference, run like any other motion, with two samples."""

    name = "reference gas"
    is_reference = True

    def missing(self) -> str | None:
        """None: the reference comes with refdem and is always here."""
        return None

    def unsupported(self, gas: Gas) -> str | None:
        """None for every gas that the method `gas` of the reference can move."""
        engine = discovery.engine("reference")
        return engine.unsupported_motion(gas.instance.motion, engine.method("gas"))

    def seconds(self, gas: Gas, steps: int) -> float:
        """The time [s] that the kernel itself takes for so many steps."""
        motion = Motion(gas.instance.scene, np.array([0.0, steps * gas.step]))
        request = Request(problem=motion, method="gas", step=gas.step)
        _, cost = discovery.engine("reference").run(request)
        return cost.seconds


CROWD = Reference()
