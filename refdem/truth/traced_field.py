"""A field written once and traced: the same list of operations for complex balls, power series,
recurrences and derivatives.

Theorem (inclusion): each operation on balls contains all its values on them, so a program does;
where an operation is not analytic on the balls (a divisor or a root's argument that may vanish) the
result is not finite, and what is built on it is refused.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from flint import acb, arb, ctx

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.reals import Number, is_number

Operation = tuple[Any, ...]
"""("in", i), ("constant", c), ("scale", c, a), (+ * /, a, b) or (sin cos exp sqrt, a); a and b are
earlier operations.
"""


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
        """A node, or that of an exact number; TypeError for anything else: 0.1 is not 1/10."""
        if isinstance(value, Node):
            return value
        if not is_number(value):
            raise TypeError(
                f"constant {value!r} of a traced field; expected an int, a Fraction or a Real"
            )
        return self.node("constant", Fraction(value) if isinstance(value, int) else value)


@dataclass(frozen=True)
class Node:
    """One value of a traced field; + - * / and sin, cos, exp, sqrt make others."""

    trace: Trace
    index: int

    @property
    def operation(self) -> Operation:
        """The operation that makes the value of the node."""
        return self.trace.operations[self.index]

    def exact(self) -> Number | None:
        """The value of the node if it is a constant."""
        kind, *parts = self.operation
        if kind != "constant":
            return None
        value: Number = parts[0]
        return value

    def __add__(self, other: object) -> "Node":
        other = self.trace.constant(other)
        a = self.exact()
        b = other.exact()
        if a is not None and b is not None:
            return self.trace.constant(a + b)
        if a == 0:
            return other
        if b == 0:
            return self
        return self.trace.node("+", self.index, other.index)

    def __mul__(self, other: object) -> "Node":
        other = self.trace.constant(other)
        factor, node = (other.exact(), self) if self.exact() is None else (self.exact(), other)
        if factor is None:
            return self.trace.node("*", self.index, other.index)
        value = node.exact()
        if factor == 0 or value is not None:
            return self.trace.constant(factor * (value or 0))
        if factor == 1:
            return node
        return self.trace.node("scale", factor, node.index)

    def __truediv__(self, other: object) -> "Node":
        other = self.trace.constant(other)
        value = other.exact()
        if value is None:
            return self.trace.node("/", self.index, other.index)
        return self * (1 / value)

    def __neg__(self) -> "Node":
        return self * -1

    def __sub__(self, other: object) -> "Node":
        return self + self.trace.constant(other) * -1

    def __rsub__(self, other: object) -> "Node":
        return self * -1 + other

    def __rtruediv__(self, other: object) -> "Node":
        return self.trace.constant(other) / self

    __radd__ = __add__
    __rmul__ = __mul__

    def sin(self) -> "Node":
        return self._wave("cos", "sin")

    def cos(self) -> "Node":
        return self._wave("sin", "cos")

    def exp(self) -> "Node":
        return self.trace.node("exp", self.index)

    def sqrt(self) -> "Node":
        return self.trace.node("sqrt", self.index)

    def _wave(self, *kinds: str) -> "Node":
        """The last of the two, each of which needs the other one's series."""
        return [self.trace.node(kind, self.index) for kind in kinds][-1]


Field = Callable[[Sequence[Any]], Sequence[Any]]
"""f(y) by + - * / and the methods sin, cos, exp, sqrt, with exact constants (Number); time is a
coordinate with derivative 1.
"""


def traced(function: Field, inputs: int) -> tuple[list[Node], list[list[Node]]]:
    """The outputs of a function of `inputs` numbers, and their derivatives by each of these."""
    trace = Trace()
    outputs = [
        trace.constant(out) for out in function([trace.node("in", i) for i in range(inputs)])
    ]
    return outputs, [[slope(out, i) for i in range(inputs)] for out in outputs]


def slope(node: Node, by: int) -> Node:
    """The derivative of a node by input `by`, by the chain rule."""
    trace = node.trace
    key = (node.index, by)
    if key not in trace.slopes:
        kind, *parts = trace.operations[node.index]
        if kind in ("in", "constant"):
            trace.slopes[key] = trace.constant(int(kind == "in" and parts[0] == by))
        elif kind == "scale":
            trace.slopes[key] = slope(Node(trace, parts[1]), by) * parts[0]
        else:
            a = Node(trace, parts[0])
            b = Node(trace, parts[-1])
            trace.slopes[key] = SLOPES[kind](node, a, slope(a, by), b, slope(b, by))
    return trace.slopes[key]


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
    """The operations up to those of some nodes, in order.

    `run` evaluates them on any numbers that know the operations.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        self.outputs = [node.index for node in nodes]
        self.operations = nodes[0].trace.operations[: max(self.outputs) + 1]
        self.balls: dict[int, list[arb]] = {}

    def constants(self) -> list[arb]:
        """For each operation a ball, at the current precision, of the exact number in it; 0 where
        there is none.

        Raises UndecidedError for a number that this precision does not enclose.
        """
        if ctx.prec not in self.balls:
            found = [
                arb_of(o[1]) if o[0] in ("constant", "scale") else arb(0) for o in self.operations
            ]
            if not all(ball.is_finite() for ball in found):
                raise UndecidedError(
                    f"a constant of the field is not enclosed with {ctx.prec} bits"
                )
            self.balls[ctx.prec] = found
        return self.balls[ctx.prec]

    def run(self, inputs: Sequence[Any], constant: Callable[[arb], Any] = arb) -> list[Any]:
        """The outputs; `constant` makes a number of the right kind from a ball."""
        values: list[Any] = []
        for (kind, first, *rest), ball in zip(self.operations, self.constants(), strict=True):
            if kind in ELEMENTARY:
                values.append(ELEMENTARY[kind](values[first], *(values[i] for i in rest)))
            else:
                values.append(
                    inputs[first]
                    if kind == "in"
                    else constant(ball)
                    if kind == "constant"
                    else ball * values[rest[0]]
                )
        return [values[i] for i in self.outputs]


ELEMENTARY: dict[str, Callable[..., Any]] = {
    "+": lambda a, b: a + b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "sin": lambda a: a.sin(),
    "cos": lambda a: a.cos(),
    "exp": lambda a: a.exp(),
    # the principal root is not analytic across its cut, and then not finite
    "sqrt": lambda a: a.sqrt(analytic=True) if isinstance(a, acb) else a.sqrt(),
}
