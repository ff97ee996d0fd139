"""The logistic map x -> eta x (1 - x), proved iterate by iterate, and the logistic equation x' =
eta x (1 - x) in closed form (1.127).

In y = x - 1/2 the map is y -> eta (1/4 - y^2) - 1/2: a ball's radius grows by |f'| and no more. At
eta = 4, x = sin^2 theta makes it theta -> 2 theta: x_n = sin^2(2^n theta_0), the witness, whose
derivative is 2^n sqrt(x_n (1 - x_n)/(x_0 (1 - x_0))).
"""

from collections.abc import Mapping
from fractions import Fraction

from flint import arb, arb_mat

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.truth.balls import arb_of, precision
from refdem.truth.exact import numbers
from refdem.truth.growth import bounded
from refdem.truth.maps.iterated import Iterated, Stepped, whole
from refdem.truth.refiner import Size

HALF = Fraction(1, 2)


FLOW_BITS = 1024
"""For S of the equation: what is lost where x comes near to 1 is eta t bits, roughly."""


class LogisticMap(Stepped, Iterated):
    """The truth of the logistic map: the state is y_n = x_n - 1/2, a ball."""

    method = "the map in balls about 1/2, precision raised by the bits that its slope takes away"
    witness = (
        "at eta = 4 x_n = sin^2(2^n asin sqrt(x_0)); exact rational iterates; superstable cycles by"
        " interval Newton"
    )
    word = "iterate"

    def __init__(
        self, eta: Fraction, x0: Fraction, scale: Mapping[str, Size], *, digits: int = 40
    ) -> None:
        self.iterate(scale, digits=digits)
        self.eta = eta
        self.x0 = x0

    def first(self) -> arb:
        return arb_of(self.x0 - HALF)

    def step(self, state: arb) -> arb:
        """y -> eta (1/4 - y^2) - 1/2."""
        return arb_of(self.eta) * (arb_of(HALF * HALF) - state * state) - arb_of(HALF)

    def slope(self, state: arb, after: arb) -> arb_mat:
        """The derivative of a step, -2 eta y."""
        return arb_mat(1, 1, [-2 * arb_of(self.eta) * state])

    def values(self, state: arb) -> dict[str, arb]:
        return {"x_n": state + arb_of(HALF)}


class LogisticFlow(Iterated):
    """The truth of the logistic equation at times n: x(n) = 1/(1 + (1/x0 - 1) exp(-eta n))."""

    method = "closed form: 1/(1 + (1/x0 - 1) exp(-eta t))"
    witness = (
        "Taylor series of x' = eta x (1 - x) with a proven remainder (tests/quadratic_flows.py)"
    )
    word = "iterate"

    def __init__(
        self, eta: Fraction, x0: Fraction, scale: Mapping[str, Size], *, digits: int = 40
    ) -> None:
        self.iterate(scale, digits=digits)
        self.eta = eta
        self.x0 = x0

    def state(self, n: int) -> arb:
        decay = (-arb_of(self.eta) * n).exp()
        # 1/(1 + (1/x0 - 1) e^-eta t), and at x0 = 0 too.
        return arb_of(self.x0) / (arb_of(self.x0) + arb_of(1 - self.x0) * decay)

    def first(self) -> arb:
        return self.state(0)

    def slope(self, state: arb, after: arb) -> arb_mat:
        """d after/d state = e^-eta/(x + (1 - x) e^-eta)^2."""
        decay = (-arb_of(self.eta)).exp()
        denominator = state + (1 - state) * decay
        return arb_mat(1, 1, [decay / (denominator * denominator)])

    def sensitivity(self, t: Fraction) -> float:
        """S(t), over all times s <= t at which an error may be made.

        An error grows from s to t by x (1 - x) at t over that at s, because the rate of x is a
        solution of the variational equation. x is monotone, so that x (1 - x) is smallest at an
        end. At rest, at x = 0 or 1, an error grows as exp(eta (1 - 2 x) t).
        """
        with precision(FLOW_BITS):
            n = whole(t)
            start = self.state(0)
            end = self.state(n)
            first = start * (1 - start)
            last = end * (1 - end)
            # The growth from s to t is x (1 - x) at t over x (1 - x) at s: largest for s = 0, or
            # for s = t, where it is 1, the least S.
            if not first > 0:
                exponent = arb_of(self.eta) * n * (1 - 2 * start)
                return bounded(float(exponent.exp().upper()))
            return bounded(float((last / first).upper()))

    def values(self, state: arb) -> dict[str, arb]:
        return {"x_n": state}


def truth(p: Parameters, scale: Mapping[str, Size]) -> Truth:
    """The map or the differential equation, selected by `form`."""
    parameters = numbers(p, "eta", "x0")
    kind: type[LogisticFlow | LogisticMap] = LogisticMap
    if p["form"] == "ode":
        kind = LogisticFlow
    return kind(parameters["eta"], parameters["x0"], scale)
