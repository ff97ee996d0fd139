"""Time and position at which dry friction stops a body for ever."""

from collections.abc import Mapping
from math import hypot, sqrt

import numpy as np

from refdem.core.check import Check, CompletedRun, Subject
from refdem.core.finding import Finding
from refdem.core.judgement import certified, judged, no_truth, undecided
from refdem.core.trajectory import Trajectory
from refdem.core.variant import Variant
from refdem.scene import Polyhedron, Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

SLIDE_ROOM = 2.0
"""Factor on the distance of a last half cycle, for methods whose steps are not short compared with
it.
"""


class Stop(Check):
    """Position and time of the stop at the finest level, and no creep afterwards.

    A body stops where k|x| <= f. Where a stop lies at the edge |x| = f/k of that range, the error
    of a method decides whether its body stops there too or slides on through half a cycle, and both
    are right. So creep is bounded by the distance that a body slides from its state at the first
    sample after the stop (`_slide`), which is 0 if it is at rest inside the range. A block on a
    floor may also creep by the error of the state, while its contact settles: contact solvers
    iterate and separate bodies that overlap.
    """

    name = "stop"
    title = "Stop and sticking"
    kills = "a wrong friction force or sign, friction that lets a body creep, sgn(0) = 0"

    def applies(self, subject: Subject) -> str | None:
        """Scenes with dry friction that come to rest according to truth."""
        scene = subject.instance.scene
        has_block = bool(scene.all(Spring)) and _of_planes(scene) > 0
        if not scene.all(Slider) and not has_block:
            return "the scene has no dry friction"
        if subject.truth is not None and "stop_time" not in subject.truth.scalars:
            return "the body does not stop"
        return None

    def needs(self, subject: Subject) -> tuple[Variant, ...]:
        """The plain run at the finest level."""
        return (subject.finest,)

    def judge(self, subject: Subject, runs: Mapping[Variant, CompletedRun]) -> list[Finding]:
        """Three findings: stop position, stop time, and the distance crept afterwards."""
        truth = certified(subject)
        if truth is None:
            return [undecided(self.name, "stop", no_truth(subject))]
        stop, _ = truth.scalars["stop_time"]
        place, radius = truth.scalars["stop_position"]
        run = runs[subject.finest].trajectory
        t = subject.instance.times
        scales = subject.instance.scales
        if stop >= t[-1]:
            why = f"the run ends at t = {t[-1]:.4g} s, before the stop at {stop:.4g} s"
            return [undecided(self.name, "stop", why)]
        level = subject.levels[-1]
        allowed = float(subject.bound(level)[-1])
        rounding = subject.round_off(level)
        # An error of the state by its bound shifts the stop by at most that many tau.
        after = t > stop + allowed * scales.tau
        position_error = abs(float(run.position[-1, 0, 0]) - place) / scales.length
        settling = 0.0
        if subject.instance.scene.all(Contact):
            settling = allowed
        slide = 0.0
        creep = 0.0
        if after.any():
            # (max x - min x)/L after the stop.
            creep = float(np.ptp(run.position[after, 0, 0])) / scales.length
            slide = _slide(subject, run, int(np.argmax(after)), level) / scales.length
        position = judged(
            check=self.name,
            quantity="stop_position",
            value=max(0.0, position_error - radius),
            bound=allowed,
            unit="1",
            basis="the error bound of the state at the end of the run",
            what=(
                f"The distance of the final position from the true stop at x = {place:.6g}"
                " m, relative to L,"
            ),
        )
        time = self._time(subject, run, stop, place, allowed, rounding)
        crept = judged(
            check=self.name,
            quantity="creep",
            value=creep,
            bound=rounding + slide + settling,
            unit="1",
            basis=(
                "a sticking body stays where it is, since Sgn(0) = [-1, 1], to round-off"
                f" c u sqrt(n){_of_slide(slide)}{_of_settling(settling)}"
            ),
            what="The distance crept after the stop, relative to L,",
        )
        return [position, time, crept]

    def _time(
        self,
        subject: Subject,
        run: Trajectory,
        stop: float,
        place: float,
        allowed: float,
        rounding: float,
    ) -> Finding:
        """The finding on the stop time: the last sample at which the body moves visibly.

        A stop that the engine itself reports is judged by the check `event-times`.
        """
        t = subject.instance.times
        scales = subject.instance.scales
        visible = max(allowed, rounding)
        moving_samples = np.flatnonzero(np.abs(run.velocity[:, 0, 0]) / scales.speed > visible)
        if len(moving_samples):
            observed = t[moving_samples[-1]]
        else:
            observed = 0.0
        invisible_time = _invisible_time(subject, visible * scales.speed, place)
        # Sampling interval plus the time in which the motion is invisible.
        slack = subject.instance.problem.interval + invisible_time
        return judged(
            check=self.name,
            quantity="stop_time",
            value=abs(observed - stop) / scales.tau,
            bound=allowed + slack / scales.tau,
            unit="1",
            basis=(
                "the error bound of the state, plus the sampling interval, plus the time"
                " in which friction stops the smallest visible speed"
            ),
            what=(
                "The error of the stop time (the last moving sample, compared with"
                f" {stop:.6g} s), in units of tau,"
            ),
        )


def friction_force(scene: Scene) -> float:
    """The largest force [N] of dry friction on what slides: of sliders, or of a plane on which a
    block lies, pressed by its weight.
    """
    # f = sum of mu N over sliders, plus sum of mu m (-g . n) over planes.
    of_sliders = sum(slider.friction * slider.normal_force for slider in scene.all(Slider))
    return float(of_sliders) + _of_planes(scene)


def _of_planes(scene: Scene) -> float:
    """The friction force [N] of rigid planes on a block of mass m, the sum of mu m max(0, -g . n);
    0 for other bodies.
    """
    bodies = scene.bodies
    laws = [law for law in scene.all(Contact) if law.law == "rigid"]
    if len(bodies) != 1 or not isinstance(bodies.shape[0], Polyhedron):
        return 0.0
    fields = [np.array(field.g) for field in scene.all(UniformGravity)]
    gravity = np.sum([np.zeros(3), *fields], axis=0)
    force = 0.0
    for law in laws:
        for plane in scene.all(Plane):
            # Normal force m (-g . n) and friction mu m max(0, -g . n).
            pressing = -float(gravity @ np.array(plane.normal))
            force += law.friction * float(bodies.mass[0]) * max(0.0, pressing)
    return force


def _slide(subject: Subject, run: Trajectory, sample: int, level: float) -> float:
    """Distance [m] that dry friction lets the body slide from its state (x, v) at a sample; 0 if it
    is at rest where k|x| <= f.

    Towards the middle it slides on a half cycle about the edge f/k. With the distance D = f/k - |x|
    to the edge, negative beyond it, and w = sqrt(k/m), it comes to rest after

        sqrt(D^2 + (v/w)^2) - D.

    SLIDE_ROOM times that is allowed, since steps are finite, and |v| h, the distance of one step.
    """
    scene = subject.instance.scene
    friction = friction_force(scene)
    stiffness = sum(spring.stiffness for spring in scene.all(Spring))
    mass = float(scene.bodies.mass.sum())
    x = float(run.position[sample, 0, 0])
    v = float(run.velocity[sample, 0, 0])
    if not stiffness:
        # Friction alone stops it after v^2/(2 f/m).
        return SLIDE_ROOM * mass * v * v / (2.0 * friction) + abs(v) * level
    # D = f/k - |x|,   v/w = |v|/sqrt(k/m),   distance = sqrt(D^2 + (v/w)^2) - D.
    to_edge = friction / stiffness - abs(x)
    of_speed = abs(v) / sqrt(stiffness / mass)
    distance = hypot(to_edge, of_speed) - to_edge
    return float(SLIDE_ROOM * distance + abs(v) * level)


def _of_slide(slide: float) -> str:
    """The clause on further sliding in the basis of the bound on creep."""
    if slide:
        return ", plus the way on which friction stops it from its first state after the stop"
    return ""


def _of_settling(settling: float) -> str:
    """The clause on a contact that settles in the basis of the bound on creep."""
    if settling:
        return ", plus the error bound of the state, by which a contact may settle"
    return ""


def _invisible_time(subject: Subject, speed: float, place: float) -> float:
    """Longest time [s] before the stop in which the motion may be invisible, because it is slower
    than `speed` [m/s].

    Near the stop v = a tau sin((t_stop - t)/tau), with a the deceleration at the stop, so that
    t_stop - t <= (pi/2) v/a, for sin(x) >= (2/pi) x. The error of the run may be `speed` itself, so
    that a visible motion is required only where truth is faster than 2 speed. If truth never is in
    the last half cycle (a tau <= 2 speed), all of it and the slow end of the half cycle before may
    be invisible: the bound is the time since truth was last faster than that, at least pi tau.
    """
    scene = subject.instance.scene
    friction = friction_force(scene)
    spring_force = sum(spring.stiffness * abs(place) for spring in scene.all(Spring))
    # a = (f - k |x_stop|)/m.
    deceleration = (friction - spring_force) / float(scene.bodies.mass.sum())
    tau = subject.instance.scales.tau
    visible_speed = 2 * speed
    # The largest speed of the last half cycle, a tau.
    fastest = deceleration * tau
    if fastest > visible_speed:
        # (pi/2) v/a with v = 2 speed.
        return float(np.pi / 2 * visible_speed / deceleration)
    # Never fast enough in the last half cycle, which lasts pi tau.
    longest = np.pi * tau
    truth = certified(subject)
    assert truth is not None
    if "v" in truth.values:
        fast = np.flatnonzero(np.abs(truth.value("v")) > visible_speed)
    else:
        fast = np.zeros(0, int)
    invisible_time = 0.0
    if len(fast):
        invisible_time = truth.scalars["stop_time"][0] - float(subject.instance.times[fast[-1]])
    return max(float(longest), invisible_time)


CHECK = Stop()
