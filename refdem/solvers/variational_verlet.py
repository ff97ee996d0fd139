"""Velocity Verlet for points in smooth fields together with its equations of first variation.

With the force F(r, s) of numbers s of the scene, and R = dr/ds, V = dv/ds, a step of h is

    v' = v + h/2 F(r)/m,    r+ = r + h v',    v+ = v' + h/2 F(r+)/m        (Swope et al. 1982),
    V' = V + h/2 A(r, R),   R+ = R + h V',    V+ = V' + h/2 A(r+, R+),

where A = d(F/m)/ds along R. These are the derivatives of the steps themselves, to the last digit.
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
"""Numbers of the state of a body: position, velocity, attitude, omega."""


@dataclass(frozen=True)
class Acting:
    """The elements of a scene, each with the slopes of its numbers by those that are asked for.

    `mass` (N,) [kg] has the slopes `mass_slope` (N, K); `slopes` are those of each element by the
    name of its field, (K,) of a number and (K, 3) of a vector.
    """

    elements: tuple[Any, ...]
    slopes: tuple[dict[str, Array], ...]
    mass: Array
    mass_slope: Array

    def acceleration(self, r: Array, dr: Array) -> tuple[Array, Array]:
        """F/m (N, 3) [m/s^2] at the places r (N, 3), and its slopes (N, K, 3) along those of the
        places, dr.
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
        """Adds what a spring does: F = -f d, with the vector d between its ends."""
        if spring.b >= 0:
            d = r[spring.a] - r[spring.b]
            dd = dr[spring.a] - dr[spring.b]
        else:
            d = r[spring.a] - np.array(spring.anchor_b)
            dd = dr[spring.a] - slopes["anchor_b"]
        f, df = spring_factor(spring, slopes, d, dd)
        force = -f * d
        # d(f d) = df d + f dd.
        force_slope = -np.outer(df, d) - f * dd
        self._push(spring.a, force, force_slope, a, da)
        if spring.b >= 0:
            self._push(spring.b, -force, -force_slope, a, da)

    def _push(self, body: int, force: Array, force_slope: Array, a: Array, da: Array) -> None:
        """Adds F/m; d(F/m) = (dF - (F/m) dm)/m."""
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
    """The factor f of F = -f d of a spring with F = -(k s + c s^3) d/|d|, s = |d| - l, and its
    slopes (K,) along dd (K, 3).
    """
    k = spring.stiffness
    c = spring.cubic
    length = spring.length
    dk = slopes["stiffness"]
    dc = slopes["cubic"]
    dl = slopes["length"]
    square = float(d @ d)
    if not length and not np.any(dl):
        # f = k + c |d|^2, also where the ends meet.
        return k + c * square, dk + dc * square + 2.0 * c * (dd @ d)
    distance = float(np.sqrt(square))
    stretch = distance - length
    pull = k * stretch + c * stretch**3
    distance_slope = dd @ d / distance
    stretch_slope = distance_slope - dl
    pull_slope = dk * stretch + dc * stretch**3 + (k + 3.0 * c * stretch**2) * stretch_slope
    # f = pull/|d|.
    f = pull / distance
    return f, (pull_slope - f * distance_slope) / distance


def acting(scene: Scene, asked: tuple[str, ...]) -> Acting:
    """The elements and masses of a scene, and their slopes by the numbers asked for."""
    count = len(asked)
    mass_slope = np.zeros((len(scene.bodies), count))
    slopes = []
    for element in scene.elements:
        of_element = {}
        for name in element.__struct_fields__:
            shape = np.shape(getattr(element, name))
            of_element[name] = np.zeros((count, *shape))
        slopes.append(of_element)
    for column, key in enumerate(asked):
        _, of, number, name, *component = key.split(".")
        if of == "elements":
            slopes[int(number)][name][(column, *map(int, component))] = 1.0
        elif name == "mass":
            mass_slope[int(number), column] = 1.0
    return Acting(tuple(scene.elements), tuple(slopes), scene.bodies.mass, mass_slope)


def started(scene: Scene, asked: tuple[str, ...]) -> tuple[Array, Array]:
    """The slopes (N, K, 3) of places and of velocities at the start by the numbers asked for."""
    slopes = {
        name: np.zeros((len(scene.bodies), len(asked), 3)) for name in ("position", "velocity")
    }
    for column, key in enumerate(asked):
        _, of, number, name, *component = key.split(".")
        if of == "bodies" and name in slopes:
            slopes[name][int(number), column, int(component[0])] = 1.0
    return slopes["position"], slopes["velocity"]


class VariationalVerlet(SceneSolver):
    """Points on springs in gravity or a central field, with derivatives by any number of them."""

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
        """None for springs that are linear or have a cube beside it, else the reason."""
        for spring in problem.scene.all(Spring):
            if spring.exponent != 1 or spring.quadratic:
                return "a spring with a power of the stretch other than 1 and 3"
        return None

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Fixed steps; states and slopes after every `stride` of them."""
        scene = request.problem.scene
        asked = request.sensitivities
        begun = perf_counter()
        world = acting(scene, asked)
        h = request.signed_step
        r = np.array(scene.bodies.position)
        v = np.array(scene.bodies.velocity)
        dr, dv = started(scene, asked)
        rows = [(r, v)]
        slopes = [told(dr, dv)]
        a, da = world.acceleration(r, dr)
        for _ in range(len(request.problem.times) - 1):
            for _ in range(request.stride):
                v = v + h / 2 * a
                dv = dv + h / 2 * da
                r = r + h * v
                dr = dr + h * dv
                a, da = world.acceleration(r, dr)
                v = v + h / 2 * a
                dv = dv + h / 2 * da
            rows.append((r, v))
            slopes.append(told(dr, dv))
        seconds = perf_counter() - begun
        trajectory = Trajectory.of_points(
            request.problem.times,
            np.array([row[0] for row in rows]),
            np.array([row[1] for row in rows]),
            derivatives=_by_key(np.array(slopes), asked),
        )
        steps = request.stride * (len(rows) - 1)
        return trajectory, Cost(seconds=seconds, steps=steps)


def told(dr: Array, dv: Array) -> Array:
    """The slopes (N, K, 6) of places and velocities at a sample."""
    return np.concatenate([dr, dv], axis=-1)


def _by_key(slopes: Array, asked: tuple[str, ...]) -> dict[str, Array]:
    """The slopes (T, N, K, 6) as (T, N, 13) by key; a point does not turn."""
    derivatives = {}
    for column, key in enumerate(asked):
        whole = np.zeros((*slopes.shape[:2], STATES))
        whole[..., :6] = slopes[:, :, column]
        derivatives[key] = whole
    return derivatives


METHOD = VariationalVerlet()
