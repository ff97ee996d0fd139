"""Levers and spins: where the tangential force takes hold, and the slip that turning makes."""

from functools import partial
from typing import Any

from refdem.faults.change import every_other, of_arguments, of_elements, of_results, scaled
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene.elements.contact import Contact

contact = partial(Fault, kind="contact")


def _branch(name: str) -> Any:
    """A request whose contact law has another lever arm, by its name."""
    return of_elements(Contact, branch=lambda _: name)


def _one_lever(sound: Parts) -> dict[str, Any]:
    """The lever of the first body is used for both (Lethe 300)."""
    first_lever: Any = None

    def lever(radius: Any, depth: Any, shortening: Any) -> Any:
        nonlocal first_lever
        if first_lever is None:
            first_lever = sound.lever(radius, depth, shortening)
            return first_lever
        second_lever = first_lever
        first_lever = None
        return second_lever

    return {"lever": lever}


def _spinless(sound: Parts) -> dict[str, Any]:
    """The slip of the centres without spins; where it is 0, as head-on, there is no friction."""

    def sliding_friction(law: Any, normal: Any, slip: Any, stopping: Any) -> Any:
        if any(slip):
            return sound.sliding_friction(law, normal, slip, 1e300)
        return vec.ZERO

    return {
        "slip": lambda velocity, spin, normal: sound.slip(velocity, vec.ZERO, normal),
        "sliding_friction": sliding_friction,
    }


FAULTS = (
    contact(
        name="lever-radius",
        sentence="The lever arm is R instead of R - d/2.",
        on=("scrape",),
        sees=("angular-momentum", "total"),
        before=_branch("R"),
    ),
    contact(
        name="lever-short",
        sentence="The lever arm is R - d instead of R - d/2.",
        on=("scrape",),
        sees=("angular-momentum", "total"),
        before=_branch("R-d"),
    ),
    contact(
        name="lever-of-the-centres",
        sentence="The lever arm is R - d/2 instead of R.",
        on=("scrape-long",),
        sees=("angular-momentum", "law"),
        levels=6,
        before=_branch("R-d/2"),
    ),
    contact(
        name="lever-of-slip-for-torque",
        sentence="Slip and torque have the lever arm R; by the law the torque has R - d/2.",
        on=("scrape-two-levers",),
        sees=("angular-momentum", "total"),
        before=_branch("R"),
    ),
    contact(
        name="lever-of-torque-for-slip",
        sentence="Slip and torque have the lever arm R - d/2; by the law the slip has R.",
        on=("hold-two-levers",),
        sees=("error", "omega1.z"),
        levels=6,
        before=_branch("R-d/2"),
    ),
    contact(
        name="lever-of-one",
        sentence="The lever arm of one body is used for both (Lethe 300).",
        on=("scrape",),
        sees=("angular-momentum", "total"),
        inside=_one_lever,
    ),
    contact(
        name="torque-on-one",
        sentence="The torque acts on one body only.",
        on=("scrape",),
        sees=("angular-momentum", "total"),
        inside=every_other("torque_on"),
    ),
    contact(
        name="torque-sign",
        sentence="The torque has the wrong sign.",
        on=("scrape",),
        sees=("angular-momentum", "total"),
        inside=of_results(torque_on=scaled(-1.0)),
    ),
    contact(
        name="slip-without-spin",
        sentence="The slip ignores spins: it is that of the centres.",
        on=("spinner",),
        sees=("error", "omega2.z"),
        inside=_spinless,
    ),
    contact(
        name="slip-spin-sign",
        sentence="Spins enter the slip with the wrong sign (Lethe 889).",
        on=("spinner",),
        sees=("error", "omega2.z"),
        inside=of_arguments(
            slip=lambda velocity, spin, normal: (velocity, vec.times(-1.0, spin), normal)
        ),
    ),
)
