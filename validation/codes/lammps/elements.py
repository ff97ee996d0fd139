"""The elements of a scene in LAMMPS' words: pair style, walls, and fixes that push."""

from itertools import combinations

import border
from border import cannot

LAWS = {
    "gran": (
        "gran/hooke/history {stiffness!r} {tangential_stiffness!r} {per_mass!r} 0 {friction!r} 0"
    ),
    "granular": (
        "granular hooke {stiffness!r} {damping!r} tangential linear_history"
        " {tangential_stiffness!r} 0 {friction!r} damping velocity"
    ),
}
"""No tangential damping; that along the normal is per effective mass in `gran`."""
BRANCHES = {"gran": "R", "granular": "slip-R"}
"""The levers of friction in pairs: `gran` has R for slip and for torque, `granular` has R for slip
and R - d/2 for torque. At walls both have R for both.
"""

LEAST = 1e-300
"""The damping per mass [1/s] of walls without damping in `gran`."""


def joined(numbers):
    """Numbers with a blank between them, every digit of them."""
    return " ".join(map(repr, numbers))


def law(c, method, masses, planes):
    """Name and numbers of a linear law."""
    effective = {a * b / (a + b) for a, b in combinations(masses, 2)} | (
        set(masses) if planes else set()
    )
    cannot(
        c["friction"] > 0 and c["tangential_stiffness"] == 0,
        "friction of full size at any slip: it goes through a tangential spring",
    )
    cannot(
        c["friction"] > 0 and method == "granular" and planes and len(masses) > 1,
        "friction in granular at walls and in pairs: its torque has the lever R at walls only",
    )
    branch = "R" if planes else BRANCHES[method]
    cannot(
        c["friction"] > 0 and c["branch"] != branch,
        f"friction in {method} with another branch than {branch}",
    )
    pulls = c["damping"] > 0 and c["cutoff"] == "zero_overlap"
    cannot(
        c["friction"] > 0 and pulls,
        "no friction while the normal force pulls: the limit is friction times its size",
    )
    cannot(
        method == "gran" and c["damping"] > 0 and len(effective) > 1,
        "one damping for unequal pairs: it is per effective mass",
    )
    # Of 0 at a wall comes NaN (reports/findings.md); LEAST changes no digit.
    per_mass = c["damping"] / max(effective, default=1.0) or LEAST * bool(planes)
    words = LAWS[method].format(**c, per_mass=per_mass)
    return words + " limit_damping" * (c["cutoff"] == "zero_force")


def wall(n, plane, words):
    """The commands of one wall: along an axis that of fix wall/gran, else a plane as a region."""
    across = [k for k in range(3) if abs(plane["normal"][k]) == 1]
    if across:
        (k,) = across
        place = repr(plane["point"][k])
        # The first place is that of a wall below the spheres, the second of one above.
        sides = f"{place} NULL" if plane["normal"][k] > 0 else f"NULL {place}"
        yield f"fix wall{n} all wall/gran {words} {'xyz'[k]}plane {sides}"
        return
    yield f"region half{n} plane {joined((*plane['point'], *plane['normal']))}"
    yield f"fix wall{n} all wall/gran/region {words} region half{n}"


def contact(request, method):
    """The commands for the pair style and the walls."""
    planes = border.of_kind(request, "plane")
    found = border.contact_law(request)
    if found is None:
        cannot(planes, "planes without a contact law")
        cannot(method == "granular", "nothing can touch: this is the same as gran")
        yield "pair_style zero 1.0\npair_coeff * *"
        return
    words = law(found, method, [body["mass"] for body in request["scene"]["bodies"]], planes)
    style, _, numbers = words.partition(" ")
    yield (
        f"pair_style {style}\npair_coeff * * {numbers}"
        if method == "granular"
        else f"pair_style {words}\npair_coeff * *"
    )
    for n, plane in enumerate(planes):
        yield from wall(n, plane, words.removeprefix("gran/"))


def pushes(request):
    """Gravity, springs to the world, and a central field, body by body."""
    for n, field in enumerate(border.of_kind(request, "uniform_gravity")):
        yield (
            f"fix gravity{n} all gravity {sum(g * g for g in field['g']) ** 0.5!r} vector"
            f" {joined(field['g'])}"
        )
    for n, spring in enumerate(border.of_kind(request, "spring")):
        cannot(
            spring["b"] != -1 or spring["exponent"] != 1 or any(spring["anchor_a"]),
            "springs but linear ones from a centre to the world",
        )
        tether = f"{spring['stiffness']!r} {joined(spring['anchor_b'])} {spring['length']!r}"
        yield f"group held{n} id {spring['a'] + 1}\nfix spring{n} held{n} spring tether {tether}"
    for n, field in enumerate(border.of_kind(request, "central_field")):
        yield from (
            f"variable pull{n}{a} atom -{field['gm']!r}*mass*{a}/(x*x+y*y+z*z)^1.5" for a in "xyz"
        )
        yield f"fix central{n} all addforce v_pull{n}x v_pull{n}y v_pull{n}z"
