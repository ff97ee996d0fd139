"""A scene as a REBOUND simulation: particles, callbacks, Euler's equations and the integrator."""

from collections.abc import Callable
from ctypes import addressof, c_void_p, cast
from typing import Any

import numpy as np
import rebound
from rebound.ode import ODE, ODEDER
from rebound.simulation import AFF

from refdem import kernels
from refdem.core.problem import Request
from refdem.engines.rebound.fields import FAMILY, Fields
from refdem.engines.rebound.methods import AS_SHIPPED, LEAPFROG_LINE
from refdem.errors import EngineError
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Scene
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact

FIRST_STEP = 2.0**-8
"""First step of the adaptive integrators, in units of the sample interval: REBOUND's default is a
thousandth of a unit of time.
"""
ORDER_OF_COLLISIONS = 1
"""Seed of the random order in which the collisions of one step are resolved."""
SWINGING = 1e-10
"""epsilon of ias15 with springs and rods, in place of REBOUND's 1e-9.

The predictor-corrector iteration of a step ends where the change of the last coefficient of its
series increases. By chance this may happen before the other coefficients have converged: at 1e-9
one run in six of a damped, driven oscillator has a step with an error of 2e-13. At 1e-10 none has.
"""


def simulation_of(request: Request, fields: Fields) -> tuple[rebound.Simulation, ODE | None]:
    """The simulation, ready to be stepped, and the further equations of its rotors."""
    scene = request.problem.scene
    sim = rebound.Simulation()
    sim.t = float(request.problem.times[0])
    # A new simulation has the defaults that REBOUND is shipped with.
    if request.method != AS_SHIPPED.name:
        _set_integrator(sim, request)
    first_body = _add_particles(sim, scene)
    _place(sim, fields, first_body)
    set_collisions(sim, scene, request.method)
    ode = _add_rotors(sim, scene, fields)
    if fields.has_forces:
        # Set behind the property, which would wrap the compiled callback in Python.
        sim._additional_forces = AFF(_callback("forces", rebound.Simulation.extras.offset))
        sim.force_is_velocity_dependent = int(fields.reads_velocity)
    return sim, ode


def function_address(name: str) -> int:
    """The address of a function of the loaded librebound."""
    return int(cast(getattr(rebound.clibrebound, name), c_void_p).value or 0)


def _set_integrator(sim: rebound.Simulation, request: Request) -> None:
    """The integrator of the method and its first step, with the direction of time."""
    interval = request.problem.interval
    # Methods are named integrator or integrator-variant.
    name, _, variant = request.method.partition("-")
    sim.integrator = name
    if name == "leapfrog":
        sim.dt = request.signed_step
        sim.integrator.order = 2
        if variant == "8":
            sim.integrator.order = 8
    elif name == "whfast":
        sim.dt = interval
    elif name == "ias15":
        sim.dt = FIRST_STEP * interval
        sim.integrator.adaptive_mode = "prs23"
        if {"spring", "rod"} & request.problem.scene.features:
            sim.integrator.adaptive_mode = "global"
            sim.integrator.epsilon = SWINGING
    elif name == "bs":
        sim.dt = FIRST_STEP * interval
        sim.integrator.eps_rel = request.tolerance
        sim.integrator.eps_abs = request.tolerance


def _add_particles(sim: rebound.Simulation, scene: Scene) -> int:
    """The attracting centre, if there is one, and the bodies; the number of the first body among
    the particles.
    """
    centres = scene.all(CentralField)
    if centres:
        sim.gravity = "basic"
        sim.add(m=sum(centre.gm for centre in centres))
        # Only the centre attracts: the bodies are test particles, without a mass of their own.
        sim.N_active = 1
        masses = np.zeros(len(scene.bodies))
    else:
        sim.gravity = "none"
        masses = scene.bodies.mass
    for number, mass in enumerate(masses):
        _add_body(sim, scene, number, mass)
    return int(sim.N) - len(scene.bodies)


def _add_body(sim: rebound.Simulation, scene: Scene, number: int, mass: float) -> None:
    """A body as a particle of this mass [kg]; a fixed one is at rest."""
    bodies = scene.bodies
    x, y, z = bodies.position[number]
    vx, vy, vz = bodies.velocity[number]
    if bodies.fixed[number]:
        vx = vy = vz = 0.0
    sim.add(m=mass, r=bodies.radius[number], x=x, y=y, z=z, vx=vx, vy=vy, vz=vz)


def set_collisions(sim: rebound.Simulation, scene: Scene, method: str) -> None:
    """REBOUND's own hard spheres, where the contact law is rigid: searched for at the end of every
    step, and resolved with the law's restitution.

    `direct` finds pairs that overlap at the end of the step, `line` also pairs that overlapped on
    the straight path of the step. Of these, `hardsphere` resolves only pairs that overlap and
    approach at the end of the step (validation/expected/deviations/rebound_line.py).
    """
    for law in scene.all(Contact):
        if law.law != "rigid":
            continue
        sim.collision = "direct"
        if method == LEAPFROG_LINE.name:
            sim.collision = "line"
        sim.collision_resolve = "hardsphere"
        sim.coefficient_of_restitution = _always(float(law.restitution))
        if method != AS_SHIPPED.name:
            # The collisions of a step are resolved in a random order, whose seed would be drawn
            # from the clock.
            sim.rand_seed = ORDER_OF_COLLISIONS


def _always(restitution: float) -> Callable[[Any, float], float]:
    """The function that REBOUND calls at every collision for the coefficient of restitution: here
    the same at every closing speed [m/s].
    """

    def coefficient(simulation: Any, speed: float) -> float:
        return restitution

    return coefficient


def _place(sim: rebound.Simulation, fields: Fields, first: int) -> None:
    """Passes the memory addresses of the bodies' particles, from particle `first` on, to the
    callbacks, and that of the fields to the simulation.
    """
    ffi = kernels.load(FAMILY).ffi
    particle = rebound.Particle
    base = addressof(sim._particles[0])
    size = addressof(sim._particles[1]) - base
    struct = fields.struct
    struct.particle = ffi.cast("char *", base + first * size)
    struct.size = size
    struct.position = particle.x.offset
    struct.velocity = particle.vx.offset
    struct.acceleration = particle.ax.offset
    struct.clock = ffi.cast("double *", addressof(sim) + rebound.Simulation.t.offset)
    sim.extras = int(ffi.cast("uintptr_t", struct))


def _add_rotors(sim: rebound.Simulation, scene: Scene, fields: Fields) -> ODE | None:
    """Attitude and body-axes omega of every body that turns, as further equations of bs."""
    if not fields.rotors:
        return None
    ode = sim.create_ode(length=7 * len(fields.rotors), needs_nbody=False)
    ode.ref = int(kernels.load(FAMILY).ffi.cast("uintptr_t", fields.struct))
    ode._derivatives = ODEDER(_callback("euler", ODE.ref.offset))
    rotors = list(fields.rotors)
    attitude = scene.bodies.attitude[rotors]
    omega_body = rotated(conjugate(attitude), scene.bodies.omega[rotors])
    start = np.hstack([attitude, omega_body]).ravel().tolist()
    for number, value in enumerate(start):
        ode.y[number] = value
    return ode


def _callback(name: str, place: int) -> int:
    """The compiled callback for an engine that keeps its user's pointer at byte `place`."""
    library: Any = kernels.load(FAMILY)
    callback = getattr(library.lib, f"refdem_rebound_{name}")(place)
    if callback == library.ffi.NULL:
        raise EngineError(
            f"rebound keeps its user's pointer at byte {place} of its struct; the callbacks know"
            " places 0 to 1016"
        )
    return int(library.ffi.cast("uintptr_t", callback))
