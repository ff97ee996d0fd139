"""A field written once and traced: the same list of operations for complex balls, power series, recurrences and derivatives.

Theorem (inclusion): each operation on balls contains all its values on them, so a program does; where an operation is not analytic on
the balls (a divisor or a root's argument that may vanish) the result is not finite, and what is built on it is refused.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from flint import acb, arb

from refdem.truth.balls import arb_of

Operation = tuple[Any, ...]
"""("in", i), ("constant", c), ("scale", c, a), (+ - * /, a, b) or (sin cos exp sqrt, a); a and b are earlier operations."""


@dataclass
class Trace:
    """Operations in the order in which they were written, each kept once."""

    operations: list[Operation] = field(default_factory=list)
    known: dict[Operation, int] = field(default_factory=dict)
    slopes: dict[tuple[int, int], "Node"] = field(default_factory=dict)

    def node(self, *operation: Any) -> "Node":
        """The node of an operation, new if it is not yet known."""
        if operation not in self.known:
            self.known[operation] = len(self.operations)
            self.operations.append(operation)
        return Node(self, self.known[operation])

    def constant(self, value: object) -> "Node":
        """An exact rational; TypeError for anything else: 0.1 is not 1/10."""
        if isinstance(value, bool) or not isinstance(value, int | Fraction):
            raise TypeError(f"constant {value!r} of a traced field; expected an int or a Fraction")
        return self.node("constant", Fraction(value))


@dataclass(frozen=True)
class Node:
    """One value of a traced field; + - * / and the functions below make others."""

    trace: Trace
    index: int

    @property
    def operation(self) -> Operation:
        """What makes it."""
        return self.trace.operations[self.index]

    def exact(self) -> Fraction | None:
        """Its value if it is a constant."""
        return Fraction(self.operation[1]) if self.operation[0] == "constant" else None

    def _with(self, other: object) -> "Node":
        return other if isinstance(other, Node) else self.trace.constant(other)

    def __add__(self, other: object) -> "Node":
        other = self._with(other)
        a, b = self.exact(), other.exact()
        if a is not None and b is not None:
            return self.trace.constant(a + b)
        return other if a == 0 else self if b == 0 else self.trace.node("+", self.index, other.index)

    def __mul__(self, other: object) -> "Node":
        other = self._with(other)
        a, b = self.exact(), other.exact()
        if a is None and b is None:
            return self.trace.node("*", self.index, other.index)
        if a is not None and b is not None:
            return self.trace.constant(a * b)
        factor, node = (a, other) if a is not None else (b, self)
        if factor == 0:
            return self.trace.constant(0)
        return node if factor == 1 else self.trace.node("scale", factor, node.index)

    def __truediv__(self, other: object) -> "Node":
        other = self._with(other)
        b = other.exact()
        return self * (1 / b) if b is not None else self.trace.node("/", self.index, other.index)

    def __neg__(self) -> "Node":
        return self * -1

    def __sub__(self, other: object) -> "Node":
        return self + self._with(other) * -1

    def __rsub__(self, other: object) -> "Node":
        return self._with(other) - self

    def __rtruediv__(self, other: object) -> "Node":
        return self._with(other) / self

    __radd__, __rmul__ = __add__, __mul__

    def sin(self) -> "Node":
        return self.trace.node("sin", self.index)

    def cos(self) -> "Node":
        return self.trace.node("cos", self.index)

    def exp(self) -> "Node":
        return self.trace.node("exp", self.index)

    def sqrt(self) -> "Node":
        return self.trace.node("sqrt", self.index)


Field = Callable[[Sequence[Any]], Sequence[Any]]
"""f(y) by + - * / and the methods sin, cos, exp, sqrt, with exact rational constants; time is a coordinate with derivative 1."""


def traced(function: Field, inputs: int) -> tuple[list[Node], list[list[Node]]]:
    """The outputs of a function of `inputs` numbers, and their derivatives by each of these."""
    trace = Trace()
    outputs = [trace.node("in", 0)._with(out) for out in function([trace.node("in", i) for i in range(inputs)])]
    return outputs, [[slope(out, i) for i in range(inputs)] for out in outputs]


def slope(node: Node, by: int) -> Node:
    """The derivative of a node by input `by`, by the chain rule."""
    trace, key = node.trace, (node.index, by)
    if key not in trace.slopes:
        trace.slopes[key] = _slope(node, by)
    return trace.slopes[key]


def _slope(node: Node, by: int) -> Node:
    trace, (kind, *arguments) = node.trace, node.operation
    if kind in ("in", "constant"):
        return trace.constant(int(kind == "in" and arguments[0] == by))
    if kind == "scale":
        return slope(Node(trace, int(arguments[1])), by) * Fraction(arguments[0])
    a, b = Node(trace, arguments[0]), Node(trace, arguments[-1])
    da, db = slope(a, by), slope(b, by)
    return SLOPES[kind](node, a, da, b, db)


SLOPES: dict[str, Callable[..., Node]] = {
    "+": lambda node, a, da, b, db: da + db,
    "*": lambda node, a, da, b, db: da * b + a * db,
    "/": lambda node, a, da, b, db: (da - node * db) / b,
    "sin": lambda node, a, da, *_: a.cos() * da,
    "cos": lambda node, a, da, *_: -a.sin() * da,
    "exp": lambda node, a, da, *_: node * da,
    "sqrt": lambda node, a, da, *_: da / (node * 2),
}


class Program:
    """The operations up to those of some nodes, in order; `run` evaluates them on any numbers that know the operations."""

    def __init__(self, nodes: Sequence[Node]) -> None:
        self.outputs = [node.index for node in nodes]
        self.operations = nodes[0].trace.operations[: max(self.outputs) + 1]

    def run(self, inputs: Sequence[Any], constant: Callable[[Fraction], Any] = arb_of) -> list[Any]:
        """The outputs; `constant` makes a number of the right kind from an exact one."""
        values: list[Any] = []
        for kind, *arguments in self.operations:
            if kind == "in":
                values.append(inputs[arguments[0]])
            elif kind == "constant":
                values.append(constant(arguments[0]))
            elif kind == "scale":
                values.append(arb_of(arguments[0]) * values[arguments[1]])
            else:
                values.append(ELEMENTARY[kind](*(values[i] for i in arguments)))
        return [values[i] for i in self.outputs]


def root(value: Any) -> Any:
    """The principal square root; not finite where a complex box touches the branch cut, for it is not analytic there."""
    return value.sqrt(analytic=True) if isinstance(value, acb) else value.sqrt()


ELEMENTARY: dict[str, Callable[..., Any]] = {
    "+": lambda a, b: a + b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "sin": lambda a: a.sin(),
    "cos": lambda a: a.cos(),
    "exp": lambda a: a.exp(),
    "sqrt": root,
}


def largest(values: Sequence[arb | acb]) -> arb:
    """An exact upper bound of all absolute values (0 if there are none); nan if one is not finite."""
    bounds = [arb(value.abs_upper()) for value in values]
    return sum_of(bounds) if not all(bound.is_finite() for bound in bounds) else max(bounds, key=lambda x: x, default=arb(0))


def sum_of(values: Sequence[arb]) -> arb:
    """Their sum, 0 for none."""
    return sum(values, arb(0))
