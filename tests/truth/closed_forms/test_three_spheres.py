"""A sphere squeezed by two: against Taylor integration of three bodies, each by its own equation, and what must be kept."""

from fractions import Fraction
from functools import cache

from flint import arb

from refdem.cases.impact_benchmarks import member
from refdem.core import discovery
from refdem.truth.balls import arb_of, precision
from refdem.truth.witnesses.taylor import Solution

TINY = Fraction(1, 10**30)


@cache
def found(**given):
    instance = discovery.case("impact-benchmarks").at(member="three-spheres", **given)
    return instance, instance.truth()


def rates(v, t, y):
    """Newton and Euler for bodies 1 (left), 2, 3 in the plane: x, y, vx, vy, spin of each, then the stretch of both springs; sticking."""
    masses, radii = (v.large, v.mass, v.large), (v.partner_radius, v.radius, v.partner_radius)
    force, torque = [[0, 0] for _ in range(3)], [0, 0, 0]
    stretched = []
    for n, (i, j) in enumerate(((0, 1), (1, 2))):
        (xi, yi, ui, vi, wi), (xj, yj, uj, vj, wj) = y[5 * i : 5 * i + 5], y[5 * j : 5 * j + 5]
        dx, dy = xj - xi, yj - yi
        distance = (dx * dx + dy * dy).sqrt()
        nx, ny = dx / distance, dy / distance
        overlap = arb_of(radii[i] + radii[j]) - distance
        closing = (ui - uj) * nx + (vi - vj) * ny
        push = overlap * arb_of(v.stiffness) + closing * arb_of(v.damping)
        arm_i, arm_j = arb_of(radii[i]) - overlap / 2, arb_of(radii[j]) - overlap / 2
        slip = (vi - vj) * nx - (ui - uj) * ny + arm_i * wi + arm_j * wj
        rub = y[15 + n] * -arb_of(v.tangential_stiffness)
        fx, fy = -push * nx - rub * ny, -push * ny + rub * nx
        force[i], force[j] = [force[i][0] + fx, force[i][1] + fy], [force[j][0] - fx, force[j][1] - fy]
        torque[i], torque[j] = torque[i] + arm_i * rub, torque[j] + arm_j * rub
        stretched.append(slip)
    out = []
    for k in range(3):
        m, moment = arb_of(masses[k]), arb_of(Fraction(2, 5) * masses[k] * radii[k] ** 2)
        out += [y[5 * k + 2], y[5 * k + 3], force[k][0] / m, force[k][1] / m, torque[k] / moment]
    return out + stretched


def test_while_all_stick_it_is_the_motion_of_three_bodies():
    instance, truth = found(spin="1", partner_radius="1/50", friction="50")
    v = member("three-spheres").values(instance.p)
    with precision(256):
        reach, o = arb_of(v.radius + v.partner_radius), arb(0)
        along, across = arb_of(v.normal), arb_of(v.across)
        left, right = [-reach, o, along, across, o], [reach, o, -along, -across, o]
        solution = Solution(lambda t, y: rates(v, t, y), [*left, o, o, o, o, arb_of(v.spin), *right, o, o])
        for part in (Fraction(1, 8), Fraction(3, 8)):
            t = Fraction(float(instance.times[-1])) * part
            y, now = solution.at(t), truth.at(t)
            for body, name in ((0, "1"), (1, "2"), (2, "3")):
                seen = [
                    now[f"{kind}.{axis}"].mid for kind, axis in ((f"r{name}", "x"), (f"r{name}", "y"), (f"v{name}", "x"), (f"v{name}", "y"))
                ]
                for value, mid in zip(y[5 * body : 5 * body + 5], [*seen, now[f"omega{name}.z"].mid], strict=True):
                    assert abs(value - arb_of(mid)) < 1e-28


def test_total_angular_momentum_is_kept_where_the_levers_add_up():
    instance, truth = found()
    v = member("three-spheres").values(instance.p)

    def total(t):
        now = {name: ball.mid for name, ball in truth.at(t).items()}
        orbital = sum(v.large * (now[f"r{n}.x"] * now[f"v{n}.y"] - now[f"r{n}.y"] * now[f"v{n}.x"]) for n in (1, 3))
        moments = (v.large * v.partner_radius**2, v.mass * v.radius**2, v.large * v.partner_radius**2)
        return orbital + Fraction(2, 5) * sum(j * now[f"omega{n}.z"] for n, j in zip((1, 2, 3), moments, strict=True))

    first, last = (total(Fraction(float(instance.times[k]))) for k in (1, -1))
    assert abs(first - last) < TINY * 1000


def test_mirror_images_stay_mirror_images_and_the_middle_one_where_it_is():
    instance, truth = found()
    now = {name: ball.mid for name, ball in truth.at(Fraction(float(instance.times[20]))).items()}
    assert all(now[f"{kind}1.{axis}"] == -now[f"{kind}3.{axis}"] for kind in "rv" for axis in "xy")
    assert now["r2.x"] == now["v2.y"] == 0
    assert now["omega2.z"] not in (0, 30)
