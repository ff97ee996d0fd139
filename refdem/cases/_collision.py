"""What the collision of two spheres needs: parameters, geometry and signs, and how long the contact
lasts.
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
    Parameter(name="damping", default="1", unit="kg/s", doc="normal dashpot", at_least=0),
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
        doc="lever arm of the tangential force",
        choices=("R", "R-d", "R-d/2"),
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
"""A position near R is rounded to u R; round-off is judged as 8 u L, so that L must not be below
R/8.
"""


def effective_mass(p: Parameters) -> float:
    """The effective mass m1 m2/(m1 + m2) [kg] of the two spheres."""
    return float(p.masses[0] * p.masses[1] / p.masses.sum())


def duration(p: Parameters) -> float | None:
    """How long the contact lasts [s], for either cut-off.

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
    # The force ends where tan(w t/2) = w/b, or tanh of it.
    if b == w0:
        return float(2 / w0)
    if b < w0:
        return float(2 * np.arccos(b / w0) / w)
    return float(np.log((b + w) / (b - w)) / w)


def refuse(p: Parameters) -> None:
    """Raises UsageError for spheres so soft or so fast that their centres could meet."""
    deepest = p.closing_speed * np.sqrt(effective_mass(p) / p.stiffness)
    if deepest >= p.radii.sum():
        raise UsageError(
            f"parameter closing_speed: got {p.closing_speed:g} m/s, which lets the overlap reach"
            f" {deepest:g} m; expected it below the sum of the radii {p.radii.sum():g} m: take"
            " stiffer, slower or larger spheres"
        )


def scene(p: Parameters) -> Scene:
    """Sphere 1 at x < 0, sphere 2 at x > 0, centre of mass at rest at the origin."""
    share = p.masses[::-1] / p.masses.sum()
    gap = p.radii.sum()
    approach = p.closing_speed * np.array([np.cos(p.angle), np.sin(p.angle), 0.0])
    columns = zip(p.masses, p.radii, share, (1.0, -1.0), p.spins, strict=True)
    bodies = []
    for mass, radius, part, sign, spin in columns:
        # J = 2/5 m R^2.
        moment = 0.4 * mass * radius * radius
        body = Body(
            mass=mass,
            inertia=(moment, moment, moment),
            shape=Sphere(radius=float(radius)),
            omega=tuple(spin),
            position=(-sign * part * gap, 0.0, 0.0),
            velocity=tuple(sign * part * approach),
        )
        bodies.append(body)
    numbers = {
        name: getattr(p, name)
        for name in ("stiffness", "damping", "tangential_stiffness", "friction", "branch", "cutoff")
    }
    return Scene.of(bodies, [Contact(law="linear", **numbers)])


def scales(p: Parameters) -> Scales:
    """tau = contact duration/pi, but no longer than 1/w0 (near critical damping pi/w is) or an
    over-damped one's m/c; two contacts.
    """
    lasts = duration(p)
    swing = np.sqrt(effective_mass(p) / p.stiffness)
    if p.damping:
        relaxation = effective_mass(p) / p.damping
    else:
        relaxation = np.inf
    if lasts:
        contact = lasts / np.pi
    else:
        contact = np.inf
    if relaxation > swing / 2:
        fastest = swing
    else:
        fastest = relaxation
    tau = float(min(contact, fastest))
    length = max(p.closing_speed * tau, float(p.radii.max()) * POSITIONS_ARE_ROUNDED)
    return Scales(
        length=length,
        tau=tau,
        duration=2 * lasts if lasts else 2 * np.pi * tau,
        mass=effective_mass(p),
    )


def spin_scale(p: Parameters) -> float:
    """The largest spin, or that of rolling at the closing speed [rad/s]."""
    return float(max(np.linalg.norm(p.spins, axis=1).max(), p.closing_speed / p.radii.min()))
