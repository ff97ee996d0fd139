"""What a gate runs of a case that is named without parameters: its defaults, and settings that show what these leave out.

Defaults are simple: they keep still what is easy to get wrong. A head-on collision rubs at no lever, bodies that are alike may be
taken for each other, and at an attitude of no rotation body axes are those of space.
"""

from collections.abc import Mapping

TELLING: Mapping[str, tuple[Mapping[str, str], ...]] = {
    "free-rigid-body": ({"attitude": "1,2,-1,1/2", "omega_body": "1/2,-1,5/4"},),
    "two-spheres": (
        {  # unlike spheres stick, slide and part; the second one's spin and torque count
            **{"masses": "1,2", "radii": "1/2,3/4", "stiffness": "16", "damping": "1/2", "angle": "1/2", "spins": "0,0,2,0,0,-1"},
            **{"tangential_stiffness": "12", "friction": "1/4"},
        },
        {  # sliding friction of full size at the whole radius; a dashpot that would pull at the end, and may not
            **{"masses": "2,1", "radii": "1/2,1", "stiffness": "16", "damping": "4", "angle": "-3/4", "spins": "0,0,1,0,0,2"},
            **{"friction": "1/4", "branch": "R", "cutoff": "zero_force"},
        },
        {  # little friction and a stiff spring: it is clipped at once and turns back
            **{"masses": "1,3", "radii": "3/4,1/2", "stiffness": "16", "damping": "1", "angle": "1/4", "spins": "0,0,-1,0,0,1"},
            **{"tangential_stiffness": "64", "friction": "1/8", "branch": "R-d"},
        },
    ),
}
"""By case id: parameters beside its defaults."""


def settings(case: str) -> tuple[Mapping[str, str], ...]:
    """Parameters of the runs that stand for a case: none, and those that are telling."""
    return ({}, *TELLING.get(case, ()))
