"""The elements of a scene, one a file; a new file in this folder is found without being named."""

from functools import reduce
from importlib import import_module
from operator import or_
from pathlib import Path
from typing import Any

from refdem.scene.element import Element

__all__ = ["KINDS", "AnyElement"]


def _kinds() -> dict[str, type[Element]]:
    """Every element class of the folder's modules by its tag in JSON."""
    kinds: dict[str, type[Element]] = {}
    for path in sorted(Path(__file__).parent.glob("*.py")):
        if path.stem.startswith("_"):
            continue
        module = import_module(f"refdem.scene.elements.{path.stem}")
        for value in vars(module).values():
            is_element = isinstance(value, type) and issubclass(value, Element)
            if is_element and value.__module__ == module.__name__:
                kinds[str(value.__struct_config__.tag)] = value
    return kinds


KINDS = _kinds()
AnyElement: Any = reduce(or_, KINDS.values())
