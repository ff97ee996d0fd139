"""A rigid sphere meets a wall of any direction once: restitution, friction, spin about any axis."""

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
from refdem.scene.elements.plane import Plane
from refdem.truth.exact import number, vector

Array = NDArray[np.float64]


class HardWall(Case):
    """The wall passes through the origin; nothing acts on the sphere but the wall."""

    id = "hard-wall"
    title = "Hard sphere on a wall"
    words = ("bounce", "collision", "impact", "friction", "restitution", "floor")
    motion = "colliding"
    statement = (
        "A rigid sphere flies straight to a wall, meets it once and leaves. The wall is a second"
        " body of infinite mass: the normal velocity is turned round and multiplied by the"
        " restitution, friction stops the slip of the point that touches, or reverses a part of"
        " it, and is cut at mu times the normal impulse."
    )
    latex = (
        r"v_n'=-e\,v_n,\quad p_t=\min\!\left(\frac{(1+b)\,|\mathbf s|}{1/m+R^2/J},"
        r"\ \mu(1+e)\,m\,|v_n|\right)"
    )
    source = "Walton 1993, in Particulate two-phase flow, chapter 25; Garwin 1969, Am. J. Phys. 37"
    parameters = (
        *_rigid.one_sphere("sphere"),
        Parameter(
            name="normal",
            default="0,1,0",
            unit="1",
            doc="of the wall, of any length, towards the sphere",
            shape=(3,),
        ),
        Parameter(
            name="position", default="0,3/2,0", unit="m", doc="of the centre, at first", shape=(3,)
        ),
        Parameter(name="velocity", default="3/4,-1,0", unit="m/s", doc="of the centre", shape=(3,)),
        Parameter(name="spin", default="0,0,0", unit="rad/s", doc="omega at the start", shape=(3,)),
        *_rigid.LAW,
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a sphere that does not come nearer, or starts in the wall."""
        normal = vector(p, "normal")
        if not any(normal):
            raise UsageError("parameter normal: got 0,0,0; expected a direction")
        columns = zip(vector(p, "velocity"), normal, strict=True)
        if sum((v * n for v, n in columns), Fraction(0)) >= 0:
            raise UsageError(
                "parameter velocity: the sphere does not come nearer to the wall; expected a"
                " velocity against the normal"
            )
        height = sum(
            (r * n for r, n in zip(vector(p, "position"), normal, strict=True)), Fraction(0)
        )
        squared = sum((n * n for n in normal), Fraction(0))
        if height <= 0 or height**2 <= number(p, "radius") ** 2 * squared:
            raise UsageError(
                "parameter position: the sphere touches or overlaps the wall at the start; expected"
                f" its centre more than {p.radius:g} m from the wall"
            )

    def scene(self, p: Parameters) -> Scene:
        """The sphere, the wall and the rigid law."""
        body = _rigid.sphere(
            mass=p.mass,
            factor=p.inertia_factor,
            radius=p.radius,
            position=p.position,
            velocity=p.velocity,
            omega=p.spin,
        )
        unit = p.normal / np.linalg.norm(p.normal)
        return Scene.of([body], [_rigid.contact(p), Plane(normal=tuple(unit.tolist()))])

    def scales(self, p: Parameters) -> Scales:
        """L = |r|, tau = L/v with the faster of centre and surface; about twice the time to the
        impact.
        """
        unit = p.normal / np.linalg.norm(p.normal)
        impact_time = float((p.position @ unit - p.radius) / -(p.velocity @ unit))
        length = float(np.linalg.norm(p.position))
        surface = p.radius * float(np.linalg.norm(p.spin))
        fastest = max(float(np.linalg.norm(p.velocity)), surface)
        return Scales(
            length=length,
            tau=length / fastest,
            duration=_rigid.clear_of(impact_time, int(p.samples)),
            mass=p.mass,
        )

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Place, velocity and angular velocity."""
        scales = self.scales(p)
        # The largest spin, or that of rolling at the speed of the start.
        spin = max(float(np.linalg.norm(p.spin)), float(np.linalg.norm(p.velocity)) / p.radius)
        kinds = (("r", "m", scales.length), ("v", "m/s", scales.speed), ("omega", "rad/s", spin))
        found = []
        for kind, unit, size in kinds:
            found += [Quantity(f"{kind}.{axis}", unit, size) for axis in "xyz"]
        return tuple(found)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Place, velocity and angular velocity at the samples, each (T,)."""
        columns = (
            ("r", trajectory.position),
            ("v", trajectory.velocity),
            ("omega", trajectory.omega),
        )
        found = {}
        for kind, column in columns:
            for axis, name in enumerate("xyz"):
                found[f"{kind}.{name}"] = column[:, 0, axis]
        return found

    def truth(self, p: Parameters) -> Truth:
        """The straight line to the wall, the impulses in closed form."""
        from refdem.truth.closed_forms.hard_wall import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = HardWall()
