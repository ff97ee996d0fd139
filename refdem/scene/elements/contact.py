"""The contact law between shapes that meet: linear spring-dashpot with tangential spring and
Coulomb limit, Hertz's, or rigid.
"""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from msgspec import UNSET, UnsetType
from msgspec.structs import force_setattr

from refdem.mechanics.neighbours import FEW, near_pairs
from refdem.mechanics.quaternion import rotated
from refdem.scene.dimension import Damping, Dimension, Number, Stiffness
from refdem.scene.element import Array, Element
from refdem.scene.elements.periodic_box import PeriodicBox
from refdem.scene.elements.plane import Plane
from refdem.scene.singularity import JUMP, KINK, Singularity

SHORTENINGS = {"R": (0.0, 0.0), "R-d": (1.0, 1.0), "R-d/2": (0.5, 0.5), "slip-R": (0.0, 0.5)}
"""By `branch`: the shares of the overlap by which the levers of slip and of torque are shorter than
the radius.
"""


class Contact(Element, frozen=True, kw_only=True, tag="contact"):
    """One law for every pair of shapes in the scene, planes included.

    linear: normal force `stiffness * overlap + damping * d(overlap)/dt`; tangential spring
    `tangential_stiffness * slip` with no dashpot, clipped (spring included) at `friction` times the
    normal force, nothing while that pulls;
    `tangential_stiffness = 0` with friction > 0 is sliding friction of full size whenever there is
    slip. The spring is 0 at the touch and turns with the plane of contact. `branch` is the lever
    arm of the tangential force, and that at which slip is measured: the radius R, R - overlap, or R
    - overlap/2, with each sphere's own R. `slip-R` has two levers: slip is measured at R, and the
    torque of the tangential force has the lever R - overlap/2, as in the pair style granular of
    LAMMPS. The power of its tangential force is then not force times slip.
    `cutoff`: the force ends with the overlap, or already when it would pull (zero_force). hertz:
    normal force
    `stiffness * overlap**(3/2)` (Hertz 1882) and tangential spring `tangential_stiffness *
    sqrt(overlap) * slip` (after Mindlin 1949), both [N/m^(3/2)], clipped alike, without damping;
    that spring grows stiffer with its load, so that it stores no energy of its own. rigid: no
    overlap; spheres that meet exchange an impulse at once. Its normal part is (1 + `restitution`)
    times the effective mass times the closing speed. Its tangential part would leave the slip of
    the point of contact multiplied by -`tangential_restitution` (0, which is what it is when it is
    not set, stops the slip; 1 reverses it), and is cut at `friction` times the normal part (Walton
    1993). A tangential restitution of 0 is not written, so that scenes that have none are the same
    text as ever.
    """

    pauses: ClassVar[bool] = True
    switches: ClassVar[bool] = True
    is_kinked: ClassVar[bool] = True
    meaning: ClassVar[str] = "bodies meet; comes with the law, below"

    law: Literal["linear", "hertz", "rigid"]
    stiffness: Stiffness = 0.0
    damping: Damping = 0.0
    tangential_stiffness: Stiffness = 0.0
    friction: Number = 0.0
    restitution: Number = 0.0
    tangential_restitution: Annotated[float | UnsetType, Dimension(0, 0, 0)] = UNSET
    branch: Literal["R", "R-d", "R-d/2", "slip-R"] = "R-d/2"
    cutoff: Literal["zero_overlap", "zero_force"] = "zero_overlap"

    def __post_init__(self) -> None:
        """Forgets a tangential restitution of 0: what is not set is not written."""
        if self.tangential_restitution == 0:
            force_setattr(self, "tangential_restitution", UNSET)

    @property
    def slip_restitution(self) -> float:
        """The part of the slip that an impact reverses: the tangential restitution, 0 if not
        set.
        """
        if isinstance(self.tangential_restitution, UnsetType):
            return 0.0
        return self.tangential_restitution

    @property
    def slip_shortening(self) -> float:
        """The share c of the overlap d in the lever R - c d at which slip is measured."""
        return SHORTENINGS[self.branch][0]

    @property
    def torque_shortening(self) -> float:
        """The share c of the overlap d in the lever R - c d of the tangential force's torque."""
        return SHORTENINGS[self.branch][1]

    @property
    def has_two_levers(self) -> bool:
        """True if friction has a torque with another lever than that at which slip is measured."""
        is_same = self.slip_shortening == self.torque_shortening
        return self.friction > 0 and self.law != "rigid" and not is_same

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        """True without damping and friction, and for the rigid law with restitution 1."""
        return (
            self.damping == 0
            and self.friction == 0
            and (self.law != "rigid" or self.restitution == 1)
        )

    @property
    def exponent(self) -> float:
        """The normal force is stiffness * overlap**exponent."""
        if self.law == "hertz":
            return 1.5
        return 1.0

    def dimension(self, field: str) -> Dimension | None:
        """The dimension of a field; those of Hertz's stiffnesses [N/m^(3/2)] follow from the
        exponent.
        """
        stiff = field in ("stiffness", "tangential_stiffness")
        if stiff:
            return Dimension(1, 1 - self.exponent, -2)
        return super().dimension(field)

    def features(self) -> frozenset[str]:
        """The law, friction where there is some, mindlin where its spring stiffens with the load,
        and two-levers where slip and torque have levers of their own.
        """
        names = {"contact", f"contact:{self.law}"}
        if self.friction > 0:
            names |= {"friction", "contact:friction"}
        if self.damping > 0:
            names.add("contact:damping")
        if self.law == "hertz" and self.friction > 0 and self.tangential_stiffness > 0:
            names.add("contact:mindlin")
        if self.has_two_levers:
            names.add("contact:two-levers")
        if self.slip_restitution > 0:
            names.add("contact:tangential-restitution")
        return frozenset(names)

    def singularity(self) -> Singularity:
        """The strongest singularity of the law.

        A dashpot's force jumps at the touch, sliding friction without a tangential spring where the
        slip velocity changes sign. A tangential spring has a kink where it starts to slip.
        Otherwise the normal force begins as overlap^n, n the exponent of the law.
        """
        if self.law == "rigid":
            return Singularity(JUMP, "contact:rigid")
        if self.damping > 0:
            return Singularity(JUMP, "contact:damping")
        if self.friction > 0 and self.tangential_stiffness == 0:
            return Singularity(JUMP, "contact:friction")
        if self.friction > 0:
            return Singularity(KINK, "contact:friction")
        return Singularity(self.exponent, "contact")

    def torque_reason(self) -> str | None:
        """None if the torques of friction on a pair balance that of the forces: the levers R - c d
        add up to the distance of the centres for c = 1/2 alone.
        """
        if self.friction > 0 and self.torque_shortening != 0.5:
            return (
                f"the branch vectors {self.branch} do not sum to the centre distance,"
                " so the contact law itself changes it"
            )
        return None

    def faults(self) -> list[str]:
        """Negative coefficients, and a linear law without stiffness."""
        numbers = ("stiffness", "damping", "tangential_stiffness", "friction", "restitution")
        faults = [
            f"{name} is {value}, expected >= 0"
            for name in numbers
            if (value := getattr(self, name)) < 0
        ]
        if self.law != "rigid" and not self.stiffness > 0:
            faults.append(f"stiffness is {self.stiffness}, expected > 0 for the {self.law} law")
        if self.law == "hertz" and self.damping:
            faults.append(f"damping is {self.damping}, expected 0 for the hertz law")
        if self.restitution > 1:
            faults.append(f"restitution is {self.restitution}, expected <= 1")
        return faults + self._tangential_faults()

    def _tangential_faults(self) -> list[str]:
        """A tangential restitution out of 0 to 1, or of a law that has none."""
        reversed_part = self.slip_restitution
        if not 0 <= reversed_part <= 1:
            return [f"tangential_restitution is {reversed_part}, expected 0 to 1"]
        if reversed_part and self.law != "rigid":
            return [
                f"tangential_restitution is {reversed_part}, expected 0 for the {self.law} law:"
                " only impacts of the rigid law have one"
            ]
        return []

    def potential(self, scene: Any, position: Array, attitude: Array) -> Array:
        """Potential energy (T,) [J] of all normal contacts: the sum of k d^(n+1)/(n+1) over
        overlaps d > 0, with the stiffness k and n = 1 or 3/2.

        Contacts are those of spheres with each other and with planes, and of a polyhedron's corners
        with planes. A rigid law has no overlap; the tangential spring is not counted.
        """
        energy = np.zeros(len(position))
        if self.law == "rigid":
            return energy
        power = self.exponent + 1
        radius = scene.bodies.radius
        # Of many spheres only near pairs are found, which differ from sample to sample.
        are_few = np.count_nonzero(radius) <= FEW
        if are_few:
            sample_groups = [slice(None)]
        else:
            sample_groups = [slice(k, k + 1) for k in range(len(position))]
        for samples in sample_groups:
            # V = sum k d^(n+1)/(n+1).
            overlap = np.maximum(_overlaps(scene, position[samples], radius), 0.0)
            energy[samples] = self.stiffness / power * np.sum(overlap**power, axis=1)
        for plane in scene.all(Plane):
            # d = R - (r - point).n.
            height = (position - np.array(plane.point)) @ np.array(plane.normal)
            overlap = np.maximum(radius - height, 0.0)
            # Points have no radius, and do not touch the plane.
            energy += self.stiffness / power * np.sum(overlap**power * (radius > 0), axis=1)
            depth = np.maximum(_depths(scene, plane, position, attitude), 0.0)
            energy += self.stiffness / power * np.sum(depth**power, axis=1)
        return energy


def _depths(scene: Any, plane: Plane, position: Array, attitude: Array) -> Array:
    """Depths (T, C) [m] of the corners of all polyhedra behind a plane: -(r + R c - point) . n."""
    # The number of the body (C,) and the place in body axes (C, 3) of every corner.
    body: list[int] = []
    corners: list[Any] = []
    for number, shape in enumerate(scene.bodies.shape):
        vertices = getattr(shape, "vertices", ())
        corners += vertices
        body += [number] * len(vertices)
    corner = np.array(corners).reshape(-1, 3)
    arm = rotated(attitude[:, body], np.broadcast_to(corner, (len(position), *corner.shape)))
    from_plane = position[:, body] + arm - np.array(plane.point)
    depth: Array = -from_plane @ np.array(plane.normal)
    return depth


def _overlaps(scene: Any, position: Array, radius: Array) -> Array:
    """Overlaps R_i + R_j - |r_j - r_i| (T, P) [m] of pairs of spheres, negative while apart.

    With at most FEW spheres these are all pairs, else those that are near in the first sample. In a
    periodic box a pair meets by its nearest images.
    """
    spheres = np.flatnonzero(radius > 0)
    boxes = scene.all(PeriodicBox)
    if len(spheres) <= FEW:
        i, j = np.triu_indices(len(spheres), 1)
    else:
        if boxes:
            period = boxes[0].size
        else:
            period = 0.0
        i, j = near_pairs(position[0, spheres], 2 * float(radius.max()), period)
    i = spheres[i]
    j = spheres[j]
    branch = position[:, j] - position[:, i]
    if boxes:
        branch = boxes[0].nearest(branch)
    overlap: Array = radius[i] + radius[j] - np.linalg.norm(branch, axis=-1)
    return overlap
