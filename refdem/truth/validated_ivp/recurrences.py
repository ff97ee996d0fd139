"""Taylor coefficients of the solution by the recurrences of its operations (Moore 1966; Jorba & Zou 2005, proposition 1).

Theorem: if y is the series of the solution from y_0, then (n+1) y_(n+1) = [f(y)]_n, and [f(y)]_n needs y_0 .. y_n only. In balls the
coefficients contain those of the solutions from every point of the start.
"""

from collections.abc import Callable, Sequence
from operator import mul

from flint import arb, arb_poly

from refdem.truth.balls import arb_of
from refdem.truth.validated_ivp.field import Program

Series = list[arb]


def taylor(program: Program, start: Sequence[arb], order: int) -> list[arb_poly]:
    """Polynomials of degree `order`: the Taylor coefficients of the solutions of y' = program(y) from `start`."""
    solution = [[value] for value in start]
    table: list[Series] = [[] for _ in program.operations]
    constants = [arb_of(operation[1]) if operation[0] in ("constant", "scale") else arb(0) for operation in program.operations]
    partners: dict[tuple[str, int], Series] = {}
    for n in range(order):
        for operation, constant, series in zip(program.operations, constants, table, strict=True):
            kind, *arguments = operation
            if kind == "in":
                series.append(solution[arguments[0]][n])
            elif kind == "constant":
                series.append(constant if n == 0 else arb(0))
            elif kind == "scale":
                series.append(constant * table[arguments[1]][n])
            elif kind in ("sin", "cos"):
                _wave(kind, table[arguments[0]], series, partners.setdefault((kind, arguments[0]), []), n)
            else:
                series.append(NEXT[kind](series, *(table[i] for i in arguments), n))
        for series, output in zip(solution, program.outputs, strict=True):
            series.append(table[output][n] / (n + 1))
    return [arb_poly(series) for series in solution]


def convolution(a: Series, b: Series, n: int, first: int, last: int) -> arb:
    """sum over first <= i <= last of a_i b_(n-i)."""
    return sum(map(mul, a[first : last + 1], b[n - last : n - first + 1][::-1]), arb(0))


def _product(_: Series, a: Series, b: Series, n: int) -> arb:
    if a is not b:
        return convolution(a, b, n, 0, n)
    half = 2 * convolution(a, a, n, 0, (n - 1) // 2) if n else arb(0)
    return half + a[n // 2] * a[n // 2] if n % 2 == 0 else half


def _quotient(q: Series, a: Series, b: Series, n: int) -> arb:
    return (a[n] - convolution(q, b, n, 0, n - 1)) / b[0] if n else a[0] / b[0]


def _root(s: Series, a: Series, n: int) -> arb:
    if n == 0:
        return a[0].sqrt()
    return (a[n] - (convolution(s, s, n, 1, n - 1) if n > 1 else 0)) / (2 * s[0])


def _slopes(a: Series, n: int) -> Series:
    """i a_i for i = 0 .. n."""
    return [i * a[i] for i in range(n + 1)]


def _exponential(e: Series, a: Series, n: int) -> arb:
    return convolution(_slopes(a, n), e, n, 1, n) / n if n else a[0].exp()


def _wave(kind: str, a: Series, series: Series, partner: Series, n: int) -> None:
    """The next coefficient of sin a (or cos a), and of its partner cos a (or sin a): n s_n = sum i a_i c_(n-i), and so on."""
    sign = 1 if kind == "sin" else -1
    if n == 0:
        both = a[0].sin(), a[0].cos()
        first, second = both if kind == "sin" else both[::-1]
    else:
        slopes = _slopes(a, n)
        first, second = sign * convolution(slopes, partner, n, 1, n) / n, -sign * convolution(slopes, series, n, 1, n) / n
    series.append(first)
    partner.append(second)


NEXT: dict[str, Callable[..., arb]] = {
    "+": lambda _, a, b, n: a[n] + b[n],
    "*": _product,
    "/": _quotient,
    "exp": _exponential,
    "sqrt": _root,
}
