"""Energy: hidden dissipation, forces that do not come from their potential, gravity."""

from functools import partial
from typing import Any

from refdem.faults.change import Inside, of_elements, of_force, of_results, scaled
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

energy = partial(Fault, kind="energy", on=("oscillator",))


def _damped(rate: float) -> Inside:
    """Velocities decay at a `rate` [1/s]: each kick by h is followed by v <- (1 - rate |h|) v."""

    def inside(sound: Parts) -> dict[str, Any]:
        def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
            return vec.times(1 - rate * abs(h), sound.kicked(v, force, mass, h))

        return {"kicked": kicked}

    return inside


def _power(exponent: float) -> Inside:
    """The attraction falls with another power n of the distance: F = -m gm r/r^(n+1)."""

    def attraction(field: Any, t: Any, mass: Any, r: Any, v: Any) -> Any:
        return vec.times(-mass * field.gm / vec.size(r) ** (exponent + 1), r)

    return of_force(CentralField, lambda sound: attraction)


def _softened(length: float) -> Inside:
    """The attraction is softened at short distance: F = -m gm r/(r^2 + length^2)^(3/2)."""

    def attraction(field: Any, t: Any, mass: Any, r: Any, v: Any) -> Any:
        return vec.times(-mass * field.gm / (vec.dot(r, r) + length**2) ** 1.5, r)

    return of_force(CentralField, lambda sound: attraction)


def _too_heavy(field: Any, t: Any, mass: Any, r: Any, v: Any) -> Any:
    """The weight F = (m + 1/4 kg) g: that of a quarter of a kilogram more."""
    return vec.times(0.25 + mass, field.g)


def _hardening(sound: Any) -> Any:
    """The force times 1 + 0.01 |d|^2: the spring is 1 % stiffer at the distance 1 m of its ends."""

    def force(spring: Any, t: Any, d: Any, w: Any) -> Any:
        return vec.times(1 + 0.01 * vec.dot(d, d), sound(spring, t, d, w))

    return force


def _swirling(sound: Any) -> Any:
    """The spring also pushes across the radius, by 1e-3 e_z x d, a force without a potential."""

    def force(spring: Any, t: Any, d: Any, w: Any) -> Any:
        across = (-d[1], d[0], 0.0)
        return vec.moved(sound(spring, t, d, w), 1e-3, across)

    return force


def _clamped(v: Any) -> Any:
    """The velocity with each component limited to 1/2 m/s."""
    return tuple(min(0.5, max(-0.5, x)) for x in v)


def _one_sided(sound: Any) -> Any:
    """The spring pulls where x > 0 only."""

    def force(spring: Any, t: Any, d: Any, w: Any) -> Any:
        if d[0] > 0:
            return sound(spring, t, d, w)
        return vec.ZERO

    return force


def _softer_wall(sound: Parts) -> dict[str, Any]:
    """The overlap with a wall, which has no radius b, is reduced by a thousandth."""

    def overlap(a: Any, b: Any, distance: Any) -> Any:
        depth = sound.overlap(a, b, distance)
        if b:
            return depth
        return depth * 0.999

    return {"overlap": overlap}


def _dragged(sound: Any) -> Any:
    """A weak drag -1e-3 (d - d_before), from the displacement since the last evaluation."""
    place_before: Any = None

    def force(spring: Any, t: Any, d: Any, w: Any) -> Any:
        nonlocal place_before
        way = vec.ZERO
        if place_before is not None:
            way = vec.minus(d, place_before)
        place_before = d
        return vec.moved(sound(spring, t, d, w), -1e-3, way)

    return force


FAULTS = (
    energy(
        name="hidden-damping",
        sentence="The motion is damped by 1e-3 per second, though the scene has no damping.",
        sees=("reversal", "reversed"),
        inside=_damped(1e-3),
    ),
    energy(
        name="hidden-damping-tiny",
        sentence="The motion is damped by 1e-9 per second, though the scene has no damping.",
        sees=("reversal", "reversed"),
        inside=_damped(1e-9),
    ),
    energy(
        name="hidden-damping-fourth-order",
        sentence="A drag acts that grows with the distance since the last evaluation.",
        method="rk4",
        levels=5,
        sees=("energy", "finest"),
        inside=of_force(Spring, _dragged),
    ),
    energy(
        name="exponent",
        sentence="The attraction decreases with the power 2.001 of the distance.",
        on=("orbit",),
        method="suzuki",
        sees=("error", "x"),
        levels=5,
        inside=_power(2.001),
    ),
    energy(
        name="exponent-one",
        sentence="The attraction decreases with the power 1 of the distance.",
        on=("orbit",),
        sees=("error", "x"),
        inside=_power(1.0),
    ),
    energy(
        name="softened",
        sentence="The attraction is softened at short distance, with a length of 0.01 m.",
        on=("orbit",),
        method="suzuki",
        sees=("error", "y"),
        levels=5,
        inside=_softened(0.01),
    ),
    energy(
        name="spring-one-sided",
        sentence="The spring acts on one side only.",
        sees=("error", "x"),
        inside=of_force(Spring, _one_sided),
    ),
    energy(
        name="spring-cubic",
        sentence="The spring hardens by 1 %.",
        method="suzuki",
        sees=("error", "x"),
        levels=4,
        inside=of_force(Spring, _hardening),
    ),
    energy(
        name="spring-twice",
        sentence="The spring acts twice.",
        sees=("error", "x"),
        before=of_elements(Spring, stiffness=scaled(2.0)),
    ),
    energy(
        name="spring-length",
        sentence="The spring has a natural length.",
        sees=("error", "x"),
        before=of_elements(Spring, length=lambda _: 0.125),
    ),
    energy(
        name="spring-swirls",
        sentence="The spring has a small transverse force, which has no potential.",
        on=("ellipse",),
        method="suzuki",
        sees=("angular-momentum", "total"),
        inside=of_force(Spring, _swirling),
    ),
    energy(
        name="gravity-sign",
        sentence="Gravity acts upwards.",
        on=("hanging",),
        sees=("error", "x"),
        before=of_elements(UniformGravity, g=scaled(-1.0)),
    ),
    energy(
        name="gravity-per-mass",
        sentence="The weight is that of a mass larger by 0.25 kg.",
        on=("hanging",),
        sees=("error", "x"),
        inside=of_force(UniformGravity, lambda sound: _too_heavy),
    ),
    energy(
        name="gravity-missing",
        sentence="There is no gravity.",
        on=("swing",),
        sees=("error", "theta"),
        before=of_elements(UniformGravity, g=scaled(0.0)),
    ),
    energy(
        name="gravity-axis",
        sentence="Gravity acts along another axis.",
        on=("swing",),
        sees=("error", "theta"),
        before=of_elements(UniformGravity, g=lambda g: (g[1], g[0], g[2])),
    ),
    energy(
        name="attraction-of-two-masses",
        sentence="The parameter gm is multiplied by the reduced mass.",
        on=("orbit",),
        sees=("error", "vx"),
        before=of_elements(CentralField, gm=scaled(0.5)),
    ),
    energy(
        name="speed-limit",
        sentence="Velocities are limited to half of what the motion needs.",
        on=("ellipse",),
        sees=("error", "vy"),
        inside=of_results(kicked=_clamped),
    ),
    energy(
        name="rest-disturbed",
        sentence="The contact force has a relative error of 1e-9.",
        on=("resting",),
        sees=("rest", "speed"),
        inside=of_results(normal_force=scaled(1 + 1e-9)),
    ),
    energy(
        name="rest-sinks",
        sentence="The wall is softer than the spheres.",
        on=("resting",),
        sees=("rest", "displacement"),
        inside=_softer_wall,
    ),
    energy(
        name="free-body-slows",
        sentence="A free body slows down by 1e-9 per second.",
        on=("flyer",),
        sees=("momentum", "total"),
        inside=_damped(1e-9),
    ),
)
