"""A granular gas: spheres that lose energy when they meet cool by Haff's law; elastic ones keep
their temperature.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _gas, _gas_start
from refdem.core.case import CLOCK, Case
from refdem.core.parameters import Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene
from refdem.scene.elements.uniform_gravity import UniformGravity

Array = NDArray[np.float64]

MASS = 1.0
"""Mass of a sphere [kg]. Cooling and collisions do not depend on it: it cancels."""
HARD = 1 / 64
"""Duration of a contact in units of the time in which a body flies its diameter at thermal
speed.
"""
FLIGHT = 16
"""Duration of the motion in units of that time."""

SAMPLES = replace(CLOCK[1], default="16")
CHAOTIC = (
    "the motion is chaotic: a run with another step meets otherwise, and only means over many"
    " collisions can be compared"
)


class GranularGas(Case):
    """Spheres of 1 kg, smooth unless there is friction, in a cube of edge (n/density)^(1/3): a
    periodic one, or one with walls.
    """

    id = "granular-gas"
    title = "Granular gas"
    words = ("dem", "cooling", "haff", "particles", "box", "collisions")
    motion = "colliding"
    statement = (
        "Smooth spheres fly about and meet two at a time. In every contact a linear spring and"
        " dashpot, or a rigid impact, give back the same part e of the normal velocity. An elastic"
        " gas keeps its temperature and Maxwell's velocities; with e < 1, dilute and before"
        " clusters form, it cools as Haff's law says. Friction, by a tangential spring where"
        " contacts are soft, makes them spin. Momentum is kept in a periodic box, and a gas that"
        " falls freely in one cools as without gravity. The temperature is that of flight and"
        " counts 3 (n - 1) degrees of freedom, for the centre of mass is at rest or falls;"
        " Boltzmann's constant is 1. The start follows from the seed by numpy's PCG64."
    )
    latex = (
        r"T=\frac{T_0}{(1+t/\tau)^2},\quad\tau=\frac{2D}{(1-e^2)\,\omega_c},"
        r"\quad\omega_c=4\sqrt{\pi}\,n\sigma^2\chi\sqrt{T_0/m}"
    )
    source = (
        "Haff 1983; Brilliantov and Poeschel 2004, chapter 5; chi of Carnahan and Starling 1969;"
        " Matuttis and Chen 2014, 1.7"
    )
    parameters = _gas.PARAMETERS
    clock = (CLOCK[0], SAMPLES)
    exclude = dict.fromkeys(("error", "order", "convergence"), CHAOTIC)

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a box too full for a gas, or so small that a sphere would meet two
        images of another.
        """
        _gas.refuse(p)

    def scene(self, p: Parameters) -> Scene:
        """Spheres, what bounds them, and the law by which contacts give back e: soft ones last pi
        tau.
        """
        rng = np.random.Generator(np.random.PCG64(int(p.seed)))
        n = int(p.n)
        edge = _gas.edge(p)
        periodic = p.boundary == "periodic"
        # The order of the two draws is part of the start that a seed stands for.
        position = _gas_start.places(rng, n, p.diameter, edge, periodic=periodic)
        velocity = _gas_start.velocities(rng, n, p.t0 / MASS)
        bodies = _gas_start.bodies(position, velocity, MASS, p.diameter)
        if p.contact == "rigid":
            law = _gas.rigid_law(p.restitution, p.friction)
        else:
            contact_time = np.pi * self.scales(p).tau
            law = _gas.law(MASS, contact_time, p.restitution, p.friction)
        elements = [*_gas.bounds(edge, periodic=periodic), law]
        if p.gravity:
            elements.append(UniformGravity(g=(0.0, 0.0, -p.gravity)))
        return Scene(bodies, tuple(elements))

    def scales(self, p: Parameters) -> Scales:
        """tau = contact duration/pi; L is the way at thermal speed in tau.

        Where contacts take no time, tau is the time of flight D/sqrt(T0/m) over a diameter.
        """
        time_of_flight = p.diameter * np.sqrt(MASS / p.t0)
        if p.contact == "rigid":
            tau = float(time_of_flight)
        else:
            tau = float(HARD * time_of_flight / np.pi)
        length = float(tau * np.sqrt(p.t0 / MASS))
        duration = float(FLIGHT * time_of_flight)
        return Scales(length=length, tau=tau, duration=duration, mass=MASS)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantity that is judged: the temperature [J] of the gas."""
        return (Quantity("temperature", "J", p.t0),)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Temperature m sum |v - V|^2/(3 (n - 1)), V the velocity of the centre of mass."""
        centre_velocity = trajectory.velocity.mean(axis=1, keepdims=True)
        relative = trajectory.velocity - centre_velocity
        square = np.einsum("tnk,tnk->t", relative, relative)
        return {"temperature": MASS * square / (3 * (p.n - 1))}

    def truth(self, p: Parameters) -> Truth:
        """The time of Haff's law; the motion itself is chaotic."""
        from refdem.truth.closed_forms.granular_gas import truth

        return truth(p)


CASE = GranularGas()
