"""The damped oscillator m x'' + 2 m delta x' + k x = m g: the driven one (driven_oscillator.py)
that nothing drives.
"""

from collections.abc import Mapping

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.closed_forms.driven_oscillator import DrivenOscillator
from refdem.truth.exact import numbers
from refdem.truth.refiner import Refiner


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth at parameters mass, stiffness, gravity, delta, x0, v0; `scale` of x and v."""
    exact = numbers(p, "mass", "stiffness", "gravity", "x0", "v0", "delta")
    return DrivenOscillator(refiner=Refiner.of(scale), is_driven=False, **exact)
