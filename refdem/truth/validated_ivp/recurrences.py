"""Taylor coefficients of the solution by the recurrences of its operations (Moore 1966; Jorba & Zou
2005, proposition 1).

Theorem: if y is the series of the solution from y_0, then (n+1) y_(n+1) = [f(y)]_n, and [f(y)]_n
needs y_0 .. y_n only. In balls the coefficients contain those of the solutions from every point of
the start.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import count, repeat
from operator import mul

from flint import arb, arb_poly

from refdem.truth.traced_field import Program

Series = list[arb]
BLOCK = 16
"""The number of coefficients in a block: products of blocks are made by Arb, those of the newest
coefficients one by one.
"""


class Product:
    """The coefficients [x y]_0, [x y]_1, ... of the product of two series, one after another, while
    the series grow: [x y]_k needs x_0 .. x_k and y_0 .. y_k.

    Relaxed multiplication (van der Hoeven 2002, section 4): with m the largest power of two in k,
    the pairs of indices [k-m, k) x [0, 2m) and their mirror image are added to `known` when k, a
    multiple of BLOCK, is reached; what is left of [x y]_k are the pairs with one index in the block
    of k. `k` is the next coefficient.
    """

    def __init__(self, x: Series, y: Series) -> None:
        self.x = x
        self.y = y
        self.k = 0
        self.known: Series = []

    def next(self) -> arb:
        """The next coefficient [x y]_k = sum over i of x_i y_(k-i)."""
        x = self.x
        y = self.y
        k = self.k
        begin = k - k % BLOCK
        if begin == 0:
            coefficient = sum(map(mul, x[: k + 1], y[k::-1]), arb(0))
        else:
            if begin == k:
                # k & -k is the largest power of two in k.
                self.add_blocks(k, k & -k)
            # Pairs whose index of x is in the block of k, then those whose index of y is:
            # sum over i in [begin, k] of x_i y_(k-i) + y_i x_(k-i).
            half = sum(map(mul, x[begin : k + 1], y[k - begin :: -1]), arb(0))
            if x is y:
                newest = 2 * half
            else:
                newest = sum(map(mul, y[begin : k + 1], x[k - begin :: -1]), half)
            coefficient = self.known[k] + newest
        self.k += 1
        return coefficient

    def add_blocks(self, k: int, m: int) -> None:
        """Adds the products of the newest m coefficients [k - m, k) with the first ones to the
        coefficients [k, k + m) of the product.

        The first block has no mirror image: both factors are in it.
        """
        x = self.x
        y = self.y
        low = k - m
        if low:
            whole = arb_poly(x[low:k]) * arb_poly(y[: 2 * m])
            if x is y:
                whole += whole
            else:
                whole += arb_poly(y[low:k]) * arb_poly(x[: 2 * m])
        else:
            whole = arb_poly(x[low:k]) * arb_poly(y[:m])
        # Coefficient i - low of x_low .. x_(k-1) times y_0, y_1, ... is a part of [x y]_i.
        self.known += [arb(0)] * (k + m - len(self.known))
        for i in range(k, k + m):
            self.known[i] += whole[i - low]


def taylor(program: Program, start: Sequence[arb], order: int) -> list[arb_poly]:
    """The Taylor polynomials of degree `order` of the solution of y' = program(y) from `start`, one
    for each coordinate.

    Every operation of the program gets a series. Coefficient n of all of them, in the order of the
    operations, gives [f(y)]_n, and that gives y_(n+1) (theorem of the module).
    """
    solution = [[value] for value in start]
    table: list[Series] = []
    for kind, *parts in program.operations:
        if kind == "in":
            table.append(solution[parts[0]])
        else:
            table.append([])
    rules = rules_of(program, table)
    for n in range(order):
        for series, rule in rules:
            series.append(next(rule))
        for series, output in zip(solution, program.outputs, strict=True):
            series.append(table[output][n] / (n + 1))
    return [arb_poly(series) for series in solution]


def rules_of(program: Program, table: list[Series]) -> list[tuple[Series, "Rule"]]:
    """The series of each operation that is no input, with the rule that makes its coefficients.

    `table` has the series of all operations of the program.
    """
    waves = {
        operation: series
        for operation, series in zip(program.operations, table, strict=True)
        if operation[0] in PARTNERS
    }
    rules = []
    for (kind, *parts), ball, series in zip(
        program.operations, program.constants(), table, strict=True
    ):
        if kind == "in":
            continue
        if kind in PARTNERS:
            # sin and cos of one argument: each needs the series of the other.
            argument = parts[0]
            partner = waves[PARTNERS[kind], argument]
            rules.append((series, RULES[kind](partner, ball, table[argument])))
            continue
        if kind == "constant":
            arguments = []
        elif kind == "scale":
            # ("scale", c, a): the constant is in `ball`.
            arguments = parts[-1:]
        else:
            arguments = parts
        rules.append((series, RULES[kind](series, ball, *(table[i] for i in arguments))))
    return rules


PARTNERS = {"sin": "cos", "cos": "sin"}
Rule = Iterator[arb]
"""The coefficients of an operation, each requested when it is the next one of its series and its
arguments have theirs. A rule's arguments are a series, the ball of a constant, and the series of
the operands.
"""


def constant(_: Series, ball: arb) -> Rule:
    """The Taylor coefficients c, 0, 0, ... of a constant."""
    yield ball
    yield from repeat(arb(0))


def product(_: Series, __: arb, a: Series, b: Series) -> Rule:
    """The Taylor coefficients [a b]_n of a product."""
    whole = Product(a, b)
    while True:
        yield whole.next()


def quotient(q: Series, _: arb, a: Series, b: Series) -> Rule:
    """The Taylor coefficients q_n of a quotient a/b: q b_0 = a - q (b - b_0)."""
    # q_n = (a_n - [q (b - b_0)]_n)/b_0; the coefficient of b - b_0 at n = 0 is 0, so that `later`
    # has b_1, b_2, ... and the next product is that of index n - 1.
    later: Series = []
    whole = Product(q, later)
    yield a[0] / b[0]
    for n in count(1):
        later.append(b[n])
        yield (a[n] - whole.next()) / b[0]


def root(s: Series, _: arb, a: Series) -> Rule:
    """The Taylor coefficients s_n of a square root: 2 s_0 (s - s_0) = a - a_0 - (s - s_0)^2."""
    # s_n = (a_n - [(s - s_0)^2]_n)/(2 s_0) for n >= 1. `later` has s_1, s_2, ..., so that the next
    # product is that of index n - 2; for n = 1 the square has no term.
    later: Series = []
    whole = Product(later, later)
    yield a[0].sqrt()
    yield a[1] / (2 * s[0])
    for n in count(2):
        later.append(s[n - 1])
        yield (a[n] - whole.next()) / (2 * s[0])


def driven(partner: Series, first: Callable[[arb], arb], sign: int, a: Series) -> Rule:
    """The Taylor coefficients of a w with w' = sign a' partner, from w_0 = first(a_0).

    n w_n = sign [a' partner]_(n-1): sin and cos are each other's partner, exp is its own.
    """
    slopes: Series = []
    whole = Product(slopes, partner)
    yield first(a[0])
    for n in count(1):
        slopes.append(sign * n * a[n])
        yield whole.next() / n


RULES: dict[str, Callable[..., Rule]] = {
    "constant": constant,
    "scale": lambda _, ball, a: (ball * a[n] for n in count()),
    "+": lambda _, __, a, b: (a[n] + b[n] for n in count()),
    "*": product,
    "/": quotient,
    "sqrt": root,
    "exp": lambda e, _, a: driven(e, arb.exp, 1, a),
    "sin": lambda cosine, _, a: driven(cosine, arb.sin, 1, a),
    "cos": lambda sine, _, a: driven(sine, arb.cos, -1, a),
}
