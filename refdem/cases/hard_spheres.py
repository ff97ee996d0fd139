"""Two rigid spheres meet once: restitution, friction, spins about all axes (section 1.7.4 in the
limit of stiff contacts).
"""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _rigid
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.truth.exact import number, vector

Array = NDArray[np.float64]


class HardSpheres(Case):
    """The centre of mass rests at the origin; the first sphere comes from -x, moving along +x."""

    id = "hard-spheres"
    title = "Hard spheres"
    words = ("collision", "billiard", "momentum", "friction", "impulse", "restitution", "particle")
    motion = "colliding"
    statement = (
        "Two rigid spheres start apart, meet once and part. The impact takes no time: its normal"
        " impulse leaves the part e of the closing speed, its tangential impulse stops the slip of"
        " the points that touch, or reverses the part b of it, and is cut at mu times the normal"
        " impulse. Momentum and total angular momentum stay; spin and orbital parts exchange."
    )
    latex = (
        r"p_n=(1+e)\,\frac{\mathbf g\cdot\mathbf n}{1/m_1+1/m_2},\quad"
        r" p_t=\min\!\left(\frac{(1+b)\,|\mathbf s|}"
        r"{1/m_1+1/m_2+R_1^2/J_1+R_2^2/J_2},\ \mu p_n\right)"
    )
    source = (
        "Walton 1993, in Particulate two-phase flow, chapter 25; Matuttis and Chen 2014, chapter 1,"
        " section 1.7.4"
    )
    parameters = (
        Parameter(
            name="masses", default="1,1", unit="kg", doc="of the two spheres", shape=(2,), above=0
        ),
        Parameter(name="radii", default="1/2,1/2", unit="m", doc="of the two", shape=(2,), above=0),
        Parameter(
            name="inertia_factors",
            default="2/5,2/5",
            unit="1",
            doc=_rigid.FACTORS,
            shape=(2,),
            above=0,
            at_most=1,
        ),
        Parameter(
            name="closing_speed",
            default="1",
            unit="m/s",
            doc="of the centres along x at the start",
            above=0,
        ),
        Parameter(
            name="distance",
            default="2",
            unit="1",
            doc="of the centres along x at the start, in sums of the radii",
            above=0,
        ),
        Parameter(
            name="offset",
            default="3/5,0",
            unit="1",
            doc="of the second centre along y and z, in sums of the radii: 0 is head-on",
            shape=(2,),
        ),
        Parameter(
            name="spins",
            default="0,0,0,0,0,0",
            unit="rad/s",
            doc="omega of the first and of the second sphere",
            shape=(2, 3),
        ),
        *_rigid.LAW,
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for spheres that pass each other, only graze, or do not start apart."""
        aside = sum((x * x for x in vector(p, "offset")), Fraction(0))
        if aside >= 1:
            what = "pass each other"
            if aside == 1:
                what = "only graze, with no closing speed at all"
            raise UsageError(
                f"parameter offset: at {float(aside) ** 0.5:g} sums of the radii the spheres"
                f" {what}; expected less than 1: take a smaller offset"
            )
        if number(p, "distance") ** 2 + aside <= 1:
            raise UsageError(
                f"parameter distance: got {p.distance:g} sums of the radii, at which the spheres"
                " touch or overlap at the start; expected them apart: take a larger distance"
            )

    def scene(self, p: Parameters) -> Scene:
        """The two spheres apart, and the rigid law."""
        reach = p.radii.sum()
        apart = reach * np.array([p.distance, *p.offset])
        approach = np.array([p.closing_speed, 0.0, 0.0])
        share = p.masses[::-1] / p.masses.sum()
        bodies = []
        for i, side in enumerate((1.0, -1.0)):
            part = side * share[i]
            body = _rigid.sphere(
                mass=p.masses[i],
                factor=p.inertia_factors[i],
                radius=p.radii[i],
                position=-part * apart,
                velocity=part * approach,
                omega=p.spins[i],
            )
            bodies.append(body)
        return Scene.of(bodies, [_rigid.contact(p)])

    def scales(self, p: Parameters) -> Scales:
        """L = R1 + R2, tau = L/v with the fastest of centres and surfaces; about twice the time to
        the impact.
        """
        reach = float(p.radii.sum())
        # The first root of |d + w t| = L with w along x: t = (d_x - L sqrt(1 - offset^2))/v.
        depth = np.sqrt(1.0 - float(p.offset @ p.offset))
        impact_time = reach * (p.distance - depth) / p.closing_speed
        surfaces = p.radii * np.linalg.norm(p.spins, axis=1)
        fastest = max(p.closing_speed, float(surfaces.max()))
        mass = float(p.masses[0] * p.masses[1] / p.masses.sum())
        return Scales(
            length=reach,
            tau=reach / fastest,
            duration=_rigid.clear_of(float(impact_time), int(p.samples)),
            mass=mass,
        )

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place, velocity and angular velocity of both."""
        scales = self.scales(p)
        # The largest spin, or that of rolling at the closing speed.
        spin = max(np.linalg.norm(p.spins, axis=1).max(), p.closing_speed / p.radii.min())
        kinds = (("r", "m", scales.length), ("v", "m/s", scales.speed), ("omega", "rad/s", spin))
        found = []
        for body in (1, 2):
            for kind, unit, size in kinds:
                found += [Quantity(f"{kind}{body}.{axis}", unit, float(size)) for axis in "xyz"]
        return tuple(found)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Place, velocity and angular velocity of both."""
        found = {}
        for body in (0, 1):
            columns = (
                ("r", trajectory.position),
                ("v", trajectory.velocity),
                ("omega", trajectory.omega),
            )
            for kind, column in columns:
                for axis, name in enumerate("xyz"):
                    found[f"{kind}{body + 1}.{name}"] = column[:, body, axis]
        return found

    def truth(self, p: Parameters) -> Truth:
        """The time of impact by a quadratic, the impulses in closed form."""
        from refdem.truth.closed_forms.hard_spheres import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = HardSpheres()
