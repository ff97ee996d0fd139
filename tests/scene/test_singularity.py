"""The exponent of the sharpest singularity decides what fixed steps can have across all of them."""

import math

from refdem.scene.singularity import JUMP, KINK, SQUARE, Singularity, sharpest_exponent


def test_the_sharpest_of_singularities_has_the_smallest_exponent() -> None:
    exponents = (SQUARE, JUMP, KINK)
    singularities = [Singularity(exponent, "contact") for exponent in exponents]
    assert sharpest_exponent(singularities) == JUMP


def test_the_sharpest_exponent_of_a_smooth_force_is_infinite() -> None:
    assert sharpest_exponent([]) == math.inf
