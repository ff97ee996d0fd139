"""The parameters that members of the family may have; each member selects those that it uses, and
has its own values.
"""

from fractions import Fraction

from refdem.core.parameters import Parameter

MATERIALS = {
    "glass": ("4.8e10", "0.2", "2800"),
    "limestone": ("2e10", "0.25", "2500"),
    "aluminium-alloy": ("7e10", "0.3", "2699"),
    "magnesium-alloy": ("4e10", "0.35", "1800"),
    "aluminium-oxide": ("3.8e11", "0.23", "4000"),
    "steel": ("2.08e11", "0.3", "7850"),
}
"""Young's modulus [Pa], Poisson's ratio and density [kg/m^3] (Chung and Ooi 2011, tables 1 to 8).
"""

LEVERS = {"R": Fraction(0), "R-d/2": Fraction(1, 2), "R-d": Fraction(1)}
"""The lever arm of friction is R - c d, with the overlap d: this is c for each `branch`."""


def optional(
    name: str,
    unit: str,
    doc: str,
    *,
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
) -> Parameter:
    """The declaration of a number that members have; without it, the member's own value counts."""
    return Parameter(
        name=name, default="", unit=unit, doc=doc, above=above, at_least=at_least, at_most=at_most
    )


OF_MEMBERS = (
    Parameter(
        name="material",
        default="own",
        unit="1",
        doc="modulus, Poisson's ratio, density",
        choices=("own", *MATERIALS),
    ),
    Parameter(
        name="branch",
        default="own",
        unit="1",
        doc="lever arm of friction",
        choices=("own", "R", "R-d", "R-d/2"),
    ),
    Parameter(
        name="cutoff",
        default="own",
        unit="1",
        doc="when the force ends",
        choices=("own", "zero_overlap", "zero_force"),
    ),
    optional("radius", "m", "of the sphere", above=0),
    optional("density", "kg/m^3", "of the sphere; without a material", above=0),
    optional("speed", "m/s", "at touch, closing speed of two; that of sliding", above=0),
    optional("angle", "rad", "of the velocity from the normal", at_least=-1.56, at_most=1.56),
    optional("normal_speed", "m/s", "normal part of the velocity at touch", above=0),
    optional("psi", "1", "tangential over normal speed and friction", at_least=-1e6, at_most=1e6),
    optional("spin", "rad/s", "about z", at_least=-1e12, at_most=1e12),
    optional("partner_radius", "m", "of the second sphere", above=0),
    optional("partner_density", "kg/m^3", "of the second sphere", above=0),
    optional(
        "partner_spin", "rad/s", "of the second sphere, about z", at_least=-1e12, at_most=1e12
    ),
    optional("restitution", "1", "makes the dashpot", above=0, at_most=1),
    optional("stiffness", "N/m", "normal spring", above=0),
    optional("tangential_stiffness", "N/m", "0: sliding friction of full size", at_least=0),
    optional("friction", "1", "Coulomb's coefficient", at_least=0),
    optional("gravity", "m/s^2", "downwards", above=0),
    optional("height", "m", "of the centre above the floor at the start", above=0),
    optional("overlap", "m", "the greatest, of a prescribed path", above=0),
)
