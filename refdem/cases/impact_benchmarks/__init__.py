"""Impact tests that users of DEM codes know: Chung and Ooi's eight, MFiX' five, slide to roll; a
file a member.
"""

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.cases.impact_benchmarks._member import Member
from refdem.cases.impact_benchmarks._parameters import OF_MEMBERS
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene

Array = NDArray[np.float64]
MEMBERS = tuple(
    sorted(path.stem.replace("_", "-") for path in Path(__file__).parent.glob("[a-z]*.py"))
)


@cache
def member(name: str) -> Member:
    """The member of the family with that name: the MEMBER of its file."""
    module = import_module(f"{__name__}.{name.replace('-', '_')}")
    named: Member = module.MEMBER
    return named


class ImpactBenchmarks(Case):
    """Every member against truth for the law that it declares: branch vector, tangential spring,
    damping, end of contact.
    """

    id = "impact-benchmarks"
    title = "Impact benchmarks"
    words = ("chung", "ooi", "dem", "collision", "wall", "mfix")
    motion = "colliding"
    statement = (
        "The collisions by which DEM codes are known: spheres that hit each other or a wall"
        " head-on, obliquely or spinning, that bounce, lie squeezed, or slide until they roll. What"
        " an impact does follows from the law that is declared, to the last digit."
    )
    latex = (
        r"e_t=1-\frac{\mu(1+e)}{\tan\theta},\quad\omega=\frac{5\mu(1+e)v_n}{2R},\quad\frac{u}{u_0}=\frac57,\quad\frac{\mu"
        r" g t}{u_0}=\frac27"
    )
    source = (
        "Chung and Ooi, Granular Matter 13 (2011) 643; Garg et al., Powder Technology 220 (2012)"
        " 122 (MFiX); Hertz 1882"
    )
    parameters = (
        Parameter(name="member", default="co-4", unit="1", doc="which test", choices=MEMBERS),
        *OF_MEMBERS,
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a parameter that is another member's, or values that do not go
        together.
        """
        member(p.member).refuse(p)

    def scene(self, p: Parameters) -> Scene:
        """The scene of the selected member."""
        return member(p.member).scene(member(p.member).values(p))

    def scales(self, p: Parameters) -> Scales:
        """The scales of the selected member."""
        return member(p.member).scales(member(p.member).values(p))

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities of the selected member."""
        return member(p.member).quantities(member(p.member).values(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The quantities (T,) by name, as the selected member computes them."""
        return member(p.member).observe(member(p.member).values(p), trajectory)

    def meant(self, p: Parameters) -> dict[str, Any]:
        """The member's own exact numbers; a witness derives from them, by itself, all others."""
        return {"member": p["member"], **member(p.member).written(p)}

    def written_out(self, p: Parameters) -> Parameters:
        """The parameters with the member's own numbers."""
        return member(p.member).written_out(p)

    def truth(self, p: Parameters) -> Truth:
        """The member's: closed form, or proven from switch to switch."""
        scale = {q.name: q.scale for q in self.quantities(p)}
        return member(p.member).truth(member(p.member).values(p), scale)


CASE = ImpactBenchmarks()
