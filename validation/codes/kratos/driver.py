"""Scenes in Kratos DEM: driver.py answers requests until standard input ends, and driver.py
request.json trajectory.csv one.

Attitudes are those at the start.
"""

import itertools
import json
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import border
import served
from border import cannot

EMPTY = "Begin ModelPartData\nEnd ModelPartData\n\nBegin Properties 0\nEnd Properties\n\n"
STIFFNESS = 1.432 * 0.31225 * math.pi
"""Of the law, over E R of the pair; measured (reports/findings.md)."""
ZERO = {"FRICTION_DECAY": 0.0, "ROLLING_FRICTION": 0.0, "ROLLING_FRICTION_WITH_WALLS": 0.0}
LAW = {
    **ZERO,
    "COEFFICIENT_OF_RESTITUTION": 1.0,
    "DEM_DISCONTINUUM_CONSTITUTIVE_LAW_NAME": "DEM_D_Linear_viscous_Coulomb",
}


def poisson(law):
    """Poisson's ratio, from which Kratos has the tangential stiffness: k_t/k = 2 (1 - nu)/(2 -
    nu).
    """
    if law and law["friction"] > 0:
        ratio = law["tangential_stiffness"] / law["stiffness"]
    else:
        ratio = 1.0
    return (2 - 2 * ratio) / (2 - ratio)


def materials(bodies, law):
    """The materials file: a material for each sphere, its density its own; all have the Young's
    modulus that the only pair needs.
    """
    radii = [body["shape"]["radius"] for body in bodies]
    numbers = range(1, len(bodies) + 1)
    nu = poisson(law)
    if law:
        friction = law["friction"]
    else:
        friction = 0.0
    if law:
        young = 2 * (1 - nu**2) * law["stiffness"] * sum(1 / radius for radius in radii) / STIFFNESS
    else:
        young = 1.0
    density = [
        body["mass"] / (4 / 3 * math.pi * radius**3)
        for body, radius in zip(bodies, radii, strict=True)
    ]
    same = {"YOUNG_MODULUS": young, "POISSON_RATIO": nu}
    rubs = LAW | {"STATIC_FRICTION": friction, "DYNAMIC_FRICTION": friction}
    each = [
        {
            "material_name": f"m{n}",
            "material_id": n,
            "Variables": same | {"PARTICLE_DENSITY": density[n - 1]},
        }
        for n in numbers
    ]
    pairs = itertools.combinations_with_replacement(numbers, 2)
    relations = [
        {"material_names_list": [f"m{a}", f"m{b}"], "material_ids_list": [a, b], "Variables": rubs}
        for a, b in pairs
    ]
    table = [[f"SpheresPart.s{n}", f"m{n}"] for n in numbers]
    return json.dumps(
        {"materials": each, "material_relations": relations, "material_assignation_table": table}
    )


def block(name, lines):
    """A block of a model file."""
    return f"Begin {name}\n{lines}End {name.partition(' ')[0]}\n"


def write(bodies, law):
    """Writes the files that the analysis reads."""
    Path("materials.json").write_text(materials(bodies, law))
    nodes = "".join(
        f"{n} {' '.join(map(repr, body['position']))}\n" for n, body in enumerate(bodies, 1)
    )
    spheres = "".join(f"{n} 0 {n}\n" for n in range(1, len(bodies) + 1))
    radii = "".join(f"{n} 0 {body['shape']['radius']!r}\n" for n, body in enumerate(bodies, 1))
    parts = [("Nodes", nodes), ("Elements SphericParticle3D", spheres), ("NodalData RADIUS", radii)]
    for n in range(1, len(bodies) + 1):
        parts.append(
            (
                f"SubModelPart s{n}",
                block("SubModelPartNodes", f"{n}\n") + block("SubModelPartElements", f"{n}\n"),
            )
        )
    Path("rDEM.mdpa").write_text(EMPTY + "\n".join(itertools.starmap(block, parts)))
    for name in ("DEM_FEM_boundary", "DEM_Inlet", "DEM_Clusters"):
        Path(f"r{name}.mdpa").write_text(EMPTY)


def settings(request, step, steps):
    """Kratos' settings; what is not here is off."""
    g = [
        sum(field["g"][k] for field in border.of_kind(request, "uniform_gravity")) for k in range(3)
    ]
    switches = dict.fromkeys(
        ("do_print_results_option", "dem_inlet_option", "post_gid_option"), False
    )
    schemes = {
        "TranslationalIntegrationScheme": "Velocity_Verlet",
        "RotationalIntegrationScheme": "Direct_Integration",
    }
    times = {"MaxTimeStep": step, "FinalTime": (steps + 0.5) * step, "NeighbourSearchFrequency": 1}
    solver = {
        "strategy": "sphere_strategy",
        "material_import_settings": {"materials_filename": "materials.json"},
    }
    solver["RemoveBallsInitiallyTouchingWalls"] = False
    return {
        "problem_name": "r",
        "solver_settings": solver,
        **dict(zip(("GravityX", "GravityY", "GravityZ"), g, strict=True)),
        "ElementType": "SphericPartDEMElement3D",
        **switches,
        **schemes,
        **times,
    }


def solve(scene):
    """Runs a scene and keeps its rows."""
    request, bodies, times = scene.request, scene.bodies, scene.times
    cannot(times[1] < times[0], "negative steps")
    law = border.contact_law(request)
    border.refuse_shapes(request)
    cannot(any(body["shape"]["kind"] != "sphere" for body in bodies), "points")
    cannot(law and law["damping"] > 0, "damping as a number of the law: it comes from restitution")
    rubs = law and law["friction"] > 0
    few = "a tangential stiffness outside 2/3 to 1 of the normal one: it comes from Poisson's ratio"
    cannot(rubs and not 2 / 3 < law["tangential_stiffness"] / law["stiffness"] <= 1, few)
    cannot(rubs and law["branch"] != "R-d/2", "a branch other than R - d/2")
    cannot(law and len(bodies) > 2, "one stiffness for pairs of several radii")
    write(bodies, law)
    from analysis import Recorded  # here: what is refused needs no Kratos

    steps = scene.stride * (len(times) - 1)
    run = Recorded(json.dumps(settings(request, scene.step, steps)), bodies, times, scene.stride)
    run.Run()
    scene.rows.extend(run.rows)


if __name__ == "__main__":
    served.run(solve, "contact", "uniform_gravity")
