"""Bounds and refinement: how large an error may be at a step, and which steps to take.

Every bound is relative: an error in units of a quantity's scale. With step h, order p, shortest
time tau, duration T, unit round-off u, number of steps n, and S(t), by which the motion itself
makes an earlier error grow,

    truncation  = C (1 + t/tau) (h/tau)^p
    round-off   = c u max(1, sqrt(n), T/tau)
    bound       = (truncation + round-off + clock + flight) S(t)

`clock` and `flight` are the roundings that add up in proportion to n, not to its root. `level` is
the step h [s], or the tolerance of a method that chooses its own steps.
"""

import math

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.engine import Method
from refdem.core.once import once_for_each
from refdem.core.problem import Motion
from refdem.core.truth import SampledTruth
from refdem.errors import UsageError
from refdem.mechanics.freedom import rod_jacobian
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.scene.singularity import JUMP, Singularity

Array = NDArray[np.float64]

ROUND_OFF_FACTOR = 8.0
"""c in c u sqrt(n): a step rounds some ten times, errors of random sign add as the square root, and
three sigma are allowed.
"""
HORIZON = 0.1
"""A run is scored up to the first time at which its bound exceeds this part of the scale."""
ORDER_LEVELS = 3
"""Levels that an order needs: two pairs, which must agree."""
COUNTING_FLOOR = 20.0
"""A level is used for the order as long as its bound is at least this many times round-off."""
IMPACT_STEPS = 2.0**15
"""Steps that the finest level of a motion with impacts takes at most."""
SHARP = 8.0
"""Factor below the horizon at which the coarsest level of a motion with impacts ends: the finest of
four, eight times finer, is then allowed 1/640 of what an impact changes at first order.
"""
TURN_ROUNDINGS = 3.0
"""Roundings by which the turns of a step stretch a vector: five of them, of half a rounding each,
all of one sign.

Measured: 0.8 a step for a sphere that spins about a tilted axis, turned in single precision about
its three axes in five turns.
"""
PLACE_ADDITIONS = 2.0
"""Additions to a place in a step: a leapfrog drifts twice, others add once."""
MOST_STEPS = 1e10
"""Largest number of steps that is accepted: no engine makes more of them within a day."""
CLOCK_STEPS = 4.0
"""Steps in one tau = 1/omega_max of a method that chooses its own steps: one of high order advances
the phase by a fraction of a radian a step.
"""
SCATTER = 1.0
"""Standard deviation, in octaves, of the error constant of a motion with kinks from step to step.

What a step that holds a kink adds is h^p times a polynomial in the place of the kink within the
step, which is as good as random. Measured: 0.9 for velocity Verlet across a field with two edges,
18 steps.
"""
KINK_HALVINGS = 2
"""Halvings of the finest step for the order of a motion with kinks: a mean over five octaves
distinguishes orders that single pairs do not.
"""
MEMORY = 4
"""Number of earlier steps that a multistep method uses. At the start they have to be made by
another rule.
"""
UNRESOLVED = 0.5
"""Relative truncation error of a single tau from which a step resolves nothing of the motion."""
TOLERANCE_FACTOR = 1e3
"""A tolerance is local: its error may add up to this many times itself (design: 1e3 tol S)."""


def round_off(instance: Instance, method: Method, steps: float) -> float:
    """Relative round-off after `steps` steps: c u sqrt(n), and not less than c u T/tau.

    The second part is the rounding of the parameters themselves: a frequency that is off by u is
    off in phase by u t. Of slender bodies that spin c is larger (`of_directions`), of spheres of
    little inertia that touch (`of_touching_spins`), and of rods that hardly fix what they hold
    (`of_rods`). Of velocities that are differences of places it is `of_differences` times as large.
    """
    # c u max(1, sqrt(n), T/tau).
    phase = instance.scales.duration / instance.scales.tau
    factor = max(
        ROUND_OFF_FACTOR,
        of_directions(instance),
        of_touching_spins(instance),
        of_rods(instance),
    )
    factor *= of_differences(instance, method, steps)
    return factor * method.round_off * max(1.0, math.sqrt(steps), phase)


def of_differences(instance: Instance, method: Method, steps: float) -> float:
    """Factor >= 1 by which a difference of places over a step h rounds a velocity more than another
    method does.

    A place r is rounded by u |r|, or by u L where that is more, and the difference of two of them
    over h by u |r|/h, which is (tau/h) max(1, |r|/L) times u L/tau.
    """
    far = max(1.0, farthest_place(instance) / instance.scales.length)
    # max(1, (tau/h) max(1, |r|/L)).
    return max(1.0, far * steps_of_differences(instance, method, steps))


def steps_of_differences(instance: Instance, method: Method, steps: float) -> float:
    """Steps h in a tau of a method whose velocities are differences of places over h; 0 of others.

    Such a velocity, in units of L/tau, is rounded tau/h times as much as the places in units of L.
    """
    if not method.differenced_velocities or method.control != "step":
        return 0.0
    step = instance.scales.duration / steps
    return instance.scales.tau / step


def farthest_place(instance: Instance) -> float:
    """Largest distance [m] of a coordinate of a body from the origin at the start; 0 where nothing
    moves.
    """
    problem = instance.problem
    if not isinstance(problem, Motion):
        return 0.0
    return float(np.max(np.abs(problem.scene.bodies.position), initial=0.0))


@once_for_each
def of_directions(instance: Instance) -> float:
    """Roundings of a spin that one rounding of an attitude makes: |L|/(I_min omega), the largest of
    any body; 0 where nothing spins at the start.

    A method may carry the angular momentum L, which is constant in space. An attitude that is off
    by u then has it off by u |L| in the axes of the body, and omega = I^-1 L by u |L|/I_min.
    """
    problem = instance.problem
    if not isinstance(problem, Motion):
        return 0.0
    bodies = problem.scene.bodies
    spins = np.any(bodies.omega != 0, axis=1) & np.all(bodies.inertia > 0, axis=1)
    if not spins.any():
        return 0.0
    # |L|/(I_min |omega|), with L = I omega in the axes of the body.
    moments = bodies.inertia[spins]
    omega = rotated(conjugate(bodies.attitude[spins]), bodies.omega[spins])
    momentum = np.linalg.norm(moments * omega, axis=1)
    return float(np.max(momentum / (moments.min(axis=1) * np.linalg.norm(omega, axis=1))))


@once_for_each
def of_touching_spins(instance: Instance) -> float:
    """Roundings of a spin that one rounding of a velocity makes where spheres touch: m R^2/J,
    the largest of any body; 0 without contacts.

    A tangential impulse m u v, one rounding of a velocity v, which a smooth contact leaves too,
    changes the spin by m u v R/J.
    """
    problem = instance.problem
    if not isinstance(problem, Motion):
        return 0.0
    if not problem.scene.all(Contact):
        return 0.0
    bodies = problem.scene.bodies
    turns = np.all(bodies.inertia > 0, axis=1)
    # m R^2/J_min.
    moments = bodies.inertia[turns].min(axis=1, initial=np.inf)
    ratio = bodies.mass[turns] * bodies.radius[turns] ** 2 / moments
    return float(np.max(ratio, initial=0.0))


@once_for_each
def of_rods(instance: Instance) -> float:
    """Roundings of a place that one rounding of the length of each rod makes; 0 without rods.

    Lengths that are off by s leave the bodies off by M^-1 G^T (G M^-1 G^T)^-1 s, G the directions
    of the rods. Of rods that lie nearly in a plane, as those of a flat cluster, that is many times
    s, across the plane.
    """
    problem = instance.problem
    if not isinstance(problem, Motion):
        return 0.0
    rods = problem.scene.all(Rod)
    if not rods:
        return 0.0
    lengths = np.array([rod.length for rod in rods])
    moved_by = np.abs(moved_by_lengths(problem.scene))
    return float(np.max(moved_by @ lengths) / instance.scales.length)


def moved_by_lengths(scene: Scene) -> Array:
    """The places M^-1 G^T (G M^-1 G^T)^-1 (3 bodies, rods) by which a scene moves where the
    lengths of its rods are off by one; accelerations, for second derivatives of the lengths.
    """
    weights = 1.0 / np.sqrt(np.repeat(scene.bodies.mass, 3))
    # With A = G M^-1/2 the matrix is M^-1/2 A^+.
    moved_by: Array = weights[:, None] * np.linalg.pinv(rod_directions(scene) * weights)
    return moved_by


@once_for_each
def start_acceleration(instance: Instance) -> float:
    """Largest acceleration [m/s^2] of a body: that at the start of bodies on rods, under their
    weight; L/tau^2 of others.

    Scales of rods of very unequal masses or lengths are those of the fastest motion that the
    energy allows, and the start may be far from it.
    """
    problem = instance.problem
    scales = instance.scales
    if not isinstance(problem, Motion) or not problem.scene.all(Rod):
        return scales.length / scales.tau**2
    scene = problem.scene
    directions = rod_directions(scene)
    weight = sum((np.array(field.g) for field in scene.all(UniformGravity)), np.zeros(3))
    falling = np.tile(weight, len(scene.bodies))
    # The length l of a rod is constant: 0 = l'' = G a + (v^2 - l'^2)/l, with the velocity v of one
    # end relative to the other.
    relative = np.array([_closing(scene, rod) for rod in scene.all(Rod)])
    lengths = np.array([rod.length for rod in scene.all(Rod)])
    lengthening = directions @ scene.bodies.velocity.ravel()
    across = (np.sum(relative**2, axis=1) - lengthening**2) / lengths
    acceleration = falling - moved_by_lengths(scene) @ (directions @ falling + across)
    return float(np.max(np.linalg.norm(acceleration.reshape(-1, 3), axis=1)))


def _closing(scene: Scene, rod: Rod) -> Array:
    """The velocity (3,) [m/s] of the first end of a rod against the second, which may be a point of
    the world.
    """
    velocity = scene.bodies.velocity
    closing: Array = velocity[rod.a].copy()
    if rod.b >= 0:
        closing -= velocity[rod.b]
    return closing


def rod_directions(scene: Scene) -> Array:
    """The rates G (rods, 3 bodies) of the lengths of the rods with the places of the bodies:
    `rod_jacobian`, in which points of the world that rods hang from stand still.
    """
    rods = scene.all(Rod)
    places = scene.bodies.position
    fixed = [rod.anchor_b for rod in rods if rod.b < 0]
    points = np.array([*places, *fixed])
    numbers = iter(range(len(places), len(points)))
    ends = [(rod.a, rod.b if rod.b >= 0 else next(numbers)) for rod in rods]
    return rod_jacobian(points, ends)[:, : places.size]


@once_for_each
def of_alternating_friction(instance: Instance) -> float:
    """Factor >= 1 by which friction without a tangential spring outgrows the errors of a step: mu,
    or mu m R^2/J of a sphere of little inertia.

    The direction of such friction is the sign of the slip. Where the slip is 0 but for the step,
    friction alternates, and a step of it changes

        the velocity by   mu F_n h/m,
        the spin by       mu F_n h R/J,

    mu and mu m R^2/J times what a step of the normal force F_n changes a velocity, and R omega, by.
    """
    problem = instance.problem
    if not isinstance(problem, Motion):
        return 1.0
    laws = problem.scene.all(Contact)
    soft = [law for law in laws if law.law != "rigid" and law.tangential_stiffness == 0]
    # max(1, mu, mu m R^2/J).
    largest = max((law.friction for law in soft), default=0.0)
    return max(1.0, largest, largest * of_touching_spins(instance))


def error_constant(instance: Instance, method: Method) -> float:
    """The error constant C that a step is allowed: the claimed one, times
    `of_alternating_friction`.
    """
    return method.constant * of_alternating_friction(instance)


def of_far_places(instance: Instance, method: Method, level: float) -> float:
    """Relative round-off of places that are far from the origin compared with the scale L of their
    motion, or with the length of a rod whose angle follows from them. Examples are a large ball
    that bounces by a little, and a short rod at the end of a long one.

    An addition to a place r rounds it by up to u |r|, however small the term. Without steps the
    error is that of one number, c u |r|/L. A step makes PLACE_ADDITIONS additions. After n steps

        uniform roundings add up, at three sigma, to   3 sqrt(PLACE_ADDITIONS n/3) u |r|/L,
        roundings of equal terms add up to             n u |r|/L, as in `flight`,
        those of nearly equal terms to                 PLACE_ADDITIONS n min(1, 1/k) u |r|/L.

    A term h v changes by h a T in a run of duration T with the acceleration a: by k spacings 2 u
    |r| of the numbers near r. Until it has changed by one it is rounded the same way at every step.
    And velocities that are differences of places are rounded by tau/h times as much.
    """
    problem = instance.problem
    if not isinstance(problem, Motion):
        return 0.0
    far = farthest_place(instance)
    rods = [rod.length for rod in problem.scene.all(Rod)]
    unit = method.round_off * far / min([instance.scales.length, *rods])
    if method.control != "step":
        return ROUND_OFF_FACTOR * unit
    steps = steps_at(instance, method, level)
    scattered = 3.0 * math.sqrt(PLACE_ADDITIONS * steps / 3.0)
    # PLACE_ADDITIONS n min(1, 2 u |r|/(h a T)).
    spacing = 2.0 * method.round_off * far
    change = level * start_acceleration(instance) * abs(float(instance.times[-1]))
    alike = PLACE_ADDITIONS * steps
    if change > spacing:
        alike *= spacing / change
    roundings = max(ROUND_OFF_FACTOR, scattered, alike)
    if _adds_equal_terms(instance.scene):
        roundings = max(roundings, steps)
    return roundings * unit * max(1.0, steps_of_differences(instance, method, steps))


def sweeping(instance: Instance, method: Method) -> float:
    """Factor >= 1 by which round-off grows where rods share bodies.

    A constraint solver sweeps over the rods again and again, and each sweep halves the residual: it
    needs log2(1/u) sweeps to reach round-off. In every sweep a body is given the impulses of its
    rods, 2 rods/bodies on average, each rounded. So the roundings of a step are

        log2(1/u) 2 rods/bodies   in place of the 10 that ROUND_OFF_FACTOR counts,

    and errors of random sign grow as the root of that ratio.
    """
    scene = instance.scene
    rods = len(scene.all(Rod))
    if rods < 2 or method.control != "step":
        return 1.0
    # sqrt(log2(1/u) 2 rods/bodies/10), at least 1.
    sweeps = -math.log2(method.round_off)
    roundings = sweeps * 2 * rods / len(scene.bodies)
    return max(1.0, math.sqrt(roundings / 10.0))


def flight(instance: Instance, method: Method, level: float) -> float:
    """Relative round-off u n of n additions of the same amount; 0 where forces vary all the time.

    A body in free flight adds h v to its position at every step, one that falls adds h g to its
    velocity. Sums of equal terms round the same way step after step, so their roundings add in
    proportion to n and not to sqrt(n). Dry friction of constant size adds h f/m, always against the
    motion (measured for velocity Verlet with friction alone and beside a spring: 0.2 to 0.5 u a
    step). Gravity beside a spring only moves the equilibrium, and the root holds (measured: 3 u
    sqrt(n) up to 1e6 steps).
    """
    if method.control != "step" or not isinstance(instance.problem, Motion):
        return 0.0
    if _adds_equal_terms(instance.scene):
        return method.round_off * steps_at(instance, method, level)
    return 0.0


def _adds_equal_terms(scene: Scene) -> bool:
    """True if there are long stretches in which every step adds the same amount; see `flight`.

    So it is if all forces are constant or act only for a while, and with a weight also where a
    force grows until it balances it: the body then falls with the same speed at every step.
    """
    falls = bool(scene.all(UniformGravity))
    steady = (element.pauses or (falls and element.resists) for element in scene.elements)
    return all(steady) or any(element.rubs for element in scene.elements)


def turning(instance: Instance, method: Method, level: float) -> float:
    """Relative round-off of angular momentum where bodies rotate: TURN_ROUNDINGS u n for n steps.

    The squares of a rounded cosine and sine do not add to 1, so a rotation by them changes the
    length of a vector by a rounding. The same rotation changes it by the same factor at every step,
    so these roundings add in proportion to n. A body that spins steadily repeats its rotations, one
    that tumbles returns to them.
    """
    if method.control != "step" or "rotation" not in instance.problem.features:
        return 0.0
    return TURN_ROUNDINGS * method.round_off * steps_at(instance, method, level)


def clock(instance: Instance, method: Method, level: float) -> float:
    """Relative error that a summed clock causes: u T/tau for each addition; 0 if none is summed.

    A time that is off by u t shifts the phase t/tau of the motion by u t/tau, and n additions do so
    n times. A method that chooses its steps makes one addition a sample and CLOCK_STEPS in each
    tau. A method of fixed steps takes the right number of them whatever its clock reads, so the
    clock matters only where a drive reads it.
    """
    phase = instance.scales.duration / instance.scales.tau
    if not method.summed_clock:
        return 0.0
    if method.control != "step":
        additions = len(instance.times) + CLOCK_STEPS * phase
        return method.round_off * phase * additions
    is_driven = any(element.reads_clock for element in instance.scene.elements)
    if is_driven:
        return method.round_off * phase * steps_at(instance, method, level)
    return 0.0


def order(instance: Instance, method: Method) -> float:
    """The order p to which a method is held: min(claimed order, limit of the scene's smoothness).

    The limit is the largest order that fixed steps can have across a singular force of the scene.
    """
    claimed = method.order_for(instance.problem.features)
    singularity = smoothness(instance, method)
    if singularity is None or singularity.order >= claimed:
        return claimed
    return singularity.order


def smoothness(instance: Instance, method: Method) -> Singularity | None:
    """The singular force of the scene that limits the order of fixed steps most, or None.

    Left out are those for which the method's claim stands as it is:
    - all of them, if the method locates events, for it may start a step on each;
    - those of an element that `order_with` names, for the claim was made with it in view;
    - jumps: an order above 1 that is claimed for them means that steps are cut at the jump.
    """
    if (
        method.control != "step"
        or method.locates_events
        or not isinstance(instance.problem, Motion)
    ):
        return None
    named = set(method.order_with)
    limits = [
        limit
        for element, limit in instance.scene.singularities()
        if limit.exponent > JUMP and not element.features() & named
    ]
    return min(limits, default=None)


def truncation(instance: Instance, method: Method, level: float, t: Array) -> Array:
    """Relative truncation error (T,) allowed at times t (T,) [s].

    It is C (1 + t/tau) (h/tau)^p for a step h with the C of `error_constant`, claimed C 1e3 tol
    for a tolerance, and 0 if exact.
    """
    if method.control == "exact":
        return np.zeros(len(t))
    if method.control == "tolerance":
        # The constant C that a method with a tolerance claims holds for smooth motions only.
        if kinked(instance, method):
            constant = 1.0
        else:
            constant = method.constant
        return np.full(len(t), constant * TOLERANCE_FACTOR * level)
    # C (1 + t/tau) (h/tau)^p.
    tau = instance.scales.tau
    power = order(instance, method)
    constant = error_constant(instance, method)
    allowed: Array = constant * (1.0 + np.abs(t - t[0]) / tau) * (level / tau) ** power
    return allowed


def kinked(instance: Instance, method: Method) -> bool:
    """True if the force may have kinks within a step: the error then falls with the order over many
    levels, but not from each level to the next.

    A force that is smoother, as |v| v of a drag, scatters only the errors of a method whose order
    it limits.
    """
    problem = instance.problem
    if isinstance(problem, Motion) and problem.scene.is_kinked():
        return True
    singularity = smoothness(instance, method)
    return singularity is not None and singularity.order < method.order_for(
        instance.problem.features
    )


def order_levels(
    instance: Instance, method: Method, levels: tuple[float, ...]
) -> tuple[float, ...]:
    """The levels from which an order is read: with kinks, KINK_HALVINGS halvings of the finest as
    well.
    """
    if not levels or not kinked(instance, method):
        return tuple(levels)
    finer = (levels[-1] / 2**k for k in range(1, KINK_HALVINGS + 1))
    return (*levels, *finer)


def steps_at(instance: Instance, method: Method, level: float) -> float:
    """Steps taken over the whole duration; one a sample for exact methods and tolerances."""
    if method.control == "step":
        return float(instance.times[-1] / level)
    return float(len(instance.times))


def bound(instance: Instance, method: Method, level: float, truth: SampledTruth) -> Array:
    """Relative error (until,) allowed at every certified sample.

    bound = (truncation + round-off + clock + flight) max S, the largest S up to the sample.

    Far places replace round-off and flight where they are rounded by more.
    """
    t = instance.times[: truth.until]
    # (truncation + resolution) max S.
    of_method = truncation(instance, method, level, t)
    return (of_method + resolution(instance, method, level)) * truth.growth()


def resolution(instance: Instance, method: Method, level: float) -> float:
    """Relative error of positions that a smaller step does not remove: round-off and flight, or the
    rounding of far places if that is more, and the clock.
    """
    rounding = round_off(instance, method, steps_at(instance, method, level))
    of_places = of_far_places(instance, method, level)
    # max(round-off + flight, far places) + clock.
    near = rounding + flight(instance, method, level)
    return max(near, of_places) + clock(instance, method, level)


def scored(allowed: Array) -> int:
    """Number of samples before the bound `allowed` (until,) first exceeds HORIZON, a tenth of the
    scale: the predictability horizon.
    """
    beyond = np.flatnonzero(allowed > HORIZON)
    if len(beyond):
        return int(beyond[0])
    return len(allowed)


def levels(
    instance: Instance, method: Method, count: int, most_steps: float, step: float | None = None
) -> tuple[float, ...]:
    """At most `count` refinement levels, coarse to fine.

    A tolerance falls from 1e-4 by factors of 100; exact methods have the one level 0. Steps [s] are
    halvings of the sample interval: from the first step on they are halved while a run takes at
    most `most_steps` steps and, once there are the three levels that an order needs, while the
    truncation bound stays above round-off. With `step` the levels start there; raises UsageError
    for a step that no run could finish. No levels at all if `most_steps` would make every step
    longer than tau, the shortest time of the motion.
    """
    if method.control == "exact":
        return (0.0,)
    if method.control == "tolerance":
        # 10^-4, 10^-6, 10^-8, ..., above COUNTING_FLOOR u.
        tolerances = (10.0 ** -(4 + 2 * j) for j in range(count))
        # Step control never ends with a tolerance near round-off.
        smallest = COUNTING_FLOOR * method.round_off
        return tuple(tolerance for tolerance in tolerances if tolerance > smallest)
    duration = instance.times[-1]
    if step is not None and duration / step > MOST_STEPS:
        raise UsageError(
            f"step is {step:g} s, which makes {duration / step:.1g} steps; expected at"
            f" most {MOST_STEPS:g}: take a longer step"
        )
    if step is None and duration / most_steps > instance.scales.tau:
        return ()
    power = order(instance, method)
    chosen = [_first_step(instance, method, power, most_steps, step)]
    while len(chosen) < count:
        finer = chosen[-1] / 2
        steps = duration / finer
        # Stop where T/h > most_steps, or C (T/tau) (h/tau)^p < COUNTING_FLOOR round-off.
        allowed = _final_truncation(instance, method, power, finer)
        is_enough = len(chosen) >= ORDER_LEVELS
        floor = COUNTING_FLOOR * round_off(instance, method, steps)
        if steps > most_steps or (is_enough and allowed < floor):
            break
        chosen.append(finer)
    return tuple(chosen)


def past_impacts(
    instance: Instance,
    method: Method,
    levels: tuple[float, ...],
    truth: SampledTruth,
    most_steps: float,
) -> tuple[float, ...]:
    """The levels, halved alike until the motion after its impacts can be judged too.

    An impact that truth certifies multiplies errors by S, which `levels` does not include. For a
    method that detects impacts at the end of a step, the coarsest level is halved until its bound
    at the end of the certified motion is small enough,

        (C (1 + T/tau) (h/tau)^p + resolution) S <= HORIZON/SHARP,

    or until a further halving would make the finest level take more than IMPACT_STEPS steps.
    Methods with velocities that lag keep their levels, since truth was sampled at their delays.
    """
    has_impacts = truth.scalars.keys() & {"impact_time", "impact_1"}
    is_late = (
        method.control == "step"
        and not method.locates_events
        and method.velocity_time == "synchronous"
        and "contact:rigid" in instance.problem.features
    )
    if not has_impacts or not is_late or not levels or not truth.until:
        return levels
    most = min(most_steps, IMPACT_STEPS)
    wanted = HORIZON / SHARP
    while steps_at(instance, method, levels[-1] / 2) <= most:
        # bound at the end of the certified motion <= HORIZON/SHARP.
        allowed = bound(instance, method, levels[0], truth)
        if allowed[-1] <= wanted:
            break
        levels = tuple(level / 2 for level in levels)
    return levels


def _final_truncation(instance: Instance, method: Method, power: float, step: float) -> float:
    """Truncation bound C (T/tau) (h/tau)^p at the end of a run with this step h [s], with the C
    that the method claims.
    """
    scales = instance.scales
    phase = scales.duration / scales.tau
    return float(method.constant * phase * (step / scales.tau) ** power)


def _first_step(
    instance: Instance, method: Method, power: float, most_steps: float, step: float | None
) -> float:
    """The coarsest step [s], the sample interval halved as often as needed.

    It is at most `step` if that is given. Else it is at most the h of

        C (T/tau) (h/tau)^p = 0.1,   that is   h = tau (0.1 tau / (C T))^(1/p),

    or the smallest step that `most_steps` allow, whichever is longer: a run whose error leaves the
    scale before the end is scored up to its horizon.
    """
    scales = instance.scales
    interval = float(instance.times[1])
    target = step or scales.tau * (HORIZON * scales.tau / (method.constant * scales.duration)) ** (
        1.0 / power
    )
    # The 1e-9 keeps a target that is a halving itself, but for its rounding.
    halvings = max(0, int(np.ceil(np.log2(interval / target) - 1e-9)))
    if step is None:
        most_halvings = int(np.log2(most_steps * interval / instance.times[-1]))
        halvings = min(halvings, max(0, most_halvings))
    return interval * 2.0**-halvings
