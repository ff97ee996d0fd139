"""Rotations in the plane and in space, by matrices and Euler angles (chapter 1, sections 1.3.1 to
1.3.7).
"""

import numpy as np

from refdem.cases import _rotation_rows
from refdem.cases._algebra import AlgebraCase, Row
from refdem.core.parameters import Parameter, Parameters
from refdem.core.truth import Truth
from refdem.errors import UsageError


class Rotations(AlgebraCase):
    """Matrices turn vectors in space: R maps body to space, the transpose of the chapter's printed
    A.
    """

    angles = frozenset(
        {"euler-back", "globe-angle", "loop-angle", "nine-entries-lag", "four-entries-lag"}
    )
    id = "rotations"
    title = "Rotations"
    words = ("attitude", "euler", "matrix", "angles", "drone", "camera")
    motion = "formula"
    statement = (
        "A turn in the plane is a multiplication by exp(i phi); a mirror has determinant -1 and"
        " changes the sense of angles. In space the order matters: a book turned about z and x ends"
        " differently than one turned about x and z, though some products of turns are turns about"
        " a third axis. Translations commute; of two turns by a small angle h about x and y what is"
        " left is h^2 about z. A step of the matrix in its nine entries breaks six conditions, and"
        " back at the nearest rotation it lags four times as far as the quaternion, which breaks"
        " one. The cosine of a multiple of an angle comes from its powers and by recurrence, and"
        " the product of two cosines from those of their sum and difference. Euler"
        " angles come back from their matrix, but their rates diverge where sin"
        " theta = 0, as the inverse of the matrix that takes them to omega does. A point at r of a"
        " body moves with omega x r, whose square is omega^2 r^2 - (omega . r)^2. The energy of"
        " points is that of their mass in their centre and that about the centre, and so is their"
        " angular momentum (Koenig); of a turn it is omega . J omega/2. About a principal axis the"
        " energy is L^2/(2 J), and principal moments are the eigenvalues of the turned tensor. The"
        " height of a triangle is the part of a side across the base. The frequency in place of"
        " omega = 2 pi f makes the energy 39.48 times too small."
    )
    latex = (
        r"R=R_z(\phi)R_x(\theta)R_z(\psi),"
        r"\qquad\dot\phi=\omega_z-(\omega_x\sin\phi-\omega_y\cos\phi)\cot\theta"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.9) to (1.43), figs. 1.4, 1.6 and 1.7; Greenwood 1988"
        " for the rates"
    )
    parameters = (
        Parameter(
            name="angle",
            default="7/10",
            unit="rad",
            doc="of the turn, and of the mirror to x",
            at_least=-3,
            at_most=3,
        ),
        Parameter(name="vector", default="3/5,-4/5", unit="1", doc="in the plane", shape=(2,)),
        Parameter(
            name="euler", default="1/2,3/4,-5/4", unit="rad", doc="phi, theta, psi", shape=(3,)
        ),
        Parameter(name="omega", default="1,-2,1/2", unit="rad/s", doc="in space axes", shape=(3,)),
        Parameter(
            name="near",
            default="1e-3",
            unit="rad",
            doc="theta at which the rates of Euler angles are large",
            above=0,
            at_most=1,
        ),
        Parameter(
            name="frequency",
            default="5/4",
            unit="Hz",
            doc="turns per second, for the energy",
            above=0,
        ),
        Parameter(
            name="shifts",
            default="3/4,-1,2,5/3,1/2,-7/4",
            unit="1",
            doc="two translations of the point e_x",
            shape=(6,),
        ),
        Parameter(
            name="masses", default="1,2,1/2", unit="1", doc="of three points", shape=(3,), above=0
        ),
        Parameter(
            name="places",
            default="1,0,-1/2,-2,3/2,1/4,3,1,2",
            unit="1",
            doc="of the points",
            shape=(3, 3),
        ),
        Parameter(
            name="velocities",
            default="2,-1,1/2,-1,3,1,1/4,1,-2",
            unit="1",
            doc="of the points",
            shape=(3, 3),
        ),
        Parameter(
            name="small",
            default="1/10",
            unit="rad",
            doc="angle of the two turns that do not commute",
            above=0,
            at_most=1,
        ),
        Parameter(
            name="step",
            default="1/10",
            unit="s",
            doc="of Euler's method with omega, for nine entries and for four",
            above=0,
            at_most=1,
        ),
        Parameter(
            name="multiple",
            default="5",
            unit="1",
            doc="of the angle, for its cosine",
            at_least=0,
            at_most=32,
            whole=True,
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for Euler angles that cannot be recovered from their matrix, for omega
        = 0, and for a triangle without a base.
        """
        if not np.any(p.omega):
            raise UsageError("parameter omega: got 0,0,0; expected a vector other than zero")
        if not np.any(p.shifts[3:]):
            raise UsageError(
                "parameter shifts: got a second shift of 0,0,0; expected a vector other than zero,"
                " the base of a triangle"
            )
        if not (abs(p.euler[0]) < 3.14 and 0.01 < p.euler[1] < 3.13 and abs(p.euler[2]) < 3.14):
            given = ", ".join(f"{x:g}" for x in p.euler)
            raise UsageError(
                f"parameter euler: got {given}; expected phi and psi between -3.14 and 3.14, theta"
                " between 0.01 and 3.13"
            )

    def rows(self, p: Parameters) -> list[Row]:
        """Plane, products of turns, Euler angles, energies, points, commutators, nine entries and
        four.
        """
        return _rotation_rows.rows(p)

    def sizes(self, p: Parameters) -> dict[str, float]:
        """The magnitudes of vectors, rates and energies."""
        return _rotation_rows.sizes(p)

    def truth(self, p: Parameters) -> Truth:
        """The closed form: whole numbers for quarter turns, else sines and cosines."""
        from refdem.truth.closed_forms.rotations import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = Rotations()
