"""Contact: overlap, stiffness, damping, cut-off, reaction, radii, and the springs of the tangential
force.
"""

from dataclasses import replace
from functools import partial
from typing import Any

from refdem.core.problem import Request
from refdem.faults.change import of_arguments, of_elements, of_parts, of_results, scaled
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact

contact = partial(Fault, kind="contact")
EPSILON = 1e-9
"""Relative error of the reaction: momentum drifts by it, which is far above round-off and far below
the error of any method.
"""


def _late_damping(sound: Parts) -> dict[str, Any]:
    """All forces that depend on velocity use those of the step before."""

    def loads(world: Any, state: Any, parts: Parts, before: Any = None, h: Any = 0.0) -> Any:
        if before is None:
            return sound.loads(world, state, parts)
        old = state.copy()
        # v(t - h) = v - h F/m to first order, with the forces of the start of the step.
        for i, force in enumerate(before.force):
            old.v[i] = vec.moved(state.v[i], -h / world.mass[i], force)
        return sound.loads(world, old, parts, before, h)

    return {"loads": loads}


def _old_normal(sound: Parts) -> dict[str, Any]:
    """The direction between two spheres is that of the step before, and their distance that of this
    step.
    """
    way_back = vec.ZERO

    def loads(world: Any, state: Any, parts: Parts, before: Any = None, h: Any = 0.0) -> Any:
        nonlocal way_back
        # r(t - h) = r - h (v_1 - v_0) to first order, with r = r_1 - r_0.
        way_back = vec.times(-h, vec.minus(state.v[1], state.v[0]))
        loads_now = sound.loads(world, state, parts, before, h)
        way_back = vec.ZERO
        return loads_now

    def away(a: Any, b: Any) -> Any:
        branch = sound.away(a, b)
        old_branch = vec.plus(branch, way_back)
        # |r| r_old/|r_old|.
        return vec.times(vec.size(branch) / vec.size(old_branch), old_branch)

    return {"loads": loads, "away": away}


def _hertz(law: Any, depth: Any, rate: Any) -> Any:
    """F = 4 k d^(3/2) + c d' in place of k d + c d'; with the factor 4 m^(-1/2) both laws agree at
    the overlap d = 1/16 m.
    """
    return law.stiffness * 4 * max(depth, 0.0) ** 1.5 + law.damping * rate


def _larger_radii(request: Request) -> Request:
    """The request with all radii 1 % larger."""
    radii = request.problem.scene.bodies.radius.tolist()
    return _with_shapes(request, tuple(Sphere(radius=1.01 * radius) for radius in radii))


def _swapped_shapes(request: Request) -> Request:
    """The request with its shapes in the other order."""
    return _with_shapes(request, request.problem.scene.bodies.shape[::-1])


def _with_shapes(request: Request, shapes: Any) -> Request:
    """The request with other shapes of the bodies."""
    scene = request.problem.scene
    bodies = replace(scene.bodies, shape=shapes)
    return request.with_scene(Scene(bodies, scene.elements))


FAULTS = (
    contact(
        name="stiffness-in-series",
        sentence=(
            "The stiffness of the pair is given to each sphere, and both act in series: half"
            " of it results."
        ),
        on=("knock",),
        sees=("error", "r1.x"),
        before=of_elements(Contact, stiffness=scaled(0.5)),
    ),
    contact(
        name="stiffness-two-percent",
        sentence="The stiffness is 2 % too small.",
        on=("bounce",),
        sees=("error", "v1.x"),
        levels=5,
        before=of_elements(Contact, stiffness=scaled(0.98)),
    ),
    contact(
        name="damping-doubled",
        sentence="Damping is applied twice, once for each body.",
        on=("knock",),
        sees=("error", "v1.x"),
        before=of_elements(Contact, damping=scaled(2.0)),
    ),
    contact(
        name="damping-by-one-mass",
        sentence=("The damping constant uses the mass of one body instead of the effective mass."),
        on=("parting",),
        sees=("error", "v2.x"),
        levels=4,
        before=of_elements(Contact, damping=scaled(1.4)),
    ),
    contact(
        name="damping-sign",
        sentence="The dashpot drives.",
        on=("knock",),
        sees=("energy", "balance"),
        inside=of_arguments(normal_force=lambda law, depth, rate: (law, depth, -rate)),
    ),
    contact(
        name="damping-on-approach-only",
        sentence="The dashpot acts during approach only.",
        on=("knock",),
        sees=("error", "v1.x"),
        levels=4,
        inside=of_arguments(normal_force=lambda law, depth, rate: (law, depth, max(rate, 0.0))),
    ),
    contact(
        name="damping-late",
        sentence="The dashpot uses the velocity of the previous step.",
        on=("knock",),
        levels=6,
        sees=("order", "state"),
        inside=_late_damping,
    ),
    contact(
        name="cutoff-never-pulls",
        sentence=(
            "The contact ends where the force becomes attractive; by the law it ends with the"
            " overlap."
        ),
        on=("knock",),
        sees=("error", "v1.x"),
        levels=5,
        before=of_elements(Contact, cutoff=lambda _: "zero_force"),
    ),
    contact(
        name="cutoff-pulls",
        sentence=(
            "The force is attractive before the overlap ends; by the law it is never attractive."
        ),
        on=("parting",),
        sees=("error", "v2.x"),
        levels=6,
        before=of_elements(Contact, cutoff=lambda _: "zero_overlap"),
    ),
    contact(
        name="overlap-half",
        sentence="Only half of the overlap is used, as if each sphere had one half.",
        on=("bounce",),
        sees=("error", "r2.x"),
        inside=of_results(overlap=lambda found: found / 2),
    ),
    contact(
        name="overlap-of-diameters",
        sentence="Contact begins before the surfaces touch: the radius is 1 % too large.",
        on=("bounce",),
        sees=("error", "v1.x"),
        before=_larger_radii,
    ),
    contact(
        name="law-of-hertz",
        sentence="The linear law has the exponent 3/2 of Hertz's law.",
        on=("bounce",),
        sees=("error", "v1.x"),
        inside=of_parts(normal_force=_hertz),
    ),
    contact(
        name="no-reaction",
        sentence="The force acts on one body only.",
        on=("bounce",),
        sees=("momentum", "total"),
        inside=of_parts(reaction=lambda force: vec.ZERO),
    ),
    contact(
        name="reaction-twice",
        sentence="The reaction force is added twice.",
        on=("bounce",),
        sees=("momentum", "total"),
        inside=of_parts(reaction=lambda force: vec.times(-2.0, force)),
    ),
    contact(
        name="reaction-unequal",
        sentence="Action and reaction differ by one part in 1e9.",
        on=("bounce",),
        sees=("momentum", "total"),
        inside=of_parts(reaction=lambda force: vec.times(-1.0 - EPSILON, force)),
    ),
    contact(
        name="normal-not-unit",
        sentence=("The normal is 10 % too long: it was not divided by its length."),
        on=("knock",),
        sees=("error", "v1.x"),
        inside=of_results(normal_force=scaled(1.1)),
    ),
    contact(
        name="normal-of-the-step-before",
        sentence="The normal is that of the previous step (Vyas).",
        on=("scrape",),
        levels=6,
        sees=("order", "state"),
        inside=_old_normal,
    ),
    contact(
        name="radii-swapped",
        sentence="Each body has the lever arm of the other.",
        on=("bristle",),
        sees=("error", "omega1.z"),
        before=_swapped_shapes,
    ),
    contact(
        name="spring-late",
        sentence=(
            "The tangential spring is stretched by the slip of the previous step (Lethe 300)."
        ),
        on=("sticker",),
        levels=6,
        sees=("order", "state"),
        inside=of_parts(stretched=lambda s, before, now, h: vec.moved(s, h, before)),
    ),
    contact(
        name="spring-stiffness-of-the-normal",
        sentence=(
            "The tangential spring has the stiffness of the normal one, so that Coulomb's limit"
            " is reached earlier."
        ),
        on=("bristle",),
        levels=4,
        sees=("error", "omega1.z"),
        inside=of_parts(spring_friction=lambda law, s: vec.times(-law.stiffness, s)),
    ),
    contact(
        name="spring-not-turned",
        sentence="The tangential spring is not rotated with the contact.",
        on=("soft",),
        levels=6,
        sees=("error", "v1.x"),
        inside=of_parts(transported=lambda stretch, old, normal: stretch),
    ),
)
