"""A scene in REBOUND's words: particles, callbacks, Euler's equations and the integrator."""

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
from refdem.engines.rebound.methods import AS_SHIPPED
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

The iteration of a step ends where the last coefficient of its series changes by more than it did
the time before, which by chance it may do while the others are still wrong: at 1e-9 one run in
six of a damped, driven oscillator has a step that is off by 2e-13. At 1e-10 none has.
"""


def simulation_of(request: Request, fields: Fields) -> tuple[rebound.Simulation, ODE | None]:
    """The simulation, ready to be stepped, and the further equations of its rotors."""
    scene = request.problem.scene
    sim = rebound.Simulation()
    sim.t = float(request.problem.times[0])
    _set_integrator(sim, request)
    first = _add_particles(sim, scene)
    _place(sim, fields, first)
    set_collisions(sim, scene, request.method)
    ode = _add_rotors(sim, scene, fields)
    if fields.has_forces:
        sim._additional_forces = AFF(
            _callback("forces", rebound.Simulation.extras.offset)
        )  # the property would wrap it in Python
        sim.force_is_velocity_dependent = int(fields.reads_velocity)
    return sim, ode


def function_address(name: str) -> int:
    """The address of a function of the loaded librebound."""
    return int(cast(getattr(rebound.clibrebound, name), c_void_p).value or 0)


def _set_integrator(sim: rebound.Simulation, request: Request) -> None:
    """The integrator of the method and its first step, with the direction of time."""
    if request.method == AS_SHIPPED.name:
        # All of it stays as a new simulation has it, the first step too.
        return
    name, _, _ = request.method.partition("-")
    sim.integrator = name
    if name == "leapfrog":
        if request.method == "leapfrog-8":
            sim.integrator.order = 8
        else:
            sim.integrator.order = 2
        sim.dt = request.signed_step
    elif name == "whfast":
        sim.dt = request.problem.interval
    else:
        sim.dt = FIRST_STEP * request.problem.interval
    if name == "ias15":
        linked = {"spring", "rod"} & request.problem.scene.features
        if linked:
            sim.integrator.adaptive_mode = "global"
        else:
            sim.integrator.adaptive_mode = "prs23"
        if linked:
            sim.integrator.epsilon = SWINGING
    if name == "bs":
        sim.integrator.eps_rel = sim.integrator.eps_abs = request.tolerance


def _add_particles(sim: rebound.Simulation, scene: Scene) -> int:
    """The attracting centre, if there is one, and the bodies; the number of the first body among
    the particles.
    """
    centres = scene.all(CentralField)
    if centres:
        sim.gravity = "basic"
    else:
        sim.gravity = "none"
    if centres:
        sim.add(m=sum(centre.gm for centre in centres))
        sim.N_active = 1
    columns = scene.bodies
    for mass, radius, (x, y, z), (vx, vy, vz), fixed in zip(
        columns.mass,
        columns.radius,
        columns.position,
        columns.velocity,
        columns.fixed,
        strict=True,
    ):
        if fixed:
            still = {}
        else:
            still = {"vx": vx, "vy": vy, "vz": vz}
        # Beside a centre bodies do not attract each other.
        if centres:
            attracting = 0.0
        else:
            attracting = mass
        sim.add(m=attracting, r=radius, x=x, y=y, z=z, **still)
    return len(centres[:1])


def set_collisions(sim: rebound.Simulation, scene: Scene, method: str) -> None:
    """REBOUND's own hard spheres, where the contact law is rigid: searched for at the end of every
    step, and resolved with the law's restitution.

    direct finds pairs that overlap then, line also those that did on the straight way of the step.
    """
    for law in scene.all(Contact):
        if law.law != "rigid":
            continue
        if method == "leapfrog-line":
            sim.collision = "line"
        else:
            sim.collision = "direct"
        sim.collision_resolve = "hardsphere"
        sim.coefficient_of_restitution = _always(float(law.restitution))
        if method != AS_SHIPPED.name:
            # Those of a step are resolved in a random order, whose seed is else the clock's.
            sim.rand_seed = ORDER_OF_COLLISIONS


def _always(restitution: float) -> Callable[[Any, float], float]:
    """What REBOUND asks at every collision: the coefficient of restitution, here the same at every
    approaching speed [m/s].
    """

    def coefficient(simulation: Any, speed: float) -> float:
        return restitution

    return coefficient


def _place(sim: rebound.Simulation, fields: Fields, first: int) -> None:
    """Tells the callbacks where the particles lie, and the simulation where the fields do."""
    ffi = kernels.load(FAMILY).ffi
    particle = rebound.Particle
    base = addressof(sim._particles.contents)
    size = addressof(sim._particles[1]) - addressof(sim._particles[0])
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
    omega = scene.bodies.omega[rotors]
    for number, value in enumerate(
        np.hstack([attitude, rotated(conjugate(attitude), omega)]).ravel().tolist()
    ):
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
