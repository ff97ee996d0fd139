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
"""Coefficients that are multiplied one by one; Arb multiplies whole blocks of them."""


class Product:
    """[x y]_0, [x y]_1, ... one after another, of two series that grow meanwhile: [x y]_k needs x_0
    .. x_k and y_0 .. y_k.

    Relaxed multiplication (van der Hoeven 2002, section 4): with m the largest power of two in k,
    [k-m, k) x [0, 2m) and its mirror image are added to `known` when k is reached; what is left of
    [x y]_k are the pairs with one index in the block of k.
    """

    def __init__(self, x: Series, y: Series) -> None:
        self.x = x
        self.y = y
        self.k = 0
        self.known: Series = []

    def next(self) -> arb:
        """The next Taylor coefficient of the product."""
        x = self.x
        y = self.y
        k = self.k
        begin = k - k % BLOCK
        if begin == 0:
            found = sum(map(mul, x[: k + 1], y[k::-1]), arb(0))
        else:
            if begin == k:
                self.add_blocks(k, k & -k)
            half = sum(map(mul, x[begin : k + 1], y[k - begin :: -1]), arb(0))
            found = self.known[k] + (
                2 * half if x is y else sum(map(mul, y[begin : k + 1], x[k - begin :: -1]), half)
            )
        self.k += 1
        return found

    def add_blocks(self, k: int, m: int) -> None:
        """What the newest m coefficients make of the first ones, to [k, k + m)."""
        x = self.x
        y = self.y
        low = k - m
        whole = arb_poly(x[low:k]) * arb_poly(y[: 2 * m if low else m])
        if low:
            whole += whole if x is y else arb_poly(y[low:k]) * arb_poly(x[: 2 * m])
        self.known += [arb(0)] * (k + m - len(self.known))
        for i in range(k, k + m):
            self.known[i] += whole[i - low]


def taylor(program: Program, start: Sequence[arb], order: int) -> list[arb_poly]:
    """Polynomials of degree `order`: the Taylor coefficients of the solutions of y' = program(y)
    from `start`.
    """
    solution = [[value] for value in start]
    table: list[Series] = [solution[o[1]] if o[0] == "in" else [] for o in program.operations]
    waves = {
        operation: series
        for operation, series in zip(program.operations, table, strict=True)
        if operation[0] in PARTNERS
    }
    rules = []
    for (kind, *parts), ball, series in zip(
        program.operations, program.constants(), table, strict=True
    ):
        if kind in PARTNERS:
            rules.append(
                (series, RULES[kind](waves[PARTNERS[kind], parts[0]], ball, table[parts[0]]))
            )
        elif kind != "in":
            if kind == "constant":
                earlier = []
            elif kind == "scale":
                earlier = parts[-1:]
            else:
                earlier = parts
            rules.append((series, RULES[kind](series, ball, *(table[i] for i in earlier))))
    for n in range(order):
        for series, rule in rules:
            series.append(next(rule))
        for series, output in zip(solution, program.outputs, strict=True):
            series.append(table[output][n] / (n + 1))
    return [arb_poly(series) for series in solution]


PARTNERS = {"sin": "cos", "cos": "sin"}
Rule = Iterator[arb]
"""The coefficients of an operation, each asked for when it is the next one of its series and its
arguments have theirs.
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
    """The coefficients of a quotient, by q b_0 = a - q (b - b_0)."""
    later: Series = []
    whole = Product(q, later)
    yield a[0] / b[0]
    for n in count(1):
        later.append(b[n])
        yield (a[n] - whole.next()) / b[0]


def root(s: Series, _: arb, a: Series) -> Rule:
    """2 s_0 (s - s_0) = a - a_0 - (s - s_0)^2."""
    later: Series = []
    whole = Product(later, later)
    yield a[0].sqrt()
    yield a[1] / (2 * s[0])
    for n in count(2):
        later.append(s[n - 1])
        yield (a[n] - whole.next()) / (2 * s[0])


def driven(partner: Series, first: Callable[[arb], arb], sign: int, a: Series) -> Rule:
    """w' = sign a' partner from w_0 = first(a_0)."""
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
