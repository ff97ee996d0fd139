"""The growth of a displacement of the start, by two truths: a sensitivity S bounds it."""

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from refdem.core.case import Instance


def growth(
    instance: Instance, axis: int, amount: Fraction, t: Fraction, names: Iterable[str] = ()
) -> float:
    """How far the motion from a start displaced by `amount` along state variable number `axis` is
    from the motion itself at time t, over the displacement, both in units of the scales.

    The farthest of the named quantities counts, of all if none is named.
    """
    truth: Any = instance.truth()
    plain = truth.at(t)
    displaced = truth.displaced(axis, amount).at(t)
    scale = {name: quantity.scale for name, quantity in instance.quantities.items()}
    distances = [
        abs(float(displaced[name].mid - plain[name].mid)) / scale[name] for name in names or plain
    ]
    displacement = float(amount) / scale[truth.state[axis]]
    return max(distances) / displacement


def largest_growth(
    instance: Instance, amount: Fraction, t: Fraction, names: Iterable[str] = ()
) -> float:
    """The largest growth among displacements along each state variable."""
    truth: Any = instance.truth()
    axes = range(len(truth.state))
    return max(growth(instance, axis, amount, t, names) for axis in axes)
