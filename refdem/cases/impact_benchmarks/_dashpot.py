"""The dashpot for a given restitution, and the duration of the damped linear contact.

m d'' + c d' + k d = 0 for the overlap d, with the effective mass m; `v` holds the values of a
member (`Member.values`), exact or as Reals, which truth encloses at its own precision.
"""

from typing import Any

import numpy as np

from refdem.cases.impact_benchmarks._values import Values
from refdem.errors import UsageError


def dashpot_of(v: Values, mass: Any) -> Any:
    """The dashpot c [kg/s] that gives `v.restitution` to an effective mass [kg], as a Real.

    Raises UsageError where no damping below the critical one gives it.
    """
    from refdem.truth.contact_law import dashpot

    try:
        return dashpot(
            v.restitution, mass, v.stiffness, ends_with_overlap=v.cutoff == "zero_overlap"
        )
    except ValueError:
        restitution = float(v.restitution)
        raise UsageError(
            f"parameter restitution: got {restitution:g}; expected more than exp(-2) where the"
            " force must not pull"
        ) from None


def linear_contact_time(v: Values, mass: Any) -> float:
    """Duration [s], to rounding, of the contact of an effective mass [kg].

    With w0 = sqrt(k/m), cos alpha = c/(2 sqrt(m k)) and w = w0 sin alpha it is pi/w where the
    overlap ends the contact, and 2 alpha/w where the force does.
    """
    from refdem.truth.reals import root

    w0 = np.sqrt(float(v.stiffness / mass))
    cosine = v.damping / (2 * root(mass * v.stiffness))
    # Near critical damping alpha is small. Then sin^2 alpha = (1 - cos alpha)(1 + cos alpha), with
    # 1 - cos alpha formed before it is rounded, does not cancel.
    one_minus_cosine = float(1 - cosine)
    sine = np.sqrt(one_minus_cosine * (2 - one_minus_cosine))
    alpha = np.arctan2(sine, float(cosine))
    if v.cutoff == "zero_overlap":
        return float(np.pi / (w0 * sine))
    return float(2 * alpha / (w0 * sine))
