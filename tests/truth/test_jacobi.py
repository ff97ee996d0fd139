"""Jacobi's functions against published values, special values and Arb's own incomplete
integrals.
"""

import pytest
from flint import acb, arb, ctx

from refdem.truth.balls import UndecidedError, precision
from refdem.truth.jacobi import Jacobi, carlson_f


@pytest.fixture(autouse=True)
def _bits():
    with precision(300):
        yield


def jacobi(m: str) -> Jacobi:
    return Jacobi(arb(m), 1 - arb(m))


def test_quarter_period_at_one_half_is_that_of_the_lemniscate():
    # K(m = 1/2) = Gamma(1/4)^2/(4 sqrt pi) (DLMF 19.6.2); digits: OEIS A093341
    k = jacobi("0.5").k
    assert k.overlaps(arb("0.25").gamma() ** 2 / (4 * arb.pi().sqrt()))
    assert abs(k - arb("1.85407467730137191843385034719526004621759882352176690558592804")) < arb(
        "1e-61"
    )
    assert k.rad() < 1e-85


@pytest.mark.parametrize("m", ["0.001", "0.3", "0.9", "0.999999999"])
def test_half_of_the_quarter_period_has_its_algebraic_values(m):
    j = jacobi(m)
    k1 = j.m1.sqrt()
    sn, cn, dn = j.sn_cn_dn(j.k / 2)  # DLMF 22.5.ii
    for value, expected in (
        (sn, 1 / (1 + k1).sqrt()),
        (cn, (k1 / (1 + k1)).sqrt()),
        (dn, k1.sqrt()),
    ):
        assert value.overlaps(expected)
        assert value.rad() < 1e-70


@pytest.mark.parametrize("u", ["0.3", "-2.5", "7.75", "-1234.5"])
def test_amplitude_inverts_the_incomplete_integral_at_any_argument(u):
    j = jacobi("0.7")
    phi = j.amplitude(arb(u))
    assert acb.elliptic_f(acb(phi), acb(j.m)).real.overlaps(arb(u))
    assert phi.sin().overlaps(j.sn_cn_dn(arb(u))[0])


@pytest.mark.parametrize("u", ["0.3", "-0.9", "2.5", "-3.5", "4.1"])
def test_argument_is_found_from_sn_and_cn_in_every_quadrant(u):
    j = jacobi("0.7")
    sn, cn, _ = j.sn_cn_dn(arb(u))
    assert j.argument(sn, cn).overlaps(arb(u))


def test_zeta_on_the_imaginary_axis_is_that_of_the_incomplete_second_integral():
    j = jacobi("0.6")
    phi = acb(0, 1) * arb("0.8")
    u = acb.elliptic_f(phi, acb(j.m))
    zeta = (
        acb.elliptic_e_inc(phi, acb(j.m)) - acb(j.m).elliptic_e() / acb(j.m).elliptic_k() * u
    )  # DLMF 22.16.32
    assert u.real.contains(0)
    assert j.zeta_on_imaginary_axis(u.imag).overlaps(zeta.imag)


def test_nothing_is_lost_next_to_the_separatrix():
    j = Jacobi(1 - arb("1e-60"), arb("1e-60"))
    assert abs(j.k - (4 * arb("1e30")).log()) < arb("1e-58")  # DLMF 19.12.1
    assert j.sn_cn_dn(arb(1))[0].overlaps(arb(1).tanh() + arb(0, 1e-60))


@pytest.mark.parametrize("m", ["0", "1", "-0.5", "1.5"])
def test_parameters_outside_the_open_interval_are_undecided(m):
    with pytest.raises(UndecidedError):
        jacobi(m)


def test_carlson_f_of_equal_arguments_is_an_inverse_root():
    assert carlson_f(arb(3), arb(3), arb(3)).overlaps(1 / arb(3).sqrt())
    assert ctx.prec == 300
