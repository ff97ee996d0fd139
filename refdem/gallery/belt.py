"""Settled motions and sections of the stick-slip oscillator over the frequency of its drive
(1.125).
"""

from typing import Any

import numpy as np

from refdem.core import discovery
from refdem.gallery.runs import Array, ObservedRun, command, instance, observed_at, remember

SKIPPED = 60
"""Periods of the drive before the picture begins: the transient has decayed by then."""
PER_PERIOD = 240
"""Samples in a period of the drive: a curve drawn through them looks smooth."""
CHAOTIC = {"gamma": "2", "friction_law": "linear"}
"""A drive four times stronger than gamma = 0.5, and friction whose last term grows with the speed:
many of its motions have a positive exponent.
"""
FOLLOWED = 2000
"""Periods of the drive over which an exponent is measured: its error is then a few thousandths."""


def orbit(eta: str, periods: int = 12, **parameters: Any) -> ObservedRun:
    """A motion after SKIPPED periods of the drive, over some more; one sample stands for what was
    left out.
    """
    case_instance = instance("stick-slip", eta=eta, **parameters)
    remember(command(case_instance))
    period = 2 * np.pi / case_instance.p.eta
    shown = np.arange(periods * PER_PERIOD + 1) / PER_PERIOD
    t = np.r_[0.0, (SKIPPED + shown) * period]
    return observed_at("stick-slip", t, eta=eta, **parameters)


def section(eta: Array, *, skip: int, keep: int, **parameters: Any) -> Any:
    """The reference's section v = 0, x > 0 at the frequencies (M,), with exponents."""
    reference: Any = discovery.engine("reference")
    case_instance = instance("stick-slip", **parameters)
    remember(command(case_instance))
    return reference.section(case_instance.problem, eta, skip=skip, keep=keep)


def exponents(eta: Array, **parameters: Any) -> Any:
    """The largest exponents (M,) [1/s] at the frequencies (M,), with their errors and regimes."""
    return section(eta, skip=SKIPPED, keep=FOLLOWED, **parameters).exponent
