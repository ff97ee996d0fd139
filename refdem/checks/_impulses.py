"""The change of velocities and spins by one impact of a sequence, from the last sample before it to
the first one after it, and the error that a correct method may make there.

Notation: n is the unit normal from the first body to the body or plane that it meets, c the closing
speed, s the slip of the points in contact, P the impulse on the first body. All are taken at the
instant, `wait` after the first sample, at which free flight from that sample brings the bodies into
contact. During a flight gravity g changes velocities by g t, and nothing else acts.
"""

from dataclasses import dataclass

import numpy as np

from refdem.checks._impacts import Array, Window, falling
from refdem.core.check import Subject
from refdem.core.refinement import turning
from refdem.core.trajectory import Trajectory
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane


@dataclass(frozen=True)
class Touch:
    """The instant at which bodies touch, `wait` [s] after a sample, and the normal (3,) there."""

    wait: float
    normal: Array


@dataclass(frozen=True)
class Struck:
    """One impact as seen in the samples of a run.

    `closing` and `parting` [m/s] are the speeds along the normal right before and after it, `slip`
    (3,) [m/s] is that of the surfaces before it, `impulse` (3,) [N s] is P, `spun` (N, 3) [N m s]
    is the change J dw of the bodies' angular momentum. `fastest` [m/s] bounds every relative speed
    of two points of the surfaces.
    """

    window: Window
    normal: Array
    closing: float
    parting: float
    slip: Array
    impulse: Array
    spun: Array
    fastest: float


@dataclass(frozen=True)
class Bodies:
    """The constants of the colliding bodies, (N,) each: masses [kg], radii [m] and moments of
    inertia [kg m^2].
    """

    mass: Array
    radius: Array
    inertia: Array

    @property
    def normal_mass(self) -> float:
        """m_n = 1/(1/m1 + 1/m2) [kg]."""
        return 1.0 / float(np.sum(1.0 / self.mass))

    @property
    def tangential_mass(self) -> float:
        """m_t = 1/(1/m1 + 1/m2 + R1^2/J1 + R2^2/J2) [kg]; a body without J does not turn."""
        turns = self.inertia > 0
        eased = np.sum(self.radius[turns] ** 2 / self.inertia[turns])
        return 1.0 / float(np.sum(1.0 / self.mass) + eased)


def bodies_of(scene: Scene, window: Window) -> Bodies:
    """The bodies of an impact."""
    numbers = list(window.impact.bodies)
    columns = scene.bodies
    return Bodies(columns.mass[numbers], columns.radius[numbers], columns.inertia[numbers, 0])


def touch(scene: Scene, run: Trajectory, window: Window) -> Touch | None:
    """The touch of the bodies in free flight from the first sample; None if they do not meet."""
    numbers = list(window.impact.bodies)
    place = run.position[window.first, numbers]
    velocity = run.velocity[window.first, numbers]
    if len(numbers) == 1:
        return _on_plane(scene, place[0], velocity[0], float(scene.bodies.radius[numbers[0]]))
    reach = float(scene.bodies.radius[numbers].sum())
    return _of_pair(place[1] - place[0], velocity[1] - velocity[0], reach)


def _on_plane(scene: Scene, place: Array, velocity: Array, radius: float) -> Touch | None:
    """The first touch of a sphere that falls on the planes of a scene."""
    found: list[Touch] = []
    for plane in scene.all(Plane):
        away = np.array(plane.normal)
        height = float((place - np.array(plane.point)) @ away) - radius
        descent = -float(velocity @ away)
        pull = -float(falling(scene) @ away)
        # The first root t > 0 of height = w t + a t^2/2, with the speed of descent w and the part a
        # of gravity towards the plane:
        #   t = 2 height/(w + q) if w > 0,   t = (q - w)/a otherwise,   q = sqrt(w^2 + 2 a height).
        # Neither form subtracts nearly equal numbers.
        squared = descent**2 + 2.0 * pull * height
        if squared <= 0.0:
            continue
        root = float(np.sqrt(squared))
        if descent > 0.0:
            found.append(Touch(2.0 * height / (descent + root), -away))
        elif pull > 0.0:
            found.append(Touch((root - descent) / pull, -away))
    return min(found, key=lambda one: one.wait, default=None)


def _of_pair(apart: Array, relative: Array, reach: float) -> Touch | None:
    """The touch of two spheres. Relative to the first the second moves along a straight line, since
    gravity accelerates both equally.
    """
    nearing = -float(apart @ relative)
    if nearing <= 0.0:
        return None
    # The first root of |d + w t| = R, with the relative position d and velocity w:
    #   t = k/(b + sqrt(q)),   b = -d.w,   k = (|d| - R)(|d| + R),   q = w^2 R^2 - |d x w|^2.
    distance = float(np.linalg.norm(apart))
    swept = np.cross(apart, relative)
    squared = reach**2 * float(relative @ relative) - float(swept @ swept)
    if squared <= 0.0:
        return None
    wait = (distance - reach) * (distance + reach) / (nearing + np.sqrt(squared))
    return Touch(float(wait), (apart + wait * relative) / reach)


def struck(scene: Scene, run: Trajectory, window: Window) -> Struck | None:
    """The change by the impact of a window; None if free flight does not bring the bodies together
    in it.
    """
    found = touch(scene, run, window)
    lasting = float(run.t[window.last] - run.t[window.first])
    if found is None or not 0.0 <= found.wait <= lasting:
        return None
    numbers = list(window.impact.bodies)
    bodies = bodies_of(scene, window)
    pull = falling(scene)
    normal = found.normal
    # v_before = v(first) + g wait,  v_after = v(last) - g (t_last - t_first - wait)
    before = run.velocity[window.first, numbers] + pull * found.wait
    after = run.velocity[window.last, numbers] - pull * (lasting - found.wait)
    omega = run.omega[[window.first, window.last]][:, numbers]
    # Relative velocity of the points in contact: v_12 + (R_1 w_1 + R_2 w_2) x n, v_12 = v_1 - v_2.
    surface = np.sum(bodies.radius[:, None] * omega[0], axis=0)
    approach = _relative(before) + np.cross(surface, normal)
    # c = v_12.n before, parting = -v_12.n after; P = m_1 dv_1, and J_i dw_i of each body
    closing = float(approach @ normal)
    parting = -float(_relative(after) @ normal)
    impulse = bodies.mass[0] * (after[0] - before[0])
    spun = bodies.inertia[:, None] * (omega[1] - omega[0])
    # fastest = |v_12| + sum R_i |w_i|
    spinning = float(bodies.radius @ np.linalg.norm(omega[0], axis=-1))
    fastest = float(np.linalg.norm(_relative(before))) + spinning
    return Struck(
        window=window,
        normal=normal,
        closing=closing,
        parting=parting,
        slip=approach - closing * normal,
        impulse=impulse,
        spun=spun,
        fastest=fastest,
    )


def _relative(velocity: Array) -> Array:
    """The velocity (3,) of the first of two bodies against the second, or of one against a
    plane.
    """
    if len(velocity) == 1:
        alone: Array = velocity[0]
        return alone
    between: Array = velocity[0] - velocity[1]
    return between


def lateness(subject: Subject, window: Window) -> float:
    """The delay [s] between the touch of the flights and the step that applies the impact: 0 where
    events are located, else one step; with a tolerance the bound on the event time.
    """
    method = subject.method
    if method.control == "tolerance":
        return window.late_by
    if method.control == "exact" or method.locates_events:
        return 0.0
    return subject.levels[-1]


def off(subject: Subject, run: Trajectory, found: Struck, pull: float) -> float:
    """The error [m/s] that a speed of the impact may have, in a direction in which gravity has the
    part `pull` [m/s^2].

    w is `fastest`, c the closing speed, R the sum of radii, t the lateness and h the step.

    - A delay t adds the velocity g t, and a method of order below 2 another g h.
    - During a delay t the normal of two spheres turns by a = w t/R, which changes the components of
      an impulse of up to 2 w per effective mass by up to 2 w a (1 + a).
    - A rounding d of positions delays the touch by d/c, which adds g d/c, and turns the normal by
      (d/R) max(1, w/c): by more than d/R where spheres nearly pass each other.
    - Velocities are rounded.
    """
    scene = subject.instance.scene
    numbers = list(found.window.impact.bodies)
    late = lateness(subject, found.window)
    detection_delay = 0.0
    if subject.method.control == "step" and subject.method.order < 2:
        detection_delay = subject.levels[-1]
    noise = subject.noise(subject.levels[-1])
    of_speeds = noise
    if not falling(scene).any():
        # Without a force nothing is added to a velocity step by step.
        of_speeds = subject.round_off(subject.levels[-1])
    rows = [found.window.first, found.window.last]
    speeds = float(np.linalg.norm(run.velocity[rows][:, numbers], axis=-1).sum())
    places = float(np.linalg.norm(run.position[found.window.first, numbers], axis=-1).sum())
    reach = float(scene.bodies.radius[numbers].sum())
    rounded = noise * (places + reach)
    # u (sum |v| + w) + g (t + h + d/c)
    total = of_speeds * (speeds + found.fastest) + pull * (
        late + detection_delay + rounded / found.closing
    )
    if len(numbers) == 2 and "dimension:1" not in scene.features:
        # a = (w t + d max(1, w/c))/R;  2 w a (1 + a)
        steep = max(1.0, found.fastest / found.closing)
        turned = (late * found.fastest + rounded * steep) / reach
        total += 2.0 * found.fastest * turned * (1.0 + turned)
    return total


def pulls(scene: Scene, found: Struck) -> tuple[float, float]:
    """The parts of gravity along and across the normal [m/s^2]."""
    pull = falling(scene)
    along = float(pull @ found.normal)
    return abs(along), float(np.linalg.norm(pull - along * found.normal))


def spin_noise(subject: Subject) -> float:
    """Relative round-off of a spin: that of a velocity, and that of rotating its axes."""
    level = subject.levels[-1]
    return subject.noise(level) + turning(subject.instance, subject.method, level)


def by_law(scene: Scene, found: Struck) -> Array:
    """The impulse P_t (3,) [N s] across the normal according to the law.

        P_t = -min((1 + b) m_t, mu p/|s|) s,   p = (1 + e) m_n c.

    The first is the impulse that changes the slip s to -b s, b the slip restitution; friction
    limits its size to mu p, p the impulse along the normal.
    """
    law = scene.all(Contact)[0]
    bodies = bodies_of(scene, found.window)
    wanted = (1.0 + law.slip_restitution) * bodies.tangential_mass * found.slip
    pressing = (1.0 + law.restitution) * bodies.normal_mass * found.closing
    limit = law.friction * pressing
    size = float(np.linalg.norm(wanted))
    if size > limit:
        wanted = wanted * (limit / size)
    against: Array = -wanted
    return against
