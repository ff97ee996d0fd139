"""The reference's own method for many spheres, by one thread."""

import numpy as np

from refdem.bench.crowds._crowd import Crowd, Gas
from refdem.core import discovery
from refdem.core.problem import Motion, Request


class Reference(Crowd):
    """As every run of it is, with two samples."""

    name = "reference gas"
    is_reference = True

    def missing(self) -> str | None:
        """None: it comes with refdem."""
        return None

    def refusal(self, gas: Gas) -> str | None:
        """None for every gas."""
        engine = discovery.engine("reference")
        return engine.refusal(gas.instance.motion, engine.method("gas"))

    def seconds(self, gas: Gas, steps: int) -> float:
        """The time in the kernel."""
        motion = Motion(gas.instance.scene, np.array([0.0, steps * gas.step]))
        return (
            discovery.engine("reference")
            .run(Request(problem=motion, method="gas", step=gas.step))[1]
            .seconds
        )


CROWD = Reference()
