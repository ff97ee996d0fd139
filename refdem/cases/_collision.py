"""The collision of two spheres under the linear contact law: parameters, scene and scales.

With the effective mass m = m1 m2/(m1 + m2), stiffness k and dashpot c the overlap d obeys

    m d'' + c d' + k d = 0,   b = c/(2 m),   w0 = sqrt(k/m),   w = sqrt(|w0^2 - b^2|).
"""

import numpy as np

from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Scales
from refdem.errors import UsageError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact

PARAMETERS = (
    Parameter(
        name="masses", default="1,1", unit="kg", doc="of the two spheres", shape=(2,), above=0
    ),
    Parameter(
        name="radii",
        default="1/2,1/2",
        unit="m",
        doc="of the two spheres; inertia 2/5 m R^2",
        shape=(2,),
        above=0,
    ),
    Parameter(name="stiffness", default="128", unit="N/m", doc="normal spring", above=0),
    Parameter(name="damping", default="0", unit="kg/s", doc="normal dashpot", at_least=0),
    Parameter(
        name="closing_speed", default="1", unit="m/s", doc="size of the relative velocity", above=0
    ),
    Parameter(
        name="tangential_stiffness",
        default="0",
        unit="N/m",
        doc="0: sliding friction of full size",
        at_least=0,
    ),
    Parameter(name="friction", default="0", unit="1", doc="Coulomb's coefficient", at_least=0),
    Parameter(
        name="angle",
        default="0",
        unit="rad",
        doc="of the relative velocity from the normal",
        at_least=-1.5,
        at_most=1.5,
    ),
    Parameter(
        name="spins",
        default="0,0,0,0,0,0",
        unit="rad/s",
        doc="omega of the first and of the second sphere",
        shape=(2, 3),
    ),
    Parameter(
        name="branch",
        default="R-d/2",
        unit="1",
        doc="lever arm of slip and torque; slip-R: of the torque R-d/2, of the slip R",
        choices=("R", "R-d", "R-d/2", "slip-R"),
    ),
    Parameter(
        name="cutoff",
        default="zero_overlap",
        unit="1",
        doc="when the force ends",
        choices=("zero_overlap", "zero_force"),
    ),
)
POSITIONS_ARE_ROUNDED = 1 / 8
"""The least length scale in units of R: a position near R is rounded by u R, and round-off is
judged as 8 u L, so that L must not be below R/8.
"""


def effective_mass(p: Parameters) -> float:
    """The effective mass m1 m2/(m1 + m2) [kg] of the two spheres."""
    return float(p.masses[0] * p.masses[1] / p.masses.sum())


def duration(p: Parameters) -> float | None:
    """Duration [s] of the contact, which ends with the overlap or with the force (`cutoff`).

    None for an over-damped overlap, which never ends.
    """
    b = p.damping / (2 * effective_mass(p))
    w0 = np.sqrt(p.stiffness / effective_mass(p))
    w = np.sqrt(abs(w0 * w0 - b * b))
    if p.cutoff == "zero_overlap":
        # The overlap exp(-b t) sin(w t) ends after half a period.
        if b < w0:
            return float(np.pi / w)
        return None
    # The force k d + c d' ends where tan(w t/2) = w/b, or tanh(w t/2) = w/b if over-damped.
    if b == w0:
        return float(2 / w0)
    if b < w0:
        return float(2 * np.arccos(b / w0) / w)
    return float(np.log((b + w) / (b - w)) / w)


def refuse(p: Parameters) -> None:
    """Raises UsageError for spheres so soft or so fast that their centres could meet."""
    # The overlap of an undamped head-on collision, m v^2/2 = k d^2/2.
    deepest = p.closing_speed * np.sqrt(effective_mass(p) / p.stiffness)
    if deepest >= p.radii.sum():
        raise UsageError(
            f"parameter closing_speed: got {p.closing_speed:g} m/s, which lets the overlap reach"
            f" {deepest:g} m; expected it below the sum of the radii {p.radii.sum():g} m: take"
            " stiffer, slower or larger spheres"
        )


def scene(p: Parameters) -> Scene:
    """Sphere 1 at x < 0, sphere 2 at x > 0, centre of mass at rest at the origin."""
    # With the centre of mass at rest at the origin, sphere 1 has the part m2/(m1 + m2) of the
    # relative position and velocity, and sphere 2 the part m1/(m1 + m2).
    shares = p.masses[::-1] / p.masses.sum()
    distance = p.radii.sum()
    relative_velocity = p.closing_speed * np.array([np.cos(p.angle), np.sin(p.angle), 0.0])
    columns = zip(p.masses, p.radii, shares, (1.0, -1.0), p.spins, strict=True)
    bodies = []
    for mass, radius, share, sign, spin in columns:
        # J = 2/5 m R^2.
        moment = 0.4 * mass * radius * radius
        body = Body(
            mass=mass,
            inertia=(moment, moment, moment),
            shape=Sphere(radius=float(radius)),
            omega=tuple(spin),
            position=(-sign * share * distance, 0.0, 0.0),
            velocity=tuple(sign * share * relative_velocity),
        )
        bodies.append(body)
    numbers = {
        name: getattr(p, name)
        for name in ("stiffness", "damping", "tangential_stiffness", "friction", "branch", "cutoff")
    }
    return Scene.of(bodies, [Contact(law="linear", **numbers)])


def scales(p: Parameters) -> Scales:
    """Scales of the collision; it lasts two contact durations.

    tau is the least of contact duration/pi and the fastest rate of the free overlap: 1/w0, or m/c
    if over-damped. L is the way at the closing speed in tau, but at least R/8.
    """
    mass = effective_mass(p)
    contact_time = duration(p)
    oscillation = np.sqrt(mass / p.stiffness)
    if p.damping:
        relaxation = mass / p.damping
    else:
        relaxation = np.inf
    if contact_time:
        half_period = contact_time / np.pi
        lasts = 2 * contact_time
    else:
        half_period = np.inf
    # c < 2 sqrt(k m), less than critical damping, is m/c > sqrt(m/k)/2.
    is_underdamped = relaxation > oscillation / 2
    if is_underdamped:
        fastest = oscillation
    else:
        fastest = relaxation
    tau = float(min(half_period, fastest))
    if not contact_time:
        lasts = 2 * np.pi * tau
    length = max(p.closing_speed * tau, float(p.radii.max()) * POSITIONS_ARE_ROUNDED)
    return Scales(length=length, tau=tau, duration=lasts, mass=mass)


def spin_scale(p: Parameters) -> float:
    """The larger of the largest spin and the spin v/R of rolling at the closing speed [rad/s]."""
    largest_spin = np.linalg.norm(p.spins, axis=1).max()
    rolling = p.closing_speed / p.radii.min()
    return float(max(largest_spin, rolling))
