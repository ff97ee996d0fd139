"""Lines of driven oscillators by mpmath (1.4) at 80 digits: motions by power series of their own,
amplitudes by the normal equations of least squares.

    python -m tests.properties.held_out.lines_by_mpmath > tests/properties/held_out/lines.txt

A line of lines.txt: the case, its parameters, the name of the line, and the real and the imaginary
part of c in Re(c exp(i w t)) [m].
"""

import json

from mpmath import cos, exp, factorial, lu_solve, matrix, mp, mpc, mpf, nstr, pi, polyval, sin, sqrt

mp.dps = 80
ORDER = 40
"""Terms of a power series; a step of 1/4 s ends it at 1e-40 of its start or below."""
STEP = mpf(1) / 8

TWO = {
    "eps": "1/2",
    "delta": "1/4",
    "drive": "1/2,4/5",
    "x0": "1/4",
    "duration": "32",
    "samples": "64",
}
ONE = {
    "eps": "-1/3",
    "delta": "1/8",
    "f0": "0,1/2",
    "drive": "0,2/3",
    "x0": "0",
    "duration": "24",
    "samples": "48",
}
CUBE = {
    "alpha": "1",
    "beta": "1/4",
    "delta": "1/4",
    "f0": "1/2",
    "drive": "3/4",
    "x0": "0",
    "v0": "0",
    "duration": "24",
    "samples": "48",
}
CYCLE = {"x0": "2", "duration": "128", "samples": "256"}
BETWEEN = mpf(1) / 2
"""Time [s] from one sample of the cycle to the next."""
CYCLE_STEPS = 5
"""Steps from one sample of the cycle to the next."""
SETTLED = 90
"""The sample of the cycle at 45 s."""
NAMED = {(1, 0): "w", (0, 1): "wd", (2, -1): "2w-wd", (3, -2): "3w-2wd", (3, 0): "3w"}
"""Multiples of the cycle and of the drive, and the name of their sum."""


def places(square, eps, beta, delta, drives, x, v, samples):
    """The places at every half second of x'' + 2 delta x' + w0^2 x + eps x^2 + beta x^3 = sum f
    cos(w t).
    """
    found = [x]
    steps = int(1 / (2 * STEP))
    for number in range(samples * steps):
        t = number * STEP
        a = [x, v]
        # Taylor coefficients of x^2 on the way.
        squares = []
        for n in range(ORDER):
            squares.append(sum(a[k] * a[n - k] for k in range(n + 1)))
            cube = sum(squares[k] * a[n - k] for k in range(n + 1))
            # That of cos(w t) is w^n cos(w t + n pi/2)/n!.
            push = sum(f * w**n * cos(w * t + n * pi / 2) / factorial(n) for f, w in drives)
            rest = square * a[n] + eps * squares[n] + beta * cube
            a.append((push - rest - 2 * delta * (n + 1) * a[n + 1]) / ((n + 2) * (n + 1)))
        slopes = [n * coefficient for n, coefficient in enumerate(a)]
        x = polyval(a[::-1], STEP)
        v = polyval(slopes[:0:-1], STEP)
        if (number + 1) % steps == 0:
            found.append(x)
    return found


def lines(of, frequencies, square, delta):
    """Shift and lines at the frequencies of places at every half second; the free motion is fitted
    along.
    """
    rate = sqrt(square - delta**2)
    rows = []
    for number in range(len(of)):
        t = mpf(number) / 2
        row = [mpf(1)]
        for w in frequencies:
            row += [cos(w * t), sin(w * t)]
        decay = exp(-delta * t)
        rows.append([*row, decay * cos(rate * t), decay * sin(rate * t)])
    fitted = matrix(rows)
    solved = lu_solve(fitted.T * fitted, fitted.T * matrix(of))
    pairs = [mpc(solved[1 + 2 * k], -solved[2 + 2 * k]) for k in range(len(frequencies))]
    return [mpc(solved[0]), *pairs]


def cycle_places(mu, p, drive, x, v, samples):
    """The places of x'' - mu (1 - x^2) x' + x = p sin(w t) at the samples, BETWEEN apart."""
    step = BETWEEN / CYCLE_STEPS
    found = [x]
    for number in range(samples * CYCLE_STEPS):
        t = number * step
        a = [x, v]
        squares = []
        for n in range(ORDER):
            squares.append(sum(a[k] * a[n - k] for k in range(n + 1)))
            # Taylor coefficients of x^2 x' on the way.
            braked = sum(squares[k] * (n - k + 1) * a[n - k + 1] for k in range(n + 1))
            push = p * drive**n * sin(drive * t + n * pi / 2) / factorial(n)
            rate = mu * ((n + 1) * a[n + 1] - braked) - a[n] + push
            a.append(rate / ((n + 2) * (n + 1)))
        slopes = [n * coefficient for n, coefficient in enumerate(a)]
        x = polyval(a[::-1], step)
        v = polyval(slopes[:0:-1], step)
        if (number + 1) % CYCLE_STEPS == 0:
            found.append(x)
    return found


def mixed(order):
    """Pairs (j, k) of multiples of a cycle and a drive, odd in all and of at most that order."""
    span = range(-order, order + 1)
    pairs = [(j, k) for j in span for k in span if (j + k) % 2 and abs(j) + abs(k) <= order]
    return [pair for pair in pairs if pair > (0, 0)]


def cycle_lines(of, cycle, drive, pairs):
    """The mean square that lines at the pairs leave of the settled places, and the lines."""
    rows = []
    for number in range(SETTLED, len(of)):
        t = number * BETWEEN
        row = [mpf(1)]
        for j, k in pairs:
            phase = (j * cycle + k * drive) * t
            row += [cos(phase), sin(phase)]
        rows.append(row)
    fitted = matrix(rows)
    wanted = matrix(of[SETTLED:])
    solved = lu_solve(fitted.T * fitted, fitted.T * wanted)
    left = fitted * solved - wanted
    found = [mpc(solved[1 + 2 * n], -solved[2 + 2 * n]) for n in range(len(pairs))]
    return (left.T * left)[0], found


def said_of_cycle():
    """Prints lines of van der Pol's oscillator where its frequency w leaves least, to twelve
    digits.
    """
    drive = mpf(23) / 20
    of = cycle_places(mpf(1) / 5, mpf(1) / 25, drive, mpf(2), mpf(0), 256)
    # Thirty digits suffice once the places are known.
    mp.dps = 30
    pairs = mixed(5)
    low = mpf("0.99")
    high = mpf("1.005")
    golden = (sqrt(mpf(5)) - 1) / 2
    while high - low > mpf("1e-12"):
        below = high - golden * (high - low)
        above = low + golden * (high - low)
        if cycle_lines(of, below, drive, pairs)[0] < cycle_lines(of, above, drive, pairs)[0]:
            high = above
        else:
            low = below
    _, found = cycle_lines(of, low, drive, pairs)
    by_pair = dict(zip(pairs, found, strict=True))
    said("van-der-pol", CYCLE, NAMED.values(), [by_pair[pair] for pair in NAMED])


def said(case, given, names, found):
    """Prints the lines of a case."""
    for name, c in zip(names, found, strict=True):
        print(json.dumps([case, given, name, nstr(c.real, 60), nstr(c.imag, 60)]))


def main():
    """Prints all lines."""
    half = mpf(1) / 2
    fifth = mpf(1) / 5
    w1, w2 = half, 4 * fifth
    of = places(1, half, 0, half / 2, [(fifth, w1), (fifth, w2)], half / 2, mpf(0), 64)
    frequencies = [w1, w2, 2 * w1, w1 + w2, 2 * w2, w2 - w1]
    names = ["shift", "w1", "w2", "2w1", "w1+w2", "2w2", "w2-w1"]
    said("quadratic-response", TWO, names, lines(of, frequencies, 1, half / 2))

    w = mpf(2) / 3
    of = places(1, -mpf(1) / 3, 0, mpf(1) / 8, [(half, w)], mpf(0), mpf(0), 48)
    said("quadratic-response", ONE, ["shift", "w", "2w"], lines(of, [w, 2 * w], 1, mpf(1) / 8))

    w = mpf(3) / 4
    of = places(1, 0, mpf(1) / 4, half / 2, [(half, w)], mpf(0), mpf(0), 48)
    said("driven-duffing", CUBE, ["shift", "w", "3w"], lines(of, [w, 3 * w], 1, half / 2))

    said_of_cycle()


if __name__ == "__main__":
    main()
