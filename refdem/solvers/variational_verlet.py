"""Velocity Verlet for points in smooth fields, together with its equations of first variation.

With the force F(r, s), parameters s of the scene, and R = dr/ds, V = dv/ds, a step of h is

    v' = v + h/2 F(r)/m,    r+ = r + h v',    v+ = v' + h/2 F(r+)/m        (Swope et al. 1982),
    V' = V + h/2 A(r, R),   R+ = R + h V',    V+ = V' + h/2 A(r+, R+),

where A(r, R) = d(F(r, s)/m)/ds = (1/m) (dF/dr) R + the partial derivative of F/m by s. These are
the exact derivatives of the discrete steps, up to rounding. K is the number of parameters.
"""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.solvers._scene_pattern import ANY, ScenePattern, SceneSolver

Array = NDArray[np.float64]

STATES = 13
"""Components of the state of a body: position (3), velocity (3), attitude (4), omega (3)."""


@dataclass(frozen=True)
class Acting:
    """The elements of a scene, with the derivatives of their fields by K parameters.

    `mass` (N,) [kg] has the derivatives `mass_slope` (N, K). `slopes` has those of each element by
    the name of the field: (K,) for a number and (K, 3) for a vector.
    """

    elements: tuple[Any, ...]
    slopes: tuple[dict[str, Array], ...]
    mass: Array
    mass_slope: Array

    def acceleration(self, r: Array, dr: Array) -> tuple[Array, Array]:
        """F/m (N, 3) [m/s^2] at positions r (N, 3) with derivatives dr (N, K, 3), and its
        derivatives A (N, K, 3).
        """
        a = np.zeros_like(r)
        da = np.zeros_like(dr)
        for element, slopes in zip(self.elements, self.slopes, strict=True):
            if isinstance(element, UniformGravity):
                a += element.g
                da += slopes["g"]
            elif isinstance(element, CentralField):
                _attract(element, slopes, r, dr, a, da)
            else:
                self._pull(element, slopes, r, dr, a, da)
        return a, da

    def _pull(
        self, spring: Spring, slopes: dict[str, Array], r: Array, dr: Array, a: Array, da: Array
    ) -> None:
        """Adds the force of a spring, F = -f d on its first end, with the vector d from its second
        end to the first.
        """
        if spring.b >= 0:
            d = r[spring.a] - r[spring.b]
            dd = dr[spring.a] - dr[spring.b]
        else:
            d = r[spring.a] - np.array(spring.anchor_b)
            dd = dr[spring.a] - slopes["anchor_b"]
        f, df = spring_factor(spring, slopes, d, dd)
        force = -f * d
        # dF = -(df d + f dd).
        force_slope = -np.outer(df, d) - f * dd
        self._push(spring.a, force, force_slope, a, da)
        if spring.b >= 0:
            self._push(spring.b, -force, -force_slope, a, da)

    def _push(self, body: int, force: Array, force_slope: Array, a: Array, da: Array) -> None:
        """Adds F/m to the acceleration of a body, and d(F/m) = (dF - (F/m) dm)/m to its
        derivatives.
        """
        pushed = force / self.mass[body]
        a[body] += pushed
        da[body] += (force_slope - np.outer(self.mass_slope[body], pushed)) / self.mass[body]


def _attract(
    field: CentralField, slopes: dict[str, Array], r: Array, dr: Array, a: Array, da: Array
) -> None:
    """Adds a = -gm r/|r|^3, and da = -dgm r/|r|^3 - gm (dr - 3 r (r . dr)/|r|^2)/|r|^3."""
    square = np.sum(r * r, axis=-1)
    cube = (square * np.sqrt(square))[:, None, None]
    outward = r[:, None, :]
    along = np.sum(outward * dr, axis=-1, keepdims=True) / square[:, None, None]
    a -= field.gm * r / cube[:, 0]
    da -= slopes["gm"][:, None] * outward / cube
    da -= field.gm * (dr - 3.0 * outward * along) / cube


def spring_factor(
    spring: Spring, slopes: dict[str, Array], d: Array, dd: Array
) -> tuple[float, Array]:
    """The factor f of the spring force F = -f d, and its derivatives (K,) for those dd (K, 3) of d.

    F = -(k s + c s^3) d/|d| with the stretch s = |d| - l, so that f = (k s + c s^3)/|d|.
    """
    k = spring.stiffness
    c = spring.cubic
    length = spring.length
    dk = slopes["stiffness"]
    dc = slopes["cubic"]
    dl = slopes["length"]
    square = float(d @ d)
    if not length and not np.any(dl):
        # l = 0: f = k + c |d|^2, also at d = 0, and df = dk + dc |d|^2 + 2 c d . dd.
        return k + c * square, dk + dc * square + 2.0 * c * (dd @ d)
    distance = float(np.sqrt(square))
    stretch = distance - length
    pull = k * stretch + c * stretch**3
    # d|d| = d . dd/|d|, ds = d|d| - dl, dp = dk s + dc s^3 + (k + 3 c s^2) ds with p = k s + c s^3.
    distance_slope = dd @ d / distance
    stretch_slope = distance_slope - dl
    pull_slope = dk * stretch + dc * stretch**3 + (k + 3.0 * c * stretch**2) * stretch_slope
    # f = p/|d|, df = (dp - f d|d|)/|d|.
    f = pull / distance
    return f, (pull_slope - f * distance_slope) / distance


def acting(scene: Scene, requested: tuple[str, ...]) -> Acting:
    """The elements and masses of a scene, with their derivatives by the requested parameters.

    The derivative of a parameter by itself is 1, and 0 by any other.
    """
    count = len(requested)
    mass_slope = np.zeros((len(scene.bodies), count))
    slopes = []
    for element in scene.elements:
        of_element = {}
        for name in element.__struct_fields__:
            shape = np.shape(getattr(element, name))
            of_element[name] = np.zeros((count, *shape))
        slopes.append(of_element)
    for column, key in enumerate(requested):
        _, of, number, name, *component = key.split(".")
        if of == "elements":
            slopes[int(number)][name][(column, *map(int, component))] = 1.0
        elif name == "mass":
            mass_slope[int(number), column] = 1.0
    return Acting(tuple(scene.elements), tuple(slopes), scene.bodies.mass, mass_slope)


def started(scene: Scene, requested: tuple[str, ...]) -> tuple[Array, Array]:
    """Derivatives (N, K, 3) of initial positions and velocities by the requested parameters."""
    slopes = {
        name: np.zeros((len(scene.bodies), len(requested), 3)) for name in ("position", "velocity")
    }
    for column, key in enumerate(requested):
        _, of, number, name, *component = key.split(".")
        if of == "bodies" and name in slopes:
            slopes[name][int(number), column, int(component[0])] = 1.0
    return slopes["position"], slopes["velocity"]


class VariationalVerlet(SceneSolver):
    """Points on springs in gravity or a central field, with derivatives by any number of
    parameters.
    """

    claims = Method(
        name="variational-verlet",
        summary="velocity Verlet with derivatives, by its equations of first variation",
        control="step",
        order=2,
        conserves=frozenset({"momentum", "angular-momentum"}),
        reversible=True,
        symplectic=True,
        backward=True,
        differentiates=True,
        by_name=True,
        cost_rank=70,
    )
    pattern = ScenePattern(
        elements={Spring: ANY, UniformGravity: ANY, CentralField: ANY}, only_points=True
    )

    def unsupported_values(self, problem: Motion) -> str | None:
        """None for springs that are linear or have a cubic term as well, else the reason."""
        for spring in problem.scene.all(Spring):
            if spring.exponent != 1 or spring.quadratic:
                return "a spring with a power of the stretch other than 1 and 3"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """The trajectory by fixed steps, with states and derivatives after every `stride` of
        them.
        """
        scene = request.problem.scene
        requested = request.sensitivities
        begun = perf_counter()
        world = acting(scene, requested)
        h = request.signed_step
        r = np.array(scene.bodies.position)
        v = np.array(scene.bodies.velocity)
        dr, dv = started(scene, requested)
        rows = [(r, v)]
        slopes = [state_derivatives(dr, dv)]
        a, da = world.acceleration(r, dr)
        for _ in range(len(request.problem.times) - 1):
            for _ in range(request.stride):
                # v' = v + h/2 F(r)/m, r+ = r + h v', v+ = v' + h/2 F(r+)/m, and alike for R and V.
                v = v + h / 2 * a
                dv = dv + h / 2 * da
                r = r + h * v
                dr = dr + h * dv
                a, da = world.acceleration(r, dr)
                v = v + h / 2 * a
                dv = dv + h / 2 * da
            rows.append((r, v))
            slopes.append(state_derivatives(dr, dv))
        seconds = perf_counter() - begun
        trajectory = Trajectory.of_points(
            request.problem.times,
            np.array([row[0] for row in rows]),
            np.array([row[1] for row in rows]),
            derivatives=_by_key(np.array(slopes), requested),
        )
        steps = request.stride * (len(rows) - 1)
        return trajectory, Cost(seconds=seconds, steps=steps)


def state_derivatives(dr: Array, dv: Array) -> Array:
    """Derivatives (N, K, 6) of positions and velocities at a sample."""
    return np.concatenate([dr, dv], axis=-1)


def _by_key(slopes: Array, requested: tuple[str, ...]) -> dict[str, Array]:
    """Derivatives (T, N, K, 6) as arrays (T, N, 13) by parameter; those of attitude and omega are
    0.
    """
    derivatives = {}
    for column, key in enumerate(requested):
        whole = np.zeros((*slopes.shape[:2], STATES))
        whole[..., :6] = slopes[:, :, column]
        derivatives[key] = whole
    return derivatives


METHOD = VariationalVerlet()
