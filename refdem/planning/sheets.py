"""The sheets of a report beside the records: one for every instance and every engine."""

from typing import Any

import msgspec

from refdem.core.case import Instance
from refdem.core.engine import Engine, Method
from refdem.core.finding import CaseSheet, EngineSheet
from refdem.core.truth import SampledTruth
from refdem.scene.scene import encoded

LISTED = 64
"""Largest number of entries of a list, such as bodies, that a report shows."""


def case_sheet(instance: Instance, truth: SampledTruth) -> CaseSheet:
    """Statement, parameters, scene, scales and how truth was proved."""
    case = instance.case
    scales = instance.scales
    lengths = {"L": scales.length, "tau": scales.tau, "T": scales.duration, "mass": scales.mass}
    units = {parameter.name: parameter.unit for parameter in instance.p.declared.values()}
    quantities = {quantity.name: quantity.unit for quantity in instance.quantities.values()}
    document = msgspec.json.decode(encoded(instance.problem.document()))
    scene = msgspec.json.format(msgspec.json.encode(_shown(document))).decode()
    return CaseSheet(
        case=case.id,
        label=instance.label,
        title=case.title,
        statement=case.statement,
        latex=case.latex,
        source=case.source,
        parameters=instance.p.texts(),
        units=units,
        scene=scene,
        scales=lengths,
        quantities=quantities,
        truth_method=truth.method,
        truth_witness=truth.witness,
        truth_scalars=truth.printed,
        truth_reason=truth.reason,
        reproduce=_command(instance),
        motion=case.motion,
        words=case.words,
    )


def _command(instance: Instance) -> str:
    """The command that runs an instance, with the parameters that are not at their defaults."""
    settings = " ".join(f"--set {name}={value}" for name, value in instance.p.changed().items())
    return f"refdem run {instance.case.id} {settings}".strip()


def _shown(value: Any) -> Any:
    """A JSON value in which every list is cut after LISTED entries, with the number of others."""
    if isinstance(value, dict):
        return {name: _shown(item) for name, item in value.items()}
    if not isinstance(value, list):
        return value
    if len(value) > LISTED:
        ending = [f"and {len(value) - LISTED} more"]
    else:
        ending = []
    return [*map(_shown, value[:LISTED]), *ending]


def engine_sheet(engine: Engine) -> EngineSheet:
    """Version, methods with their claims, audit of defaults."""
    return EngineSheet(
        engine=engine.name,
        title=engine.title,
        version=engine.version(),
        licence=engine.licence,
        is_reference=engine.is_reference,
        methods={method.name: claims(method) for method in engine.methods},
        audit=tuple((d.setting, d.default, d.used, d.why) for d in engine.audit),
        default_step=engine.default_step,
    )


def claims(method: Method) -> str:
    """A method's claims in one line."""
    accuracy = {
        "step": f"order {method.order}",
        "tolerance": "tolerance control",
        "exact": "exact",
    }
    words = [method.summary, accuracy[method.control]]
    words += [f"order {order} with {feature}" for feature, order in method.order_with.items()]
    for name in sorted(method.conserves):
        broken = ", ".join(sorted(method.broken_with.get(name, ())))
        if broken:
            exception = f" (not with {broken})"
        else:
            exception = ""
        words.append(f"conserves {name}{exception}")
    if method.symplectic:
        words.append("symplectic")
    if method.reversible:
        words.append("reversible")
    if method.summed_clock:
        words.append("its clock is a plain sum of steps, with an error of up to u t per step")
    if method.tells:
        words.append(f"tells every {' and '.join(sorted(method.tells))}")
    if method.cuts_steps:
        words.append("its steps end at the kinks of forces")
    if method.differenced_velocities:
        words.append("its velocities are differences of places, rounded by up to u r/h")
    if method.constant != 1:
        words.append(f"C = {method.constant:g} ({method.constant_reason})")
    return "; ".join(words)
