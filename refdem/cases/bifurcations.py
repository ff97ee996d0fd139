"""Where the number of answers changes: folds of a resonance by harmonic balance (1.120), (1.121),
and doublings of the period of the logistic map (1.127).
"""

from types import MappingProxyType

import numpy as np

from refdem.cases._algebra import AlgebraCase, Row
from refdem.core.parameters import Parameter, Parameters
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.mechanics.response import balanced_drives, folds


class Bifurcations(AlgebraCase):
    """A driven oscillator with a hardening spring, x'' + 2 delta x' + alpha x + beta x^3 = f0 cos(w
    t), as harmonic balance has it; and the map x -> eta x (1 - x).
    """

    units = MappingProxyType(
        {
            "drives.0": "rad/s",
            "drives.1": "rad/s",
            "forces.0": "m/s^2",
            "forces.1": "m/s^2",
            "lower-fold.0": "rad/s",
            "lower-fold.1": "m",
            "upper-fold.0": "rad/s",
            "upper-fold.1": "m",
        }
    )
    id = "bifurcations"
    title = "Folds and doublings"
    words = ("nonlinear", "resonance", "hysteresis", "chaos", "feigenbaum")
    motion = "formula"
    statement = (
        "Harmonic balance keeps only the terms at the frequency of the drive. One amplitude then"
        " belongs to two frequencies, and between its folds one frequency to three amplitudes: a"
        " drive that is raised slowly falls off the upper fold, one that is lowered jumps at the"
        " lower. A spring that hardens leans the resonance to higher drives, one that softens to"
        " lower ones. The logistic map settles on one value up to eta = 3, alternates between two"
        " up to 1 + sqrt 6, and between four up to 3.5440903596. All are roots of polynomials. At"
        " eta = 4 its values are continuous and not uniform: a third of them is below 1/4."
    )
    latex = (
        r"f_0^2=A^2\left((k-\omega^2)^2+4\delta^2\omega^2\right),\;"
        r"k=\alpha+\tfrac34\beta A^2;\qquad x_{n+1}=\eta\,x_n(1-x_n)"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.120), (1.121), figs. 1.23 and 1.24; (1.127), fig."
        " 1.32; May 1976 for the cycle of two"
    )
    parameters = (
        Parameter(
            name="amplitude", default="2", unit="m", doc="A, whose drives are asked for", above=0
        ),
        Parameter(
            name="alpha",
            default="1",
            unit="1/s^2",
            doc="linear part of the spring per mass",
            above=0,
        ),
        Parameter(
            name="beta",
            default="2/5",
            unit="1/(m^2 s^2)",
            doc="cubic part of the spring per mass, below 0 for one that softens",
        ),
        Parameter(
            name="delta",
            default="1/10",
            unit="1/s",
            doc="damping: half the dashpot per mass",
            above=0,
        ),
        Parameter(
            name="f0", default="3/2", unit="m/s^2", doc="amplitude of the force per mass", above=0
        ),
        Parameter(
            name="eta",
            default="16/5",
            unit="1",
            doc="of the map, for its cycle of two",
            above=3,
            at_most=4,
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for an amplitude that fewer than two drives have, without a cube, and
        without folds.
        """
        if p.beta == 0:
            raise UsageError("parameter beta: got 0; expected a spring that is not linear")
        drives = np.array(balanced_drives(p.amplitude, p.alpha, p.beta, p.delta, p.f0))
        if not np.all(np.isfinite(drives)) or not drives[0] < drives[1]:
            raise UsageError(
                f"parameter amplitude: got {p.amplitude:g}; expected one that harmonic balance has"
                " at two drive frequencies"
            )
        if folds(p.alpha, p.beta, p.delta, p.f0) is None:
            raise UsageError(
                f"parameter delta: got {p.delta:g}; expected so little damping that the resonance"
                " folds, and of a spring that softens so much that it closes"
            )

    def rows(self, p: Parameters) -> list[Row]:
        """Drives of an amplitude and the force that they need, both folds, cycles of the map, and
        where its values are in its chaos.
        """
        spring = [p.alpha, p.beta, p.delta]
        force = [p.f0]
        amplitude = [p.amplitude]
        return [
            ("drives", "balanced-drives", [amplitude, spring, force]),
            ("forces", "balanced-forces", [amplitude, spring, "drives"]),
            ("lower-fold", "lower-fold", [spring, force]),
            ("upper-fold", "upper-fold", [spring, force]),
            ("two-cycle", "two-cycle", [[p.eta]]),
            ("doubling-of-1", "doubling-point", [[0.0]]),
            ("doubling-of-2", "doubling-point", [[1.0]]),
            ("doubling-of-4", "doubling-point", [[2.0]]),
            ("below-quarter", "share-below", [[0.25]]),
            ("below-half", "share-below", [[0.5]]),
            ("below-three-quarters", "share-below", [[0.75]]),
        ]

    def sizes(self, p: Parameters) -> dict[str, float]:
        """The magnitudes of the numbers, times what multiplies a rounding on the way to them."""
        drive, force = _sizes_of_balance(p)
        eta = float(p.eta)
        root = np.sqrt((eta - 3) * (eta + 1))
        return {
            "drives": drive,
            "forces": force,
            **_sizes_of_folds(p),
            # The root of what is small next to eta = 3 magnifies a rounding of eta.
            "two-cycle": float(1 + 1 / root),
            "doubling-of-1": 4.0,
            "doubling-of-2": 4.0,
            "doubling-of-4": 4.0,
        }

    def truth(self, p: Parameters) -> Truth:
        """Roots of polynomials with rational coefficients, each proved to be the one meant."""
        from refdem.truth.closed_forms.bifurcations import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


def _sizes_of_balance(p: Parameters) -> tuple[float, float]:
    """The sizes of the drives of an amplitude A, and of the forces that these need.

    Roundings of k and of the discriminant R^2 = f0^2/A^2 - 4 delta^2 (k - delta^2) move w^2 = k - 2
    delta^2 -+ R by up to u (k + (f0^2/A^2 + 4 delta^2 k)/R), and f0 by A times that.
    """
    stiffness = p.alpha + 0.75 * p.beta * p.amplitude**2
    square = (p.f0 / p.amplitude) ** 2
    discriminant = square - 4 * p.delta**2 * (stiffness - p.delta**2)
    # A spring that softens has a small k that is the difference of two larger terms.
    terms = p.alpha + 0.75 * abs(p.beta) * p.amplitude**2
    moved = terms + (square + 4 * p.delta**2 * terms) / np.sqrt(discriminant)
    lower, higher = balanced_drives(p.amplitude, p.alpha, p.beta, p.delta, p.f0)
    drive = float(higher + moved / lower)
    return drive, float(p.f0 + 2 * p.amplitude * moved)


def _sizes_of_folds(p: Parameters) -> dict[str, float]:
    """The sizes of drive and amplitude at both folds: by how much a rounding of the terms moves S =
    A^2, and with it the two.
    """
    found = folds(p.alpha, p.beta, p.delta, p.f0)
    assert found is not None
    h = 0.75 * p.beta
    square = p.f0**2
    sizes = {}
    for side, (drive, amplitude) in zip(found._fields, found, strict=True):
        s = amplitude**2
        terms = np.array(
            [
                16 * p.delta**2 * h**3 * s**2,
                16 * p.delta**2 * h**2 * p.alpha * s,
                8 * p.delta**2 * h * square / s,
                square**2 / s**3,
            ]
        )
        powers = np.array([2, 1, -1, -3])
        # The part of S by which a relative rounding of the terms moves it: large where the folds
        # are about to meet. Each term has some four roundings.
        magnified = max(1.0, 4 * float(np.sum(abs(terms)) / abs(powers @ terms)))
        of_square = p.alpha + abs(h) * s + square / (abs(h) * s**2)
        sizes[f"{side}-fold.0"] = (drive + of_square / drive) * magnified
        sizes[f"{side}-fold.1"] = amplitude * magnified
    return sizes


CASE = Bifurcations()
