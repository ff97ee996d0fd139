"""A class is abstract or final: no method that is implemented is overridden, and no class is deep.

`python tests/layout/test_inheritance.py [PACKAGE]` prints what there is of both.
"""

import ast
import importlib
import inspect
import pkgutil
import sys
import textwrap
import warnings
from collections.abc import Iterator
from typing import Any

import refdem

HELD = "refdem.truth"
"""Where the rules hold."""
DEEPEST = 3
"""Classes of refdem in a line, the class itself among them: Truth, ClosedForm, a family."""
CONSTRUCTORS = ("__init__", "__new__", "__post_init__")


def classes(package: str = "refdem") -> list[type]:
    """Every class that a module of the package defines, by name."""
    found: dict[str, type] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for info in pkgutil.walk_packages(refdem.__path__, "refdem."):
            if not info.name.startswith(package):
                continue
            try:
                module = importlib.import_module(info.name)
            except ImportError:
                continue  # an engine that is not installed here
            for value in vars(module).values():
                if inspect.isclass(value) and value.__module__ == info.name:
                    found[f"{info.name}.{value.__qualname__}"] = value
    return [found[name] for name in sorted(found)]


def is_ours(cls: type) -> bool:
    return cls.__module__.partition(".")[0] == "refdem"


def function_of(member: Any) -> Any:
    """The function of a method, whatever decorates it; None for what is none, or is generated."""
    if isinstance(member, staticmethod | classmethod):
        member = member.__func__
    if isinstance(member, property):
        member = member.fget
    member = inspect.unwrap(member) if callable(member) else member
    if not inspect.isfunction(member) or member.__code__.co_filename == "<string>":
        return None  # a dataclass writes its constructor into "<string>"
    return member


def is_trivial(function: Any) -> bool:
    """Whether the body says nothing but a constant, an empty container or `self`.

    Such a body is the default of a question that a class may answer: "no scalars", "no period".
    """
    tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    assert isinstance(tree, ast.FunctionDef | ast.AsyncFunctionDef)
    body = [
        statement
        for statement in tree.body
        if not (isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant))
    ]
    if not body:
        return True
    if len(body) > 1 or not isinstance(body[0], ast.Return):
        return False
    value = body[0].value
    is_empty = (isinstance(value, ast.Dict) and not value.keys) or (
        isinstance(value, ast.List | ast.Tuple) and not value.elts
    )
    is_self = isinstance(value, ast.Name) and value.id == "self"
    return value is None or isinstance(value, ast.Constant) or is_empty or is_self


def is_implemented(cls: type, name: str) -> bool:
    """Whether a class of refdem itself says what a method does."""
    function = function_of(vars(cls).get(name))
    if function is None or getattr(cls, "_is_protocol", False):
        return False
    member = vars(cls)[name]
    is_abstract = getattr(member, "__isabstractmethod__", False)
    return not is_abstract and not is_trivial(function)


def overridden(cls: type) -> Iterator[tuple[str, type]]:
    """Methods of a class that a base class of refdem implements, and that base class."""
    for name, member in vars(cls).items():
        if name == "__init__" and issubclass(cls, Exception):
            continue  # what an error says is its own
        is_special = name.startswith("__") and name not in CONSTRUCTORS
        if is_special or function_of(member) is None:
            continue
        for base in cls.__mro__[1:]:
            if is_ours(base) and is_implemented(base, name):
                yield name, base
                break


def depth(cls: type) -> int:
    """Classes of refdem in the longest line from a class upwards."""
    return 1 + max((depth(base) for base in cls.__bases__ if is_ours(base)), default=0)


def overrides(package: str) -> dict[str, str]:
    """`module.Class.method` and the class that it overrides."""
    return {
        f"{cls.__module__}.{cls.__qualname__}.{name}": f"{base.__module__}.{base.__qualname__}"
        for cls in classes(package)
        for name, base in overridden(cls)
    }


def deep(package: str) -> list[str]:
    """Classes that are deeper than DEEPEST."""
    return [
        f"{cls.__module__}.{cls.__qualname__}" for cls in classes(package) if depth(cls) > DEEPEST
    ]


class Base:
    def answer(self) -> int:
        return 6 * 7

    def default(self) -> None:
        """Nothing."""
        return None


class Child(Base):
    def answer(self) -> int:
        return 43

    def default(self) -> None:
        print("said")


def test_an_override_of_what_is_implemented_is_seen_and_a_default_that_is_answered_is_none(
    monkeypatch,
) -> None:
    monkeypatch.setattr(sys.modules[__name__], "is_ours", lambda cls: cls in (Base, Child))
    assert [name for name, _ in overridden(Child)] == ["answer"]
    assert depth(Child) == 2


def test_no_method_of_truth_that_is_implemented_is_overridden() -> None:
    assert overrides(HELD) == {}


def test_no_class_of_truth_is_deep() -> None:
    assert deep(HELD) == []


if __name__ == "__main__":
    asked = sys.argv[1] if len(sys.argv) > 1 else "refdem"
    every = overrides(asked)
    for overriding, base_name in every.items():
        print(f"{overriding} overrides {base_name}")
    print(f"{len(every)} overrides; deepest:")
    for deepest in sorted(classes(asked), key=depth, reverse=True)[:10]:
        print(f"  {depth(deepest)} {deepest.__module__}.{deepest.__qualname__}")
