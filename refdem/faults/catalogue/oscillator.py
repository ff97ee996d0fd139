"""Oscillators: damping and its sign, drives and their clock, powers of a spring, van der Pol's
dashpot.
"""

from dataclasses import replace
from functools import partial
from math import pi
from typing import Any

import msgspec
import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.change import late_force, of_elements, of_force, of_results, scaled
from refdem.faults.fault import Fault
from refdem.mechanics import vectors as vec
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring

oscillator = partial(Fault, kind="oscillator", sees=("error", "x"))


def _per_mass(request: Request) -> Request:
    """Amplitudes of forces are taken for accelerations."""
    mass = float(request.problem.scene.bodies.mass[0])
    return of_elements(Force, amplitude=scaled(mass))(request)


def _restarted(request: Request) -> Request:
    """Forces count time from the start t0: cos(w (t - t0) + phase) instead of cos(w t + phase)."""
    start = float(request.problem.times[0])
    scene = request.problem.scene
    elements = list(scene.elements)
    for number, force in enumerate(elements):
        if isinstance(force, Force):
            phase = force.phase + force.frequency * start
            elements[number] = msgspec.structs.replace(force, phase=phase)
    return request.with_scene(Scene(scene.bodies, tuple(elements)))


def _stays(request: Request, run: Trajectory) -> Trajectory:
    """The motion continues at the frequency of the drive, with the amplitude and phase of the
    initial state.
    """
    (force,) = request.problem.scene.all(Force)
    w = force.frequency
    x0 = run.position[0, 0, 0]
    v0 = run.velocity[0, 0, 0]
    # x = x0 cos(w t) + v0/w sin(w t),   v = v0 cos(w t) - w x0 sin(w t).
    turned = w * (run.t - run.t[0])
    position = run.position.copy()
    velocity = run.velocity.copy()
    position[:, 0, 0] = x0 * np.cos(turned) + v0 / w * np.sin(turned)
    velocity[:, 0, 0] = v0 * np.cos(turned) - w * x0 * np.sin(turned)
    return replace(run, position=position, velocity=velocity)


def _last_force(request: Request) -> Request:
    """The request with the last of its forces alone, as from a table with one entry a body."""
    scene = request.problem.scene
    dropped = scene.all(Force)[:-1]
    kept = tuple(element for element in scene.elements if element not in dropped)
    return request.with_scene(Scene(scene.bodies, kept))


def _odd_square(sound: Any) -> Any:
    """The quadratic term of the spring is k2 s |s| in place of k2 s^2: its sign changes where the
    spring is shorter than its natural length.
    """

    def force(spring: Any, t: Any, d: Any, w: Any) -> Any:
        # For s < 0 the pull changes by -2 k2 s^2, along d/|d|.
        distance = vec.size(d)
        shortening = min(0.0, distance - spring.length)
        change = 2 * spring.quadratic * shortening * shortening / distance
        return vec.moved(sound(spring, t, d, w), change, d)

    return force


def _within_512_metres(place: Any) -> Any:
    """The place with each component cut off at 512 m."""
    return tuple(min(max(x, -512.0), 512.0) for x in place)


FAULTS = (
    oscillator(
        name="damping-drives",
        sentence="The force of the dashpot acts in the direction of the velocity.",
        on=("viscous",),
        sees=("energy", "balance"),
        before=of_elements(Dashpot, damping=scaled(-1.0)),
    ),
    oscillator(
        name="damping-delta-for-b",
        sentence=(
            "The parameter delta is used as b/m instead of b/(2 m): half of the damping is missing."
        ),
        on=("viscous",),
        before=of_elements(Dashpot, damping=scaled(0.5)),
    ),
    oscillator(
        name="damping-one-percent",
        sentence="The damping is 1 % too strong.",
        on=("viscous",),
        levels=5,
        before=of_elements(Dashpot, damping=scaled(1.01)),
    ),
    oscillator(
        name="dashpot-late",
        sentence="The dashpot uses the velocity of the previous evaluation.",
        on=("viscous",),
        method="rk4",
        sees=("order", "state"),
        inside=late_force(Dashpot),
    ),
    oscillator(
        name="dashpot-late-unproved",
        sentence=(
            "The dashpot uses the velocity of the previous evaluation, in a motion without"
            " certified values."
        ),
        on=("unproved",),
        method="rk4",
        sees=("convergence", "state"),
        inside=late_force(Dashpot),
    ),
    oscillator(
        name="drive-per-mass",
        sentence="The amplitude of the force is used as an acceleration.",
        on=("driven",),
        before=_per_mass,
    ),
    oscillator(
        name="drive-sine",
        sentence="The drive is a sine instead of a cosine.",
        on=("driven",),
        before=of_elements(Force, phase=lambda phase: phase - pi / 2),
    ),
    oscillator(
        name="drive-in-hertz",
        sentence="The angular frequency of the drive is used as a frequency in hertz.",
        on=("driven",),
        before=of_elements(Force, frequency=scaled(2 * pi)),
    ),
    oscillator(
        name="drive-restarts",
        sentence="The time of the drive is counted from the start of the run.",
        on=("driven",),
        sees=("symmetry", "delayed"),
        before=_restarted,
    ),
    oscillator(
        name="drive-late",
        sentence="The drive is that of the previous evaluation.",
        on=("driven",),
        sees=("order", "state"),
        inside=late_force(Force),
    ),
    oscillator(
        name="cube-sign",
        sentence="The cube of the stretch acts the other way.",
        on=("hardening",),
        before=of_elements(Spring, cubic=scaled(-1.0)),
    ),
    oscillator(
        name="cube-potential",
        sentence="The cubic term has the factor 1/4 of its potential.",
        on=("hardening",),
        before=of_elements(Spring, cubic=scaled(0.25)),
    ),
    oscillator(
        name="response-stays",
        sentence="The motion stays near the middle one of three amplitudes, which is unstable.",
        on=("middle",),
        method="rk4",
        after=_stays,
    ),
    oscillator(
        name="third-harmonic-sign",
        sentence="The cubic term has the wrong sign, and so has the third harmonic.",
        on=("tripling",),
        levels=5,
        sees=("spectrum", "3w"),
        before=of_elements(Spring, cubic=scaled(-1.0)),
    ),
    oscillator(
        name="third-harmonic-twice",
        sentence="The cubic term, and with it its spectral line, is twice as large.",
        on=("tripling",),
        levels=5,
        sees=("spectrum", "3w"),
        before=of_elements(Spring, cubic=scaled(2.0)),
    ),
    oscillator(
        name="third-harmonic-one-percent",
        sentence="The cubic term is 1 % too large.",
        on=("tripling",),
        levels=5,
        sees=("spectrum", "3w"),
        before=of_elements(Spring, cubic=scaled(1.01)),
    ),
    oscillator(
        name="square-odd",
        sentence="The quadratic term is s |s| instead of s^2.",
        on=("lopsided",),
        inside=of_force(Spring, _odd_square),
    ),
    oscillator(
        name="square-of-one-sign",
        sentence="The coefficient of the quadratic term is replaced by its absolute value.",
        on=("lopsided-down",),
        before=of_elements(Spring, quadratic=abs),
    ),
    oscillator(
        name="square-sign",
        sentence="The square of the stretch acts the other way.",
        on=("mixing",),
        sees=("spectrum", "shift"),
        before=of_elements(Spring, quadratic=scaled(-1.0)),
    ),
    oscillator(
        name="square-twice",
        sentence="The quadratic term, and with it its spectral lines, is twice as large.",
        on=("mixing",),
        sees=("spectrum", "2w1"),
        before=of_elements(Spring, quadratic=scaled(2.0)),
    ),
    oscillator(
        name="square-one-percent",
        sentence="The quadratic term is 1 % too large.",
        on=("mixing",),
        levels=5,
        sees=("spectrum", "w2-w1"),
        before=of_elements(Spring, quadratic=scaled(1.01)),
    ),
    oscillator(
        name="drives-overwritten",
        sentence="Of two drives of one body only the last one acts.",
        on=("mixing",),
        sees=("spectrum", "w1+w2"),
        before=_last_force,
    ),
    oscillator(
        name="drive-without-phase",
        sentence="The phase of the drive is omitted.",
        on=("cycle",),
        before=of_elements(Force, phase=lambda _: 0.0),
    ),
    oscillator(
        name="difference-line-turned",
        sentence=(
            "The phase of the drive is omitted, which changes the phase of the line at 2w-wd."
        ),
        on=("cycle-and-drive",),
        levels=5,
        sees=("spectrum", "2w-wd"),
        before=of_elements(Force, phase=lambda _: 0.0),
    ),
    oscillator(
        name="difference-line-weaker",
        sentence=(
            "The drive is half as large, which changes the line at 3w-2wd, proportional to"
            " its square."
        ),
        on=("cycle-and-drive",),
        method="rk4",
        levels=5,
        sees=("spectrum", "3w-2wd"),
        before=of_elements(Force, amplitude=scaled(0.5)),
    ),
    oscillator(
        name="small-world",
        sentence="Positions are limited to 512 m from the origin.",
        on=("far",),
        inside=of_results(drifted=_within_512_metres),
    ),
    oscillator(
        name="power-truncated",
        sentence="The exponent of the stretch is truncated to an integer.",
        on=("steep",),
        before=of_elements(Spring, exponent=lambda n: float(n // 1)),
    ),
    oscillator(
        name="nonlinearity-half",
        sentence="Half of the damping that depends on the position is missing.",
        on=("cycle",),
        before=of_elements(Dashpot, van_der_pol=scaled(0.5)),
    ),
    oscillator(
        name="nonlinearity-one-percent",
        sentence="The parameter mu is 1 % too large.",
        on=("cycle",),
        levels=5,
        before=of_elements(Dashpot, damping=scaled(1.01), van_der_pol=scaled(1.01)),
    ),
)
