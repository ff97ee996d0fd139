"""Steps that DEM codes choose, accept or recommend for a contact, beside the limit of stability of
velocity Verlet and the error at each of them.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import numpy as np

from refdem.bench import fixed_steps
from refdem.core.case import Case, Instance
from refdem.core.judgement import errors
from refdem.core.truth import SampledTruth, Truth
from refdem.errors import EngineError, NotCertifiedError, UsageError
from refdem.planning.kept_truth import kept_truth
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.scene import Scene
from refdem.scene.shapes import Sphere
from refdem.truth.balls import UndecidedError

POISSON = 0.25
"""Poisson's ratio of a material of which a scene under Hertz's law has the stiffness alone."""
MOST_SAMPLES = 256
"""Largest number of samples of a run; each sample interval takes a whole number of steps."""
MOST_SPHERES = 64
"""Largest number of spheres, each of which may touch each."""


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Two spheres, or a sphere and a plane, that may touch, under one law.

    `masses` [kg] and `inertias` [kg m^2] have the entries of those that move. `radius` [m] is the
    smallest and `effective_radius` 1/(1/R1 + 1/R2). `density` [kg/m^3] is that of the smallest
    sphere, `speed` [m/s] that at which the centres approach at the start.
    """

    law: Contact
    masses: tuple[float, ...]
    inertias: tuple[float, ...]
    radius: float
    effective_radius: float
    density: float
    speed: float

    @property
    def effective_mass(self) -> float:
        """1/(sum of 1/m) over the spheres that move."""
        return 1 / sum(1 / mass for mass in self.masses)


Rule = Callable[[Pair], float | None]
"""The step [s] for a pair; None where the rule has no answer."""


def collision_time(pair: Pair) -> float | None:
    """The duration of a contact under a linear spring and a dashpot; None where damping is
    critical or more, or the law is not linear.

    t_c = pi / sqrt(k/m - (c/(2 m))^2), m the effective mass.
    """
    law = pair.law
    squared = law.stiffness / pair.effective_mass - (law.damping / (2 * pair.effective_mass)) ** 2
    if law.law != "linear" or squared <= 0:
        return None
    return math.pi / math.sqrt(squared)


def eigenperiod(pair: Pair) -> float | None:
    """sqrt(2) times the least of sqrt(m/k) and sqrt(I/(k_t R^2)) over the spheres of a pair, k the
    larger one of the two stiffnesses; None where the law is not linear.
    """
    law = pair.law
    if law.law != "linear":
        return None
    squared = [mass / max(law.stiffness, law.tangential_stiffness) for mass in pair.masses]
    if law.tangential_stiffness > 0:
        torsion = law.tangential_stiffness * pair.radius**2
        squared += [inertia / torsion for inertia in pair.inertias]
    return math.sqrt(2 * min(squared))


def wall_contact_time(pair: Pair) -> float | None:
    """pi sqrt(m/k) of the lightest sphere, the duration of its undamped contact with a wall; None
    where the law is not linear.
    """
    if pair.law.law != "linear":
        return None
    return math.pi * math.sqrt(min(pair.masses) / pair.law.stiffness)


def effective_modulus(pair: Pair) -> float | None:
    """E of Hertz's stiffness k = (4/3) E sqrt(R) with the effective radius R; None for other
    laws.
    """
    if pair.law.law != "hertz":
        return None
    return 0.75 * pair.law.stiffness / math.sqrt(pair.effective_radius)


def rayleigh_time(pair: Pair) -> float | None:
    """The time that a Rayleigh wave takes around the smallest sphere; None without Hertz's law.

    pi R sqrt(rho/G) / (0.1631 nu + 0.8766), with G = E (1 - nu) of two bodies of one material,
    whose effective modulus is E.
    """
    modulus = effective_modulus(pair)
    if modulus is None:
        return None
    shear = modulus * (1 - POISSON)
    slowness = math.sqrt(pair.density / shear)
    return math.pi * pair.radius * slowness / (0.1631 * POISSON + 0.8766)


def hertz_time(pair: Pair) -> float | None:
    """2.87 (m^2/(R E^2 v))^(1/5), the duration of a contact under Hertz's law with the effective
    mass, radius and modulus and the closing speed v; None for other laws and without an approach.
    """
    modulus = effective_modulus(pair)
    if modulus is None or pair.speed == 0:
        return None
    ratio = pair.effective_mass**2 / (pair.effective_radius * modulus**2 * pair.speed)
    return 2.87 * math.pow(ratio, 0.2)


@dataclass(frozen=True)
class Advice:
    """What one code does about the step: `share` times the time of `rule`."""

    code: str
    words: str
    source: str
    share: float
    rule: Rule


ADVICE = (
    Advice(
        "exaDEM",
        "accepted by default: pi sqrt(m/k), m the least mass",
        "operator check_dt_critical: its ratio is 1 if none is given",
        1.0,
        wall_contact_time,
    ),
    Advice(
        "YADE",
        "chosen: 0.8 sqrt(2) sqrt(m/k)",
        "GlobalStiffnessTimeStepper: `timestepSafetyCoefficient` is 0.8",
        0.8,
        eigenperiod,
    ),
    Advice(
        "exaDEM",
        "accepted in its example: 0.02 pi sqrt(m/k)",
        "operator check_dt_critical, example with a ratio of 0.02",
        0.02,
        wall_contact_time,
    ),
    Advice(
        "MFIX-Exa",
        "chosen: collision time / 50",
        "input `mfix.tcoll_ratio`, 50 if it is not given",
        1 / 50,
        collision_time,
    ),
    Advice(
        "MercuryDPM",
        "in its drivers: 0.02 collision times",
        "`setTimeStep(0.02 * species->getCollisionTime(mass))`",
        0.02,
        collision_time,
    ),
    Advice(
        "Lethe",
        "accepted without a warning: 0.15 Rayleigh times",
        "warning of lethe-particles above 15 % of the Rayleigh time",
        0.15,
        rayleigh_time,
    ),
    Advice(
        "LIGGGHTS",
        "in its example: 0.1 Rayleigh times",
        "`fix check/timestep/gran 1000 0.1 0.1`, first fraction",
        0.1,
        rayleigh_time,
    ),
    Advice(
        "LIGGGHTS",
        "in its example: 0.1 Hertz times",
        "`fix check/timestep/gran 1000 0.1 0.1`, second fraction",
        0.1,
        hertz_time,
    ),
)
"""From the largest steps to the smallest of each law."""


@dataclass(frozen=True, kw_only=True)
class Judged:
    """The step [s] of one code for one instance.

    `part` is the step over the limit of stability 2/omega. `error` is the largest error of velocity
    Verlet over the run, of the worst quantity in units of its scale, with the largest step of at
    most this one that divides the duration, all steps of one size; None where the run failed, or
    the step is longer than the run.
    """

    advice: Advice
    step: float
    part: float
    error: float | None


def pairs(scene: Scene) -> list[Pair]:
    """Every two spheres of which one moves, and every moving sphere with a plane, under the law of
    soft contacts; empty without such a law.
    """
    laws = [element for element in scene.elements if isinstance(element, Contact)]
    if not laws or laws[0].law == "rigid":
        return []
    planes = [element for element in scene.elements if isinstance(element, Plane)]
    return list(_pairs(scene, laws[0], planes))


def _pairs(scene: Scene, law: Contact, planes: Sequence[Plane]) -> Iterator[Pair]:
    bodies = scene.bodies
    spheres = {n: shape for n, shape in enumerate(bodies.shape) if isinstance(shape, Sphere)}
    for one, other in combinations(spheres, 2):
        moving = [number for number in (one, other) if not bodies.fixed[number]]
        if moving:
            apart = bodies.position[other] - bodies.position[one]
            approach = bodies.velocity[one] - bodies.velocity[other]
            speed = max(float(approach @ apart / np.linalg.norm(apart)), 0.0)
            yield _pair(scene, law, moving, (spheres[one].radius, spheres[other].radius), speed)
    for plane in planes:
        for number, sphere in spheres.items():
            if not bodies.fixed[number]:
                speed = max(-float(bodies.velocity[number] @ np.array(plane.normal)), 0.0)
                yield _pair(scene, law, [number], (sphere.radius,), speed)


def _pair(
    scene: Scene, law: Contact, moving: list[int], radii: tuple[float, ...], speed: float
) -> Pair:
    """The pair of these radii whose bodies `moving` are not fixed."""
    bodies = scene.bodies
    masses = tuple(bodies.mass[moving].tolist())
    smallest = min(radii)
    return Pair(
        law=law,
        masses=masses,
        inertias=tuple(bodies.inertia[moving].max(axis=1).tolist()),
        radius=smallest,
        effective_radius=1 / sum(1 / radius for radius in radii),
        density=min(masses) / (4 / 3 * math.pi * smallest**3),
        speed=speed,
    )


def judged(instance: Instance) -> list[Judged]:
    """The steps of all rules that have an answer for the instance, each with its error.

    Raises UsageError without a soft contact of spheres, or without certified truth of the whole
    run.
    """
    if isinstance(instance.case, Case) and len(instance.scene.bodies.shape) > MOST_SPHERES:
        raise UsageError(
            f"{instance.label}: got {len(instance.scene.bodies.shape)} bodies; expected at most"
            f" {MOST_SPHERES}, each of which may touch each"
        )
    if not isinstance(instance.case, Case) or not pairs(instance.scene):
        raise UsageError(
            f"{instance.label}: got a scene without spheres that touch under a law with a"
            " stiffness; expected a case such as two-spheres or hertz-spheres"
        )
    feature = fixed_steps.unsupported_feature(instance.scene)
    if feature is not None:
        raise UsageError(
            f"{instance.label}: got a scene with {feature}; expected spheres under normal forces"
            " and weight, as with friction=0"
        )
    touching = pairs(instance.scene)
    limit = 2 * instance.scales.tau
    # A truth that is kept says at once where the proof ends, which may take a minute to see.
    kept = kept_truth(instance)
    if kept is not None:
        refuse_partial(kept, instance)
    proof = instance.truth()
    found = []
    for advice in ADVICE:
        times = [time for pair in touching if (time := advice.rule(pair)) is not None]
        if times:
            step = advice.share * min(times)
            error = error_at(instance, proof, step)
            found.append(Judged(advice=advice, step=step, part=step / limit, error=error))
    return found


def error_at(instance: Instance, proof: Truth, step: float) -> float | None:
    """The largest error of velocity Verlet over the run against `proof`, in units of the scale of
    each quantity, with at most this step [s]; None where the engine has no answer, or the run is
    shorter than the step.

    Each step is a sample, or the last of a few where there are more than MOST_SAMPLES.
    """
    if step > instance.scales.duration:
        return None
    steps = max(math.ceil(instance.scales.duration / step), 2)
    samples = math.ceil(steps / math.ceil(steps / MOST_SAMPLES))
    sampled = instance.case.at(**{**instance.p.changed(), "samples": str(samples)})
    try:
        trajectory = fixed_steps.run(sampled.scene, sampled.times, math.ceil(steps / samples))
    except EngineError:
        # Some number of an unstable run is not finite.
        return None
    found = errors(sampled, trajectory, certified_values(sampled, proof))
    return max(float(np.max(of_quantity)) for of_quantity in found.values())


def certified_values(instance: Instance, proof: Truth) -> SampledTruth:
    """The values that `proof` certifies at the samples of an instance, without S, which bounds
    need and errors do not, and whose proof takes much longer.

    Raises UsageError if a sample is not certified: the largest error may be there.
    """
    times = instance.times.tolist()
    values: dict[str, list[float]] = {}
    radii: dict[str, list[float]] = {}
    until = 0
    reason = ""
    for t in times:
        try:
            balls = proof.at(Fraction(t))
        except (NotCertifiedError, UndecidedError) as error:
            reason = str(error)
            break
        for name, ball in balls.items():
            value, radius = ball.rounded()
            values.setdefault(name, []).append(value)
            radii.setdefault(name, []).append(radius)
        until += 1
    truth = SampledTruth(
        t=times,
        values=values,
        radii=radii,
        sensitivity=[],
        scalars={},
        method=proof.method,
        witness=proof.witness,
        until=until,
        reason=reason,
    )
    refuse_partial(truth, instance)
    return truth


def refuse_partial(truth: SampledTruth, instance: Instance) -> None:
    """Raises UsageError if the truth does not reach the end of the run."""
    if truth.until < len(truth.t):
        raise UsageError(
            f"{instance.label} has no certified truth of the whole run, against which errors are"
            f" measured: {truth.reason}"
        )
