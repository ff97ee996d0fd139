"""refdem schema: the JSON Schemas of what refdem reads and writes."""

from typing import Annotated

import typer

from refdem.errors import UsageError


def command(what: Annotated[str, typer.Argument(help="request, scene or records")]) -> None:
    """Prints a JSON Schema.

    Example: refdem schema request
    """
    import json

    import msgspec

    from refdem.core.finding import Sheet
    from refdem.core.problem import RequestDocument
    from refdem.scene import SceneDocument

    kinds = {"request": RequestDocument, "scene": SceneDocument, "records": Sheet}
    if what not in kinds:
        raise UsageError(f"schema got {what!r}; expected {', '.join(kinds)}")
    print(json.dumps(msgspec.json.schema(kinds[what]), indent=1))
