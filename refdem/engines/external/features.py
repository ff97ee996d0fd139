"""The features that a refdem.toml may name: what its program supports."""

from typing import get_args, get_type_hints

from refdem.core.statics import SolidShape
from refdem.scene.elements import KINDS
from refdem.scene.elements.contact import Contact

SOLIDS = {"solid:hollow", "solid:turned", "solid:about"} | {
    f"solid:{shape.__struct_config__.tag}" for shape in get_args(SolidShape)
}
"""Of mass properties: shapes, and what is done with them."""
BODIES = (
    "rotation",
    "tumbling",
    "fixed",
    "friction",
    "constraint",
    "shape:sphere",
    "shape:polyhedron",
)
DIMENSIONS = {"dimension:1", "dimension:2", "dimension:3"}
"""Of motion; a program that names none of them runs in all."""
FEATURES = {
    *BODIES,
    *DIMENSIONS,
    *KINDS,
    *SOLIDS,
    *(
        "slider:stribeck",
        "slider:belt",
        "spring:exponent",
        "spring:quadratic",
        "spring:cubic",
        "dashpot:van_der_pol",
    ),
    "contact:damping",
    "contact:friction",
    "contact:mindlin",
    "contact:tangential-restitution",
    "bodies_file",
    *(f"contact:{law}" for law in get_args(get_type_hints(Contact)["law"])),
}
"""What `supports` and `order_with` may name."""
