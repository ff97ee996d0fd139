"""The elements of a scene in LAMMPS' words: pair style, walls, and fixes that push."""

from itertools import combinations

import border
from border import cannot

LAWS = {
    ("gran", "linear"): (
        "gran/hooke/history {stiffness!r} {tangential_stiffness!r} {per_mass!r} 0 {friction!r} 0"
    ),
    ("gran", "hertz"): (
        "gran/hertz/history {stiffness!r} {tangential_stiffness!r} {per_mass!r} 0 {friction!r} 0"
    ),
    ("granular", "linear"): (
        "granular hooke {stiffness!r} {damping!r} tangential linear_history"
        " {tangential_stiffness!r} 0 {friction!r} damping velocity"
    ),
    ("granular", "hertz"): (
        "granular hertz {stiffness!r} {damping!r} tangential mindlin"
        " {tangential_stiffness!r} 0 {friction!r} damping velocity"
    ),
}
"""By method and law. No tangential damping; that along the normal is per effective mass in `gran`.

Under Hertz's law both methods have F_n = k_n sqrt(R d) d and F_t = k_t sqrt(R d) s, with the
effective radius R, the overlap d and the slip s: k_n and k_t are the stiffnesses divided by
sqrt(R).
"""
BRANCHES = {"gran": "R", "granular": "slip-R"}
"""The levers of friction in pairs: `gran` has R for slip and for torque, `granular` has R for slip
and R - d/2 for torque. At walls both have R for both.
"""

LEAST = 1e-300
"""The damping per mass [1/s] of walls without damping in `gran`."""


def joined(numbers):
    """Numbers with a blank between them, every digit of them."""
    return " ".join(map(repr, numbers))


def combined(values, planes):
    """The effective values a b/(a + b) of all pairs, and the values themselves at planes."""
    pairs = {a * b / (a + b) for a, b in combinations(values, 2)}
    return pairs | set(values) if planes else pairs


def refuse_friction(c, method, count, planes):
    """Ends with status 77 for friction that the methods do not have."""
    cannot(
        c["tangential_stiffness"] == 0,
        "friction of full size at any slip: it goes through a tangential spring",
    )
    cannot(
        method == "granular" and planes and count > 1,
        "friction in granular at walls and in pairs: its torque has the lever R at walls only",
    )
    branch = "R" if planes else BRANCHES[method]
    cannot(c["branch"] != branch, f"friction in {method} with another branch than {branch}")
    cannot(
        c["damping"] > 0 and c["cutoff"] == "zero_overlap",
        "no friction while the normal force pulls: the limit is friction times its size",
    )


def law(c, method, bodies, planes):
    """Name and numbers of a law."""
    masses = combined([body["mass"] for body in bodies], planes)
    if c["friction"] > 0:
        refuse_friction(c, method, len(bodies), planes)
    cannot(
        method == "gran" and c["damping"] > 0 and len(masses) > 1,
        "one damping for unequal pairs: it is per effective mass",
    )
    # Of 0 at a wall comes NaN (reports/findings.md); LEAST changes no digit.
    per_mass = c["damping"] / max(masses, default=1.0) or LEAST * bool(planes)
    if c["law"] == "hertz":
        radii = combined([body["shape"].get("radius", 0.0) for body in bodies], planes)
        cannot(len(radii) > 1, "one stiffness for pairs of unequal effective radius")
        root = max(radii) ** 0.5
        c = c | {name: c[name] / root for name in ("stiffness", "tangential_stiffness")}
    words = LAWS[method, c["law"]].format(**c, per_mass=per_mass)
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
    found = border.contact_law(request, "linear", "hertz")
    if found is None:
        cannot(planes, "planes without a contact law")
        cannot(method == "granular", "nothing can touch: this is the same as gran")
        yield "pair_style zero 1.0\npair_coeff * *"
        return
    words = law(found, method, request["scene"]["bodies"], planes)
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
