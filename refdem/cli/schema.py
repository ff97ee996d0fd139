"""refdem schema: the JSON Schemas of what refdem reads and writes."""

from typing import Annotated, Any

import typer

from refdem.errors import UsageError


def command(
    what: Annotated[
        str,
        typer.Argument(
            help=(
                "Name of the schema: request, trajectory, solids, records, scene, toml,"
                " stress or certified."
            )
        ),
    ],
) -> None:
    """Prints the JSON Schema of a file that refdem reads or writes.

    Example: refdem schema request
    """
    import json

    import msgspec

    from refdem.core.finding import Sheet
    from refdem.core.problem import RequestDocument
    from refdem.core.static_problems import SolidDocument
    from refdem.engines.external.description import Description
    from refdem.scene import SceneDocument
    from refdem.stress.record import StressRecord as Stress

    solid = msgspec.defstruct(
        "SolidRequestDocument",
        [("method", str), ("problem", SolidDocument), ("format", int, 1)],
        kw_only=True,
    )
    kinds = {
        "request": RequestDocument,
        "scene": SceneDocument,
        "records": Sheet,
        "toml": Description,
        "stress": Stress,
    }
    if what == "certified":
        from refdem.planning.kept_truth import truth_folder

        print((truth_folder() / "schema.json").read_text(), end="")
        return
    tables = {"trajectory": trajectory, "solids": solids}
    if what not in kinds and what not in tables:
        raise UsageError(
            f"schema got {what!r}; expected {', '.join(tables)}, certified, {', '.join(kinds)}"
        )
    if what in tables:
        schema = tables[what]()
    elif what == "request":
        # A request is of a motion or of another kind of problem.
        alternatives, definitions = msgspec.json.schema_components([RequestDocument, solid])
        schema = {"anyOf": list(alternatives), "$defs": definitions}
    else:
        schema = msgspec.json.schema(kinds[what])
    print(json.dumps(schema, indent=1))


def trajectory() -> dict[str, Any]:
    """The schema of trajectory.csv, each row an object of its cells."""
    from refdem.core.trajectory import CHANNELS
    from refdem.core.trajectory_csv import COLUMNS

    units = (
        {"t": "s", "body": "1"}
        | dict.fromkeys("xyz", "m")
        | dict.fromkeys(("vx", "vy", "vz"), "m/s")
    )
    units |= dict.fromkeys(("qw", "qx", "qy", "qz"), "1") | dict.fromkeys(
        ("wx", "wy", "wz"), "rad/s"
    )
    empty = {"const": "", "description": "empty"}
    cells: dict[str, Any] = {
        name: {"type": "number", "description": f"[{units[name]}]"} for name in COLUMNS[:8]
    }
    cells["t"]["description"] = (
        "[s] the program's own time of the sample, after `stride` steps from the one before; "
        "steps are counted, and the program never compares times"
    )
    cells["body"] = {
        "type": "integer",
        "minimum": 0,
        "description": "the body's number, in order 0 .. N-1 within each sample",
    }
    points = "; empty in all seven columns for a body that does not turn"
    cells |= {
        name: {"anyOf": [{"type": "number"}, empty], "description": f"[{units[name]}]{points}"}
        for name in COLUMNS[8:]
    }
    shown = "; the k-th element's in body k's row, empty in the others"
    cells |= {
        name: {"anyOf": [{"type": "number"}, empty], "description": f"[{unit}]{shown}"}
        for name, unit in CHANNELS.items()
    }
    row = {
        "type": "object",
        "properties": cells,
        "required": list(COLUMNS),
        "additionalProperties": False,
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "trajectory.csv",
        "description": (
            "One row for each sample and body, 17 digits. (qw, qx, qy, qz) takes body to space"
            " axes; omega is in space axes."
        ),
        "type": "array",
        "items": row,
    }


def solids() -> dict[str, Any]:
    """The schema of the table that answers a request for mass properties, each row an object of its
    cells.
    """
    from refdem.core.answer_csv import SOLID_COLUMNS

    empty = {"const": "", "description": "empty: the program does not compute it"}
    units = {"mass": "kg", **dict.fromkeys("xyz", "m")}
    cells: dict[str, Any] = {
        "solid": {
            "type": "string",
            "description": "its name in the request; the solids in their order there",
        }
    }
    for name in SOLID_COLUMNS[1:]:
        cells[name] = {
            "anyOf": [{"type": "number"}, empty],
            "description": f"[{units.get(name, 'kg m^2')}]",
        }
    row = {
        "type": "object",
        "properties": cells,
        "required": list(SOLID_COLUMNS),
        "additionalProperties": False,
    }
    about = "the centre of mass, or about the point `about` where the request has one"
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "trajectory.csv, of a request for mass properties",
        "description": (
            "A row a solid, 17 digits: mass, centre of mass, tensor of inertia (xy = -integral of"
            f" x y) about {about}."
        ),
        "type": "array",
        "items": row,
    }
