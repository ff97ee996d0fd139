"""Chung and Ooi, test 8: a spinning sphere meets a larger, very heavy one: two levers that
differ.
"""

from refdem.cases.impact_benchmarks import co_7
from refdem.cases.impact_benchmarks._spinning_pair import SpinningPair

MEMBER = SpinningPair(
    "Spinning sphere on a large heavy one",
    {
        **co_7.MEMBER.numbers,
        "partner_radius": "0.5",
        "partner_density": "2699000000",
        "partner_spin": "0",
        "cutoff": "zero_force",
    },
)
