"""Quaternions: every row of Table 1.2, their representations by matrices, and their motion under an
angular velocity.
"""

import numpy as np

from refdem.cases import _quaternion_rows
from refdem.cases._algebra import AlgebraCase, Row
from refdem.core.parameters import Parameter, Parameters
from refdem.core.truth import Truth
from refdem.errors import UsageError


class Quaternions(AlgebraCase):
    """p and q are any quaternions, u the unit one along q; omega and its rise are in space axes."""

    angles = frozenset({"euler"})
    id = "quaternions"
    title = "Quaternions"
    words = ("attitude", "rotation", "hamilton", "camera", "drone")
    motion = "formula"
    statement = (
        "Products do not commute but associate; a conjugate reverses them; the inverse is the"
        " conjugate over the square. A unit quaternion u turns vectors as u v u*, and -u turns them"
        " alike; u1 and then u2 turn as the product u2 u1. Real matrices 4 x 4 and complex ones 2 x"
        " 2 multiply as quaternions do; Pauli's matrices have the eigenvalues 1 and -1, those of i,"
        " j and k have i and -i. Under omega"
        " the rate is omega u/2, orthogonal to u; it gives omega back in space and in body axes. A"
        " quaternion and its rate do not commute (the chapter's remark after (1.75)): what holds is"
        " u u'* = -u' u*."
    )
    latex = (
        r"pq=(s_ps_q-\mathbf p\cdot\mathbf q,\;s_p\mathbf q+s_q\mathbf p+\mathbf p\times\mathbf"
        r" q),\qquad\dot u=\tfrac12\omega u"
    )
    source = "Matuttis and Chen 2014, chapter 1, (1.44) to (1.91), Table 1.2 and exercise 1.2"
    parameters = (
        Parameter(
            name="p",
            default="1,-2,1/2,3",
            unit="1",
            doc="not 0: a quaternion (w, x, y, z)",
            shape=(4,),
        ),
        Parameter(name="q", default="2,1,-1,1/4", unit="1", doc="another, not 0", shape=(4,)),
        Parameter(
            name="r", default="-1,1/3,2,1", unit="1", doc="a third, for associativity", shape=(4,)
        ),
        Parameter(name="vector", default="1,2,-1/2", unit="1", doc="turned by u", shape=(3,)),
        Parameter(
            name="omega", default="3/4,-1,2", unit="rad/s", doc="angular velocity", shape=(3,)
        ),
        Parameter(
            name="rise", default="1/2,1,-1", unit="rad/s^2", doc="its derivative", shape=(3,)
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for p = 0, and for a q that is 0, whose Euler angles z-x-z are not
        unique, or whose w is close to 0.
        """
        if not np.any(p.p):
            raise UsageError("parameter p: got 0,0,0,0; expected a quaternion other than zero")
        w, x, y, z = p.q
        norm = np.linalg.norm(p.q)
        # sin(theta/2) = |(x, y)|/|q| and cos(theta/2) = |(w, z)|/|q|, by (1.76) to (1.79); phi and
        # psi are not unique where either is 0.
        if not min(np.hypot(x, y), np.hypot(w, z)) > 1e-6 * norm:
            raise UsageError(
                "parameter q: expected x, y and w, z that are not both 0: its Euler angles z-x-z"
                " would not be unique"
            )
        if abs(w) < 1e-6 * norm:
            raise UsageError(
                "parameter q: expected a w other than 0: which of q and -q has w >= 0 would be"
                " chance"
            )

    def rows(self, p: Parameters) -> list[Row]:
        """The operations of the case: algebra, then rotations, then rates."""
        return _quaternion_rows.rows(p)

    def sizes(self, p: Parameters) -> dict[str, float]:
        """The magnitude of every result: that of a product is the product of the magnitudes."""
        return _quaternion_rows.sizes(p)

    def truth(self, p: Parameters) -> Truth:
        """The closed form, by complex 2 x 2 matrices of the quaternions in ball arithmetic."""
        from refdem.truth.closed_forms.quaternions import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = Quaternions()
