"""Dry friction: sign, size, limit, sticking, and when it is evaluated."""

from functools import partial
from typing import Any

from refdem.faults.change import of_arguments, of_elements, of_parts, of_results, scaled
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.faults.regularised import regularised
from refdem.mechanics import vectors as vec
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.slider import Slider

friction = partial(Fault, kind="friction")

ALONG_THE_LINE = (2.0**-8, 0.0, 0.0)
"""Velocity [m/s] of a transport along the line v = 0."""


def _slip(parts: Parts, slider: Slider, velocity: Any) -> Any:
    """Velocity [m/s] of the body along the slider's axis."""
    return vec.dot(velocity, slider.axis)


def _regularised(sound: Parts) -> dict[str, Any]:
    """Friction decreases to 0 with the speed, as if sgn(0) were 0: what should stick creeps."""
    return regularised(sound, _slip, lambda slider, u: slider.friction, counts_work=True)


def _transported(sound: Parts) -> dict[str, Any]:
    """A body at rest still drifts along x, by ALONG_THE_LINE h: transport along the line v = 0 of
    phase space.
    """

    def drifted(r: Any, v: Any, h: Any) -> Any:
        if any(v):
            return sound.drifted(r, v, h)
        return sound.drifted(r, ALONG_THE_LINE, h)

    return {"drifted": drifted}


def _without_damping(sound: Parts) -> dict[str, Any]:
    """The limit of friction follows the spring alone: the dashpot's part is lost."""
    kept: dict[str, Any] = {}

    def normal_force(law: Any, depth: Any, rate: Any) -> Any:
        kept["spring"] = law.stiffness * depth
        return sound.normal_force(law, depth, rate)

    def sliding(law: Any, normal: Any, slip: Any, stopping: Any) -> Any:
        return sound.sliding_friction(law, kept["spring"], slip, stopping)

    return {"normal_force": normal_force, "sliding_friction": sliding}


def _previous_normal(sound: Parts) -> dict[str, Any]:
    """The limit of friction is that of the overlap a step before."""
    kept: dict[str, Any] = {"h": 0.0}

    def loads(world: Any, state: Any, parts: Parts, before: Any = None, h: Any = 0.0) -> Any:
        kept["h"] = h
        return sound.loads(world, state, parts, before, h)

    def normal_force(law: Any, depth: Any, rate: Any) -> Any:
        # d(t - h) = d - h d' to first order.
        kept["before"] = sound.normal_force(law, depth - kept["h"] * rate, rate)
        return sound.normal_force(law, depth, rate)

    def sliding(law: Any, normal: Any, slip: Any, stopping: Any) -> Any:
        return sound.sliding_friction(law, kept["before"], slip, stopping)

    return {"loads": loads, "normal_force": normal_force, "sliding_friction": sliding}


FAULTS = (
    friction(
        name="friction-pushes",
        sentence="Dry friction acts in the direction of the velocity.",
        on=("rubbing",),
        sees=("energy", "dissipation"),
        inside=of_arguments(slider_force=lambda slider, side, speed: (slider, -side, speed)),
    ),
    friction(
        name="friction-missing",
        sentence="There is no dry friction.",
        on=("rubbing",),
        sees=("stop", "stop_position"),
        before=of_elements(Slider, friction=scaled(0.0)),
    ),
    friction(
        name="friction-one-percent",
        sentence="Dry friction is 1 % too strong.",
        on=("rubbing",),
        sees=("error", "x"),
        before=of_elements(Slider, friction=scaled(1.01)),
        levels=4,
    ),
    friction(
        name="friction-half",
        sentence=(
            "Friction is halved, as if divided between two bodies, though one of them is the"
            " ground."
        ),
        on=("rubbing",),
        sees=("error", "x"),
        before=of_elements(Slider, friction=scaled(0.5)),
    ),
    friction(
        name="friction-sticky",
        sentence="The static coefficient is twice the sliding one.",
        on=("rubbing",),
        sees=("stop", "stop_time"),
        inside=of_arguments(holds=lambda slider, along: (slider, along / 2)),
    ),
    friction(
        name="friction-creeps",
        sentence=(
            "sgn(0) = 0: friction vanishes with the velocity, and a body that should stick creeps."
        ),
        on=("rubbing",),
        sees=("stop", "creep"),
        inside=_regularised,
    ),
    friction(
        name="friction-transports",
        sentence=("Points of phase space that dry friction should hold move along the line v = 0."),
        on=("rubbing",),
        sees=("stop", "creep"),
        inside=_transported,
    ),
    friction(
        name="contact-friction-pushes",
        sentence="Friction at the contact acts in the direction of the slip.",
        on=("scrape",),
        sees=("error", "v1.y"),
        inside=of_results(sliding_friction=scaled(-1.0)),
    ),
    friction(
        name="contact-friction-missing",
        sentence="There is no friction at the contact.",
        on=("scrape",),
        sees=("error", "omega1.z"),
        before=of_elements(Contact, friction=scaled(0.0)),
    ),
    friction(
        name="contact-friction-five-percent",
        sentence="Coulomb's coefficient is 5 % too large.",
        on=("scrape",),
        sees=("error", "omega1.z"),
        levels=5,
        before=of_elements(Contact, friction=scaled(1.05)),
    ),
    friction(
        name="contact-limit-missing",
        sentence="The tangential spring is not limited by Coulomb's law.",
        on=("bristle",),
        sees=("error", "v1.y"),
        before=of_elements(Contact, friction=scaled(1e3)),
    ),
    friction(
        name="contact-limit-per-axis",
        sentence="Coulomb's limit uses the weight instead of the normal force.",
        on=("bristle",),
        sees=("error", "omega1.z"),
        levels=4,
        inside=of_arguments(clipped=lambda law, stretch, normal: (law, stretch, 1.0)),
    ),
    friction(
        name="contact-limit-without-damping",
        sentence="Coulomb's limit ignores the normal force of the dashpot.",
        on=("scrape",),
        sees=("error", "omega1.z"),
        levels=4,
        inside=_without_damping,
    ),
    friction(
        name="contact-limit-late",
        sentence="Coulomb's limit uses the normal force of the previous step.",
        on=("scrape",),
        sees=("contact-impulse", "cone"),
        inside=_previous_normal,
    ),
    friction(
        name="contact-limit-half-more",
        sentence="Coulomb's limit is 50 % too large.",
        on=("scrape",),
        sees=("contact-impulse", "cone"),
        before=of_elements(Contact, friction=scaled(1.5)),
    ),
    friction(
        name="contact-friction-viscous",
        sentence="Friction is viscous instead of dry: it is proportional to the slip.",
        on=("scrape",),
        sees=("error", "omega1.z"),
        levels=4,
        inside=of_parts(
            sliding_friction=lambda law, normal, slip, stopping: vec.times(
                -law.friction * max(normal, 0.0), slip
            )
        ),
    ),
    friction(
        name="slip-of-the-end",
        sentence="The tangential spring is stretched by the slip at the end of the step.",
        on=("sticker",),
        levels=6,
        sees=("order", "state"),
        inside=of_parts(stretched=lambda s, before, now, h: vec.moved(s, h, now)),
    ),
    friction(
        name="slip-of-spins-alone",
        sentence=(
            "Friction opposes the part of the slip that is due to spins, not the whole slip."
        ),
        on=("sticker",),
        sees=("error", "omega1.z"),
        levels=5,
        inside=of_parts(slip=lambda velocity, spin, normal: vec.cross(spin, normal)),
    ),
    friction(
        name="spring-forgets",
        sentence="The tangential spring is reset in every step.",
        on=("sticker",),
        sees=("error", "omega1.z"),
        levels=6,
        inside=of_arguments(stretched=lambda s, before, now, h: (vec.ZERO, before, now, h)),
    ),
    friction(
        name="spring-slides-at-once",
        sentence="A tangential spring that sticks starts to slide at half of Coulomb's limit.",
        on=("gripper",),
        sees=("error", "omega1.z"),
        levels=6,
        before=of_elements(Contact, friction=scaled(0.5)),
    ),
    friction(
        name="friction-off-by-a-millionth",
        sentence="The coefficient of friction is rounded to six digits.",
        on=("along-wall",),
        sees=("contact-impulse", "sliding"),
        before=of_elements(Contact, friction=scaled(1 - 1e-6)),
    ),
)
