"""The dashpot that makes the restitution which a member names, and how long a contact then
lasts.
"""

from typing import Any

import numpy as np

from refdem.errors import UsageError


def dashpot_of(v: Any, mass: Any) -> Any:
    """The dashpot [kg/s] of `v.restitution` for an effective mass [kg].

    UsageError where no damping below the critical one makes it.
    """
    from refdem.truth.contact_law import dashpot

    try:
        return dashpot(
            v.restitution, mass, v.stiffness, ends_with_overlap=v.cutoff == "zero_overlap"
        )
    except ValueError:
        got = float(v.restitution)
        raise UsageError(
            f"parameter restitution: got {got:g}; expected more than exp(-2) where the force must"
            " not pull"
        ) from None


def linear_contact_time(v: Any, mass: Any) -> float:
    """How long a contact lasts [s], to rounding: pi/(w0 sin alpha), or 2 alpha/(w0 sin alpha) where
    the force ends it.

    The damping is c = 2 sqrt(m k) cos alpha, and w0 = sqrt(k/m).
    """
    from refdem.truth.reals import root

    rate = np.sqrt(float(v.stiffness / mass))
    cosine = v.damping / (2 * root(mass * v.stiffness))
    # sin alpha from 1 - cos alpha, which is exact before it is rounded: near critical damping alpha
    # is small.
    spare = float(1 - cosine)
    sine = np.sqrt(spare * (2 - spare))
    angle = np.arctan2(sine, float(cosine))
    if v.cutoff == "zero_overlap":
        return float(np.pi / (rate * sine))
    return float(2 * angle / (rate * sine))
