"""The features that a refdem.toml may name: what its program supports."""

from typing import get_args, get_type_hints

from refdem.core.static_problems import SolidShape
from refdem.scene.elements import KINDS
from refdem.scene.elements.contact import Contact

SOLIDS = {"solid:hollow", "solid:turned", "solid:about"} | {
    f"solid:{shape.__struct_config__.tag}" for shape in get_args(SolidShape)
}
"""Features of mass properties: shapes, and operations on them."""
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
"""Dimensions of the motion; a program that names none of them supports all."""
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
    "contact:two-levers",
    "bodies_file",
    *(f"contact:{law}" for law in get_args(get_type_hints(Contact)["law"])),
}
"""What `supports` and `order_with` may name."""

MEANINGS = {kind: element.meaning for kind, element in KINDS.items()} | {
    "bodies_file": "more than 1e4 bodies: they come in a file of NumPy's, bodies.npz",
    "constraint": "comes with a rod, a ball joint, a catch: coordinates that are not free",
    "contact:damping": "a dashpot along the normal; comes with the law",
    "contact:friction": "friction of contacts; comes with `friction`",
    "contact:hertz": "normal force k overlap^(3/2)",
    "contact:linear": "normal force k overlap + c d(overlap)/dt",
    "contact:mindlin": "tangential spring of Hertz' law, which stiffens with its load",
    "contact:rigid": "impacts without duration, with a coefficient of restitution",
    "contact:tangential-restitution": "rigid impacts that reverse part of the slip",
    "contact:two-levers": "slip at the radius, torque of friction at R - overlap/2",
    "dashpot:van_der_pol": "a dashpot that depends on the distance of its anchors",
    "dimension:1": "motion along one line; a program that names no dimension supports all three",
    "dimension:2": "motion in one plane",
    "dimension:3": "motion in space",
    "fixed": "bodies that do not move",
    "friction": "Coulomb's friction of contacts or sliders",
    "rotation": "bodies that may turn: attitude and omega belong to the state",
    "shape:polyhedron": "a body with faces",
    "shape:sphere": "comes with contacts: bodies with a radius",
    "slider:belt": "a slider on a belt that moves",
    "slider:stribeck": "friction of a slider that falls with the speed",
    "solid:about": "mass properties about a point that is not the centre of mass",
    "solid:cuboid": "mass properties of a cuboid",
    "solid:cylinder": "mass properties of a cylinder",
    "solid:ellipsoid": "mass properties of an ellipsoid",
    "solid:hollow": "mass properties of a shell",
    "solid:points": "mass properties of point masses",
    "solid:polygon": "mass properties of a plane polygon",
    "solid:polyhedron": "mass properties of a polyhedron",
    "solid:sphere": "mass properties of a sphere",
    "solid:turned": "mass properties in axes that are turned",
    "spring:cubic": "a spring with a term of third power",
    "spring:exponent": "a spring with another power of the stretch than 1",
    "spring:quadratic": "a spring with a term of second power",
    "tumbling": "comes with rotation: a body whose axis of spin moves",
}
"""What each of FEATURES means, for people."""
IMPLIED = {
    "contact",
    "contact:damping",
    "contact:friction",
    "constraint",
    "tumbling",
    "shape:sphere",
}
"""Features that are implied by others that a program names: a law, friction, a rod, rotation."""
KEPT = {
    "energy": "the sum of kinetic and potential energy, where nothing dissipates or drives",
    "momentum": "the total momentum, where no force acts from outside",
    "angular-momentum": "the total angular momentum with spins, where no torque acts from outside",
    "constraint": "lengths of rods, and points that joints hold together",
}
"""What each word of `conserves` means: kept to round-off, whatever the step."""
