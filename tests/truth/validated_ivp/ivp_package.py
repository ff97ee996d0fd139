"""The integrator, as it is or with one line of its source changed."""

import sys
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, SimpleNamespace

MODULES = ("field", "recurrences", "enclosure", "moved", "integration")


def package(module=None, old="", new=""):
    """Its modules, made anew from their sources; in one of them `old`, which must be there just
    once, reads `new`.
    """
    names = {part: f"refdem.truth.validated_ivp.{part}" for part in MODULES} | {
        "field": "refdem.truth.traced_field"
    }
    before = {name: sys.modules.pop(name, None) for name in names.values()}
    try:
        for part, name in names.items():
            path = find_spec(name).origin
            source = Path(path).read_text()
            if part == module:
                assert source.count(old) == 1, f"{old!r} is {source.count(old)} times in {part}.py"
                source = source.replace(old, new)
            sys.modules[name] = ModuleType(name)
            exec(compile(source, path, "exec"), sys.modules[name].__dict__)
        return SimpleNamespace(**{part: sys.modules[name] for part, name in names.items()})
    finally:
        for name, found in before.items():
            sys.modules.pop(name, None)
            if found is not None:
                sys.modules[name] = found
