"""Lyapunov exponents (1.7.2): positive for what is chaotic, zero for what is regular, of every case
that is declared to be one of them.
"""

from collections.abc import Mapping

from refdem.core.case import Canonical, Case, Instance
from refdem.core.selection import Selection

SPAN = 200
"""Duration in units of tau for which a regular motion is followed."""


def _parameters(case: Canonical) -> list[Mapping[str, str]]:
    """The parameter sets at which a case is looked at.

    They are its defaults, for SPAN tau if it is a regular motion, and the set that it declares
    chaotic.
    """
    if isinstance(case, Case) and not case.chaotic_at:
        defaults = {"duration": f"{SPAN * case.at().scales.tau:.6g}"}
    else:
        defaults = {}
    if case.chaotic_at:
        return [defaults, case.chaotic_at]
    return [defaults]


def _reason(instance: Instance) -> str | None:
    """None if the case declares whether it is chaotic, else the reason why it is omitted."""
    if instance.case.is_chaotic(instance.p) is not None:
        return None
    return "it is not known whether the motion is chaotic"


CASE = Selection(
    id="lyapunov",
    title="Lyapunov exponents",
    words=("chaos", "exponent", "butterfly", "predictability"),
    statement=(
        "A motion is stable if neighbours at its start stay together as a power of the time, and"
        " Lyapunov unstable if they part as exp(lambda t). Two runs from neighbouring starts show"
        " which: the exponent is positive, by two error bars, for the chaotic ones, and zero for"
        " the regular ones. A free body that turns about its middle axis leaves it exponentially at"
        " first, yet comes back: its motion is regular, its exponent zero, and only the rate of the"
        " linearised start is positive."
    ),
    source="Matuttis and Chen 2014, chapter 1, 1.7.2, (1.131)-(1.133), fig. 1.35",
    check="lyapunov",
    admits=_reason,
    parameters=_parameters,
)
