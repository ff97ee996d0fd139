"""Bounds and refinement: how large an error may be at a step, and which steps to take.

Every bound is relative: an error in units of a quantity's scale. With step h, order p, shortest
time tau, duration T, unit round-off u, number of steps n, and the factor S(t) by which the motion
amplifies an earlier error,

    truncation  = C (1 + t/tau) (h/tau)^p
    round-off   = c u max(1, sqrt(n), T/tau)
    bound       = (truncation + round-off + clock + flight) S(t)

`clock` and `flight` are roundings whose sum is proportional to n and not to sqrt(n). `level` is the
step h [s], or the tolerance of a method that chooses its own steps.
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
"""Number of levels needed to observe an order: two pairs of levels, which must agree."""
COUNTING_FLOOR = 20.0
"""A level is used for the order as long as its bound is at least this many times round-off."""
IMPACT_STEPS = 2.0**15
"""Steps that the finest level of a motion with impacts takes at most."""
SHARP = 8.0
"""The coarsest level of a motion with impacts is refined until its bound is at most HORIZON/SHARP.
With four levels and first order, the bound of the finest one is then HORIZON/64 = 1/640.
"""
TURN_ROUNDINGS = 3.0
"""Roundings by which the rotations of a step change the length of a vector: five rotations, half a
rounding each, all of one sign.

Measured: 0.8 a step for a sphere that spins about a tilted axis, turned in single precision about
its three axes in five turns.
"""
PLACE_ADDITIONS = 2.0
"""Additions to a position in a step: leapfrog has two drifts, other methods add once."""
MOST_STEPS = 1e10
"""Largest number of steps that is accepted: no engine makes more of them within a day."""
CLOCK_STEPS = 4.0
"""Steps in one tau = 1/omega_max of a method that chooses its own steps: one of high order advances
the phase by a fraction of a radian a step.
"""
SCATTER = 1.0
"""Standard deviation, in octaves, of the error constant of a motion with kinks from step to step.

The error of a step that contains a kink is h^p times a polynomial in the fraction of the step at
which the kink lies, and this fraction is practically random. Measured: 0.9 for velocity Verlet
across a field with two edges, 18 steps.
"""
KINK_HALVINGS = 2
"""Halvings of the finest step for the order of a motion with kinks: a mean over five octaves
distinguishes orders that single pairs do not.
"""
MEMORY = 4
"""Number of earlier steps that a multistep method uses. The first steps of a run are made by
another rule.
"""
UNRESOLVED = 0.5
"""Relative truncation error at the start from which a step does not resolve the motion."""
TOLERANCE_FACTOR = 1e3
"""A tolerance is local: its error may add up to this many times itself (design: 1e3 tol S)."""


def round_off(instance: Instance, method: Method, steps: float) -> float:
    """Relative round-off after `steps` steps: c u sqrt(n), and not less than c u T/tau.

    The second part is the rounding of the parameters themselves: a relative error u of a frequency
    is an error u t of the phase. c is larger for slender bodies that spin (`of_directions`), for
    spheres of little inertia in contact (`of_touching_spins`), and for rods in a nearly singular
    configuration (`of_rods`). For velocities that are differences of positions the round-off is
    multiplied by `of_differences`.
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
    """Factor >= 1 by which round-off is larger if velocities are differences of positions divided
    by the step h.

    A position r is rounded by u max(|r|, L), so the quotient is rounded by u max(|r|, L)/h, which
    is (tau/h) max(1, |r|/L) times u L/tau.
    """
    far = max(1.0, farthest_place(instance) / instance.scales.length)
    # max(1, (tau/h) max(1, |r|/L)).
    return max(1.0, far * steps_of_differences(instance, method, steps))


def steps_of_differences(instance: Instance, method: Method, steps: float) -> float:
    """The ratio tau/h for a method whose velocities are differences of positions divided by the
    step h; 0 for other methods.

    The rounding of such a velocity in units of L/tau is tau/h times that of a position in units of
    L.
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
    """Relative error of a spin per unit error of the attitude: |L|/(I_min |omega|), the largest of
    any body; 0 if no body spins at the start.

    Methods may integrate the angular momentum L in space axes. An error u of the attitude is then
    an error u |L| of its components in body axes, and u |L|/I_min of omega = I^-1 L.
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
    """Relative error of a spin per rounding of a velocity where spheres touch: m R^2/J, the largest
    of any body; 0 without contacts.

    One rounding of a velocity v is a tangential impulse m u v, also in a contact without friction.
    It changes the spin by m u v R/J, and R omega by m R^2/J times u v.
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
    """Relative error of a position per rounding of the length of every rod; 0 without rods.

    Errors s of the lengths displace the bodies by M^-1 G^T (G M^-1 G^T)^-1 s, where G has the
    directions of the rods. If all rods lie nearly in one plane, this is many times s, normal to
    the plane.
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
    """The matrix M^-1 G^T (G M^-1 G^T)^-1 (3 bodies, rods): displacements of the bodies per unit
    error of the length of each rod, or accelerations per unit second derivative of the lengths.
    """
    weights = 1.0 / np.sqrt(np.repeat(scene.bodies.mass, 3))
    # With A = G M^-1/2 the matrix is M^-1/2 A^+.
    moved_by: Array = weights[:, None] * np.linalg.pinv(rod_directions(scene) * weights)
    return moved_by


@once_for_each
def start_acceleration(instance: Instance) -> float:
    """Largest acceleration [m/s^2] of a body: that at the start of bodies on rods, under their
    weight; L/tau^2 of others.

    The scales of a scene with rods of very unequal masses or lengths are those of the fastest
    motion that the energy permits, which may be much faster than the motion at the start.
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

    The direction of such friction is the sign of the slip. Where the exact slip is 0, friction
    alternates in sign from step to step, and in one step it changes

        the velocity by   mu F_n h/m,
        the spin by       mu F_n h R/J,

    The first is mu times the change F_n h/m of a velocity in a step by the normal force F_n. The
    second, as R omega, is mu m R^2/J times this change.
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
    """Relative round-off of positions that are far from the origin compared with the scale L of the
    motion, or with the length of a rod whose angle is computed from them. Examples are a large ball
    with small bounces, and a short rod at the end of a long one.

    An addition to a position r rounds it by up to u |r|, however small the term. Without steps the
    error is that of one number, c u |r|/L. A step makes PLACE_ADDITIONS additions. After n steps

        uniform roundings add up, at three sigma, to   3 sqrt(PLACE_ADDITIONS n/3) u |r|/L,
        roundings of equal terms add up to             n u |r|/L, as in `flight`,
        those of nearly equal terms to                 PLACE_ADDITIONS n min(1, 1/k) u |r|/L.

    In a run of duration T with the acceleration a, the term h v changes by h a T = k 2 u |r|, that
    is by k spacings of the doubles near r. While it changes by less than one spacing, it is rounded
    in the same way at every step. For velocities that are differences of positions the result is
    multiplied by tau/h.
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

    An iterative constraint solver sweeps over the rods repeatedly. If each sweep halves the
    residual, it needs log2(1/u) sweeps to reach round-off. In every sweep the impulses of its rods
    are added to a body, 2 rods/bodies on average, each with a rounding. The roundings of a step are

        log2(1/u) 2 rods/bodies   in place of the 10 that ROUND_OFF_FACTOR counts,

    and errors of random sign grow as the square root of this ratio.
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
    """True if over long parts of a run every step adds the same amount; see `flight`.

    This holds if all forces are constant or act only for a time. With gravity it holds also for
    forces that grow until they balance it: the body then falls at constant speed.
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

    An error u t of the time is an error u t/tau of the phase t/tau of the motion, and n additions
    add n such errors. A method that chooses its steps makes one addition for each sample and
    CLOCK_STEPS in each tau. A method with fixed steps makes the right number of steps whatever its
    clock shows, so the clock matters only if a drive depends on it.
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
    - those of an element that `order_with` names, since the claim takes them into account;
    - jumps: a claimed order above 1 implies that steps are cut at the jump.
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
    """The levels from which an order is observed: with kinks also KINK_HALVINGS halvings of the
    finest one.
    """
    if not levels or not kinked(instance, method):
        return tuple(levels)
    finer = (levels[-1] / 2**k for k in range(1, KINK_HALVINGS + 1))
    return (*levels, *finer)


def steps_at(instance: Instance, method: Method, level: float) -> float:
    """Number of steps of a run, T/h; for exact methods and tolerances the number of samples."""
    if method.control == "step":
        return float(instance.times[-1] / level)
    return float(len(instance.times))


def bound(instance: Instance, method: Method, level: float, truth: SampledTruth) -> Array:
    """Relative error (until,) allowed at every certified sample.

    bound = (truncation + round-off + clock + flight) max S, the largest S up to the sample.

    The rounding of positions far from the origin replaces round-off + flight if it is larger.
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
    """The levels, all halved equally often, until the motion after its impacts can be judged too.

    A certified impact multiplies errors by S, which `levels` does not take into account. For a
    method that detects impacts at the end of a step, the coarsest level is halved until its bound
    at the end of the certified motion is small enough,

        (C (1 + T/tau) (h/tau)^p + resolution) S <= HORIZON/SHARP,

    or until a further halving would make the finest level take more than IMPACT_STEPS steps. The
    levels of methods whose velocities lag are not changed, since truth was sampled at their delays.
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
    # halvings = ceil(log2(interval/target)). The 1e-9 allows for the rounding of a target that is
    # itself a halving of the interval.
    halvings = max(0, int(np.ceil(np.log2(interval / target) - 1e-9)))
    if step is None:
        most_halvings = int(np.log2(most_steps * interval / instance.times[-1]))
        halvings = min(halvings, max(0, most_halvings))
    return interval * 2.0**-halvings
