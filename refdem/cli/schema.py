"""refdem schema: the JSON Schemas of what refdem reads and writes."""

from typing import Annotated, Any

import typer

from refdem.errors import UsageError


def command(what: Annotated[str, typer.Argument(help="request, trajectory, records, scene or toml")]) -> None:
    """Prints a JSON Schema.

    Example: refdem schema request
    """
    import json

    import msgspec

    from refdem.core.finding import Sheet
    from refdem.core.problem import RequestDocument
    from refdem.engines.external.description import Description
    from refdem.scene import SceneDocument

    kinds = {"request": RequestDocument, "scene": SceneDocument, "records": Sheet, "toml": Description}
    if what not in kinds and what != "trajectory":
        raise UsageError(f"schema got {what!r}; expected trajectory, {', '.join(kinds)}")
    print(json.dumps(trajectory() if what == "trajectory" else msgspec.json.schema(kinds[what]), indent=1))


def trajectory() -> dict[str, Any]:
    """The schema of trajectory.csv, each row an object of its cells."""
    from refdem.core.trajectory import CHANNELS
    from refdem.core.trajectory_csv import COLUMNS

    units = {"t": "s", "body": "1"} | dict.fromkeys("xyz", "m") | dict.fromkeys(("vx", "vy", "vz"), "m/s")
    units |= dict.fromkeys(("qw", "qx", "qy", "qz"), "1") | dict.fromkeys(("wx", "wy", "wz"), "rad/s")
    empty = {"const": "", "description": "empty"}
    cells: dict[str, Any] = {name: {"type": "number", "description": f"[{units[name]}]"} for name in COLUMNS[:8]}
    cells["body"] = {"type": "integer", "minimum": 0, "description": "the body's number, in order 0 .. N-1 within each sample"}
    points = "; empty in all seven columns for a body that does not turn"
    cells |= {name: {"anyOf": [{"type": "number"}, empty], "description": f"[{units[name]}]{points}"} for name in COLUMNS[8:]}
    shown = "; the k-th element's in body k's row, empty in the others"
    cells |= {name: {"anyOf": [{"type": "number"}, empty], "description": f"[{unit}]{shown}"} for name, unit in CHANNELS.items()}
    row = {"type": "object", "properties": cells, "required": list(COLUMNS), "additionalProperties": False}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "trajectory.csv",
        "description": "One row for each sample and body, 17 digits. (qw, qx, qy, qz) takes body to space axes; omega is in space axes.",
        "type": "array",
        "items": row,
    }
