"""Parameters that change nothing in the requested setting, such as friction where nothing slips.

A parameter is without effect if the problem with it is the problem at its default, to the bit, or
if the certified values of both are the same.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from refdem.core.case import Instance
    from refdem.core.store import Store
    from refdem.core.truth import SampledTruth
    from refdem.planning.specification import Specification

PROOF = 5.0
"""Limit on the time [s] of a proof that is made only for this sentence."""
SHARP = 1e-9
"""Largest radii, in units of the scale of a quantity, with which overlapping values count as equal.
"""


def at_defaults(instance: "Instance") -> "dict[str, Instance]":
    """For every parameter that differs from its default: the instance with the default of this one.

    Parameters of the sample times are left out, and those whose default is inconsistent with the
    other parameters.
    """
    from refdem.errors import UsageError

    clock = {parameter.name for parameter in instance.case.clock}
    changed = instance.p.changed()
    others = {}
    for name in changed:
        if name in clock:
            continue
        rest = {other: text for other, text in changed.items() if other != name}
        try:
            others[name] = instance.case.at(**rest)
        except UsageError:
            continue
    return others


def unused(instance: "Instance") -> list[str]:
    """Names of the parameters that do not enter the problem: with the default it is the same."""
    return [
        name for name, other in at_defaults(instance).items() if is_same_problem(instance, other)
    ]


def is_same_problem(one: "Instance", other: "Instance") -> bool:
    """True if the problems for engines are bitwise the same, at the same times."""
    from refdem.core.problem import Request

    packed = [Request(problem=each.problem, method="", step=None).packed() for each in (one, other)]
    return packed[0] == packed[1]


def parameters_without_effect(instance: "Instance", store: "Store") -> list[str]:
    """Names of the parameters that enter the problem and change no certified value of it.

    Proofs are read from the store and kept there. A parameter whose proof takes longer than PROOF
    is left out.
    """
    from refdem.execution.schedule import Schedule
    from refdem.planning.truths import sampled_truths

    others = {
        name: other
        for name, other in at_defaults(instance).items()
        if np.array_equal(other.times, instance.times) and not is_same_problem(instance, other)
    }
    if not others:
        return []
    truths_to_prove = [(each, ()) for each in (instance, *others.values())]
    with Schedule(len(truths_to_prove), PROOF) as schedule:
        truth, *other_truths = sampled_truths(schedule, store, truths_to_prove, _ignore_progress)
    scales = {name: quantity.scale for name, quantity in instance.quantities.items()}
    return [
        name
        for name, other in zip(others, other_truths, strict=True)
        if is_same_truth(truth, other, scales)
    ]


def _ignore_progress(stage: str, done: int, total: int) -> None:
    """Progress that is not shown: these proofs are few and short, and were not requested."""


def is_same_truth(one: "SampledTruth", other: "SampledTruth", scales: Mapping[str, float]) -> bool:
    """True if the certified values of two truths, of every sample, are the same within their radii,
    which are at most SHARP of the scale of each quantity.
    """
    is_whole = one.until == other.until == len(one.t) and bool(one.values)
    if not is_whole or one.values.keys() != other.values.keys():
        return False
    for name in one.values:
        radius = one.radius(name) + other.radius(name)
        is_sharp = np.all(radius <= SHARP * scales.get(name, 1.0))
        if not is_sharp or np.any(np.abs(one.value(name) - other.value(name)) > radius):
            return False
    if one.scalars.keys() != other.scalars.keys():
        return False
    return all(
        abs(value - other.scalars[name][0]) <= radius + other.scalars[name][1]
        for name, (value, radius) in one.scalars.items()
    )


def sentences(instance: "Instance", store: "Store") -> list[str]:
    """A sentence for each parameter that was set and changes nothing in this setting."""
    lines = []
    for name in unused(instance):
        lines.append(f"{set_and_default(instance, name)}: the scene is the same")
    for name in parameters_without_effect(instance, store):
        lines.append(f"{set_and_default(instance, name)}: the certified motion is the same")
    return lines


def set_and_default(instance: "Instance", name: str) -> str:
    """The opening of a sentence: what was set, and what its default is."""
    default = instance.p.declared[name].default
    value = instance.p.texts()[name]
    if default:
        return f"{name}={value} changes nothing here, against its default {default}"
    return f"{name}={value} changes nothing here, against leaving it out"


def of_settings(specification: "Specification", store: "Store") -> list[str]:
    """The sentences for all cases that were requested with parameters, each with its label."""
    from refdem.core import discovery
    from refdem.core.selection import Selection

    lines = []
    for entry in specification.case:
        case = discovery.case(entry.id)
        if isinstance(case, Selection) or not entry.set:
            continue
        instance = case.at(**entry.set)
        lines += [f"{instance.label}: {sentence}" for sentence in sentences(instance, store)]
    return lines
