"""A point on a linear spring in the plane, damped by fluids at rest and by rotating fluids, in
closed form.

Position z = x + i y from the spring's anchor; c is the sum of all dampings c_j, and K the sum of
c_j W_j over the fluids that rotate at W_j about a_j:

    m z'' + c z' + (k - i K) z = m g - i sum c_j W_j a_j.

The motion about the equilibrium z_e = (right-hand side)/(k - i K) is a sum of exp(q_1 t) and
exp(q_2 t) with the roots of m q^2 + c q + k - i K = 0. The larger root is q_2 = -b - s, with b =
c/(2 m), s = sqrt(b^2 - (k - i K)/m) and Re s >= 0; the other one follows from q_1 q_2 = (k - i K)/m
without cancellation.
"""

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rotating_dashpot import RotatingDashpot
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers import _single_point as single
from refdem.solvers._scene_pattern import ANY, ONE, SOME, ScenePattern, SceneSolver

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class ExactWhirl(SceneSolver):
    """One point in the plane on a linear spring, in fluids at rest and in rotating fluids."""

    claims = Method(
        name="exact-whirl",
        summary="a damped mass on a shaft that turns, in closed form",
        control="exact",
        conserves=frozenset({"energy"}),
        backward=True,
        cost_rank=1,
    )

    pattern = ScenePattern(
        elements={Spring: ONE, RotatingDashpot: SOME, Dashpot: ANY, UniformGravity: ANY},
        bodies=ONE,
        only_points=True,
        in_plane=True,
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for a linear restoring spring of natural length 0 and linear dashpots to the world,
        else the reason.
        """
        scene = problem.scene
        spring = scene.all(Spring)[0]
        if spring.length or not single.is_linear(spring) or not spring.stiffness > 0:
            return "the spring is not linear from natural length 0"
        if any(dashpot.van_der_pol for dashpot in scene.all(Dashpot)):
            return "the dashpot is not linear"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Positions and velocities at the samples."""
        begun = perf_counter()
        scene = request.problem.scene
        times = request.problem.times
        anchor = single.anchor(scene.all(Spring)[0])
        whirl = whirl_of(scene)
        started = perf_counter()
        z, v = whirl.at(times - times[0])
        seconds = perf_counter() - started
        position = anchor + _in_space(z)
        position[0] = scene.bodies.position
        velocity = _in_space(v)
        velocity[0] = scene.bodies.velocity
        trajectory = Trajectory.of_points(times, position, velocity)
        return trajectory, Cost(seconds=seconds, setup=started - begun)


@dataclass(frozen=True)
class Whirl:
    """The motion z'' + 2 b z' + p (z - z_e) = 0 in the complex plane: `decay` b [1/s], `stiffness`
    p [1/s^2], `middle` z_e [m], and the start.
    """

    decay: float
    stiffness: complex
    middle: complex
    place: complex
    velocity: complex

    def at(self, t: Array) -> tuple[Complex, Complex]:
        """z [m] and z' [m/s] (T,) at times t (T,) [s] after the start.

        With Z = z - z_e and D = (exp(q1 t) - exp(q2 t))/(q1 - q2),

            Z = Z0 exp(q2 t) + (v0 - q2 Z0) D,
            v = v0 exp(q2 t) + q1 (v0 - q2 Z0) D.

        D is computed as sgn(t) (1 - exp(-2 s |t|))/(2 s) times the larger of both exponentials.
        """
        # s = sqrt(b^2 - p), q2 = -b - s, q1 = p/q2, and q1 - q2 = 2 s.
        half_gap = np.sqrt(complex(self.decay**2 - self.stiffness))
        fast = -self.decay - half_gap
        slow = self.stiffness / fast
        gap = slow - fast
        exponential = np.exp(fast * t)
        if gap == 0:
            response = exponential * t
        else:
            larger = np.where(t >= 0, np.exp(slow * t), exponential)
            response = np.sign(t) * larger * -np.expm1(-gap * np.abs(t)) / gap
        start = self.place - self.middle
        excess = self.velocity - fast * start
        z = self.middle + start * exponential + excess * response
        v = self.velocity * exponential + slow * excess * response
        return z, v


def whirl_of(scene: Scene) -> Whirl:
    """The motion of a scene that fits, from the anchor of its spring."""
    mass = float(scene.bodies.mass[0])
    spring = scene.all(Spring)[0]
    anchor = single.anchor(spring)
    # c = sum c_j, K = sum c_j W_j, and the right-hand side m g - i sum c_j W_j a_j.
    damping = sum(dashpot.damping for dashpot in scene.all(Dashpot))
    push = 0.0
    load = mass * _complex(single.gravity(scene))
    for dashpot in scene.all(RotatingDashpot):
        damping += dashpot.damping
        turned = dashpot.damping * dashpot.rate[2]
        push += turned
        load -= 1j * turned * _complex(single.anchor(dashpot) - anchor)
    return Whirl(
        decay=damping / (2 * mass),
        stiffness=complex(spring.stiffness, -push) / mass,
        middle=load / complex(spring.stiffness, -push),
        place=_complex(scene.bodies.position[0] - anchor),
        velocity=_complex(scene.bodies.velocity[0]),
    )


def _complex(vector: Array) -> complex:
    """x + i y of a vector (3,)."""
    return complex(vector[0], vector[1])


def _in_space(values: Complex) -> Array:
    """The vectors (T, 1, 3) of complex numbers (T,) in the plane x-y."""
    vectors = np.zeros((len(values), 1, 3))
    vectors[:, 0, 0] = values.real
    vectors[:, 0, 1] = values.imag
    return vectors


METHOD = ExactWhirl()
