"""A field that is written once and traced to a list of operations, which serves complex balls,
power series, recurrences and derivatives.

Theorem (inclusion): each operation on balls contains all its values on them, so a program does;
where an operation is not analytic on the balls (a divisor or a root's argument that may vanish) the
result is not finite, and what is built on it is refused.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from operator import pos
from typing import Any

from flint import acb, arb, ctx

from refdem.truth.balls import UndecidedError, arb_of
from refdem.truth.dual import slopes_of
from refdem.truth.reals import Number, is_number, with_derivatives

Operation = tuple[Any, ...]
"""The kind of an operation and its operands: ("in", i) for input i, ("constant", c), ("scale", c,
a) for c times a, (+ * /, a, b) or (sin cos exp sqrt, a); a and b are the numbers of earlier
operations.
"""

NONE = range(0)
"""The directions of a trace without parameters."""


@dataclass
class Trace:
    """Operations in the order in which they were written, each kept once.

    `known` has the number of each operation, `slopes` the derivative of an operation (by number) by
    an input. The inputs `directions` stand for the parameters that dual numbers (dual.py) depend
    on: they are 1, and the derivative by one is that by its parameter.
    """

    inputs: int = 0
    directions: range = NONE
    operations: list[Operation] = field(default_factory=list)
    known: dict[Operation, int] = field(default_factory=dict)
    slopes: dict[tuple[int, int], "Node"] = field(default_factory=dict)

    def node(self, *operation: Any) -> "Node":
        """The node of an operation, which is added if it is not yet known."""
        # Dual numbers of the same value are the same operation only with the same derivatives.
        key = (*operation, *map(slopes_of, operation))
        if key not in self.known:
            self.known[key] = len(self.operations)
            self.operations.append(operation)
        return Node(self, self.known[key])

    def constant(self, value: object) -> "Node":
        """The node of an exact number; a node stays what it is.

        TypeError for anything else: 0.1 is not 1/10.
        """
        if isinstance(value, Node):
            return value
        if not is_number(value):
            raise TypeError(
                f"constant {value!r} of a traced field; expected an int, a Fraction or a Real"
            )
        if isinstance(value, int):
            value = Fraction(value)
        if not self.directions:
            return self.node("constant", value)
        exact, slopes = with_derivatives(value)
        # c + sum c_k (d_k - 1), where every direction d_k is 1.
        total = self.node("constant", exact - sum(slopes))
        for place, slope_of_one in zip(self.directions, slopes, strict=False):
            total = total + self.node("in", place) * slope_of_one
        return total


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
        """The value of the node if it is a constant, else None."""
        kind, *parts = self.operation
        if kind != "constant":
            return None
        value: Number = parts[0]
        return value

    def __add__(self, other: object) -> "Node":
        """The node of a sum with a node or an exact number."""
        other = self.trace.constant(other)
        a = self.exact()
        b = other.exact()
        # The sum of two constants is a constant, and a + 0 = a needs no operation.
        if a is not None and b is not None:
            return self.trace.constant(a + b)
        if is_just(a, 0):
            return other
        if is_just(b, 0):
            return self
        return self.trace.node("+", self.index, other.index)

    def __mul__(self, other: object) -> "Node":
        """The node of a product with a node or an exact number."""
        other = self.trace.constant(other)
        # A constant factor makes a "scale", whose series needs no product.
        if self.exact() is None:
            factor = other.exact()
            node = self
        else:
            factor = self.exact()
            node = other
        if factor is None:
            return self.trace.node("*", self.index, other.index)
        value = node.exact()
        if value is not None:
            return self.trace.constant(factor * value)
        if is_just(factor, 0):
            return self.trace.constant(0)
        if is_just(factor, 1):
            return node
        return self.trace.node("scale", factor, node.index)

    def __truediv__(self, other: object) -> "Node":
        """The node of a quotient by a node, or of a product with the inverse of an exact number."""
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

    def _wave(self, partner: str, kind: str) -> "Node":
        """The node of sin or cos (`kind`); its `partner` is traced too, for each needs the other
        one's series.
        """
        self.trace.node(partner, self.index)
        return self.trace.node(kind, self.index)


def is_just(number: Number | None, value: int) -> bool:
    """True for the exact number of that value that carries no derivatives."""
    return number is not None and not slopes_of(number) and number == value


Field = Callable[[Sequence[Any]], Sequence[Any]]
"""f(y) by + - * / and the methods sin, cos, exp, sqrt, with exact constants (Number); time is a
coordinate with derivative 1.
"""


def traced(
    function: Field, inputs: int, directions: range = NONE
) -> tuple[list[Node], list[list[Node]]]:
    """The outputs of a function of `inputs` numbers, and the rows of its Jacobian, as nodes of one
    trace; the inputs `directions` stand for parameters (Trace).
    """
    trace = Trace(inputs, directions)
    arguments = [trace.node("in", i) for i in range(inputs)]
    outputs = [trace.constant(output) for output in function(arguments)]
    jacobian = [[slope(output, i) for i in range(inputs)] for output in outputs]
    return outputs, jacobian


def slope(node: Node, by: int) -> Node:
    """The derivative of a node by input `by`, by the chain rule; kept for the next call."""
    trace = node.trace
    key = (node.index, by)
    if key not in trace.slopes:
        kind, *operands = trace.operations[node.index]
        if kind in ("in", "constant"):
            trace.slopes[key] = trace.constant(int(kind == "in" and operands[0] == by))
        elif kind == "scale":
            factor, argument = operands
            trace.slopes[key] = slope(Node(trace, argument), by) * factor
        else:
            # a is the first operand and b the last one: they are the same in an operation of one.
            a = Node(trace, operands[0])
            b = Node(trace, operands[-1])
            trace.slopes[key] = SLOPES[kind](node, a, slope(a, by), b, slope(b, by))
    return trace.slopes[key]


SLOPES: dict[str, Callable[..., Node]] = {
    "+": lambda node, a, da, b, db: da + db,
    "*": lambda node, a, da, b, db: da * b + a * db,
    # q = a/b: dq = (da - q db)/b
    "/": lambda node, a, da, b, db: (da - node * db) / b,
    "sin": lambda node, a, da, *_: a.cos() * da,
    "cos": lambda node, a, da, *_: -a.sin() * da,
    # e = exp(a): de = e da, and s = sqrt(a): ds = da/(2 s)
    "exp": lambda node, a, da, *_: node * da,
    "sqrt": lambda node, a, da, *_: da / (node * 2),
}


class Program:
    """The operations that give the values of some nodes, in order.

    `run` evaluates them on any numbers that have the operations: balls, complex balls, series.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        self.outputs = [node.index for node in nodes]
        self.operations = nodes[0].trace.operations[: max(self.outputs) + 1]
        self.balls: dict[int, list[arb]] = {}

    def constants(self) -> list[arb]:
        """A ball, at the current precision, of the exact number in each operation; 0 where there is
        none.

        Raises UndecidedError for a number that this precision does not enclose.
        """
        if ctx.prec not in self.balls:
            balls = []
            for kind, first, *_ in self.operations:
                if kind in ("constant", "scale"):
                    balls.append(arb_of(first))
                else:
                    balls.append(arb(0))
            if not all(ball.is_finite() for ball in balls):
                raise UndecidedError(
                    f"a constant of the field is not enclosed with {ctx.prec} bits"
                )
            self.balls[ctx.prec] = balls
        return self.balls[ctx.prec]

    def run(self, inputs: Sequence[Any], constant: Callable[[arb], Any] = pos) -> list[Any]:
        """The outputs for these inputs; `constant` makes a number of their kind from a ball."""
        values: list[Any] = []
        for (kind, first, *rest), ball in zip(self.operations, self.constants(), strict=True):
            if kind in ELEMENTARY:
                value = ELEMENTARY[kind](values[first], *(values[i] for i in rest))
            elif kind == "in":
                value = inputs[first]
            elif kind == "constant":
                value = constant(ball)
            else:
                # ("scale", c, a).
                value = ball * values[rest[0]]
            values.append(value)
        return [values[i] for i in self.outputs]


def square_root(a: Any) -> Any:
    """The principal square root; of complex balls across its cut, where it is not analytic, not
    finite.
    """
    if isinstance(a, acb):
        return a.sqrt(analytic=True)
    return a.sqrt()


ELEMENTARY: dict[str, Callable[..., Any]] = {
    "+": lambda a, b: a + b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "sin": lambda a: a.sin(),
    "cos": lambda a: a.cos(),
    "exp": lambda a: a.exp(),
    "sqrt": square_root,
}
