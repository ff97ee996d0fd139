"""A tangential spring that stiffens with the load: the exact method, methods that step, and what
they refuse.
"""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.faults.transparent import Transparent
from refdem.scene import Scene
from refdem.scene.elements.contact import Contact
from refdem.solvers._mindlin_spring import Spring, course

REFERENCE = discovery.engine("reference")


def seen(instance, method, step=None):
    return instance.observe(
        REFERENCE.run(Request(problem=instance.problem, method=method, step=step))[0]
    )


@pytest.mark.parametrize("angle", ["1/4", "-0.05"])
@pytest.mark.parametrize(("method", "order"), [("velocity-verlet", 2.0), ("rk4", 2.5)])
def test_methods_that_step_converge_to_the_exact_one(method, order, angle):
    instance = discovery.case("impact-benchmarks").at(member="dem-05-mindlin", angle=angle)
    exact = seen(instance, "exact-hertz-wall")
    coarse, fine = (
        max(
            np.abs(seen(instance, method, instance.problem.interval / n)[name] - exact[name]).max()
            for name in ("v.y", "r.y")
        )
        for n in (4, 32)
    )
    assert np.log2(coarse / fine) / 3 == pytest.approx(order, abs=0.3)


@pytest.mark.parametrize("slip", [0.02, 0.3, 3.0])
def test_a_clipped_spring_never_passes_its_limit_and_slip_times_seven_halves_is_the_impulse(slip):
    spring = Spring(ratio=1.3, friction=0.1)
    found = course(spring, slip)
    modes = [found.at(max(0.0, 1 - u * u) ** 0.4, u) for u in np.linspace(1, -1, 101)]
    assert np.all(np.abs(np.diff([p for p, _ in modes])) <= 3.5 * 0.1 * 0.02 * (1 + 1e-9))
    assert found.end()[0] == pytest.approx(modes[-1][0], abs=1e-12)


def test_a_law_of_hertz_with_a_spring_is_named_and_its_stiffness_has_its_own_unit():
    law = Contact(law="hertz", stiffness=1.0, tangential_stiffness=1.0, friction=0.1)
    assert "contact:mindlin" in law.features()
    assert "contact:mindlin" not in Contact(law="hertz", stiffness=1.0, friction=0.1).features()
    assert law.dimension("tangential_stiffness") == law.dimension("stiffness")


def test_the_engine_that_carries_faults_does_not_pretend_to_have_it():
    transparent = Transparent()
    problem = discovery.case("impact-benchmarks").at(member="dem-05-mindlin").problem
    without = Motion(
        Scene(problem.scene.bodies, tuple(_without(e) for e in problem.scene.elements)),
        problem.times,
    )
    told = {transparent.unsupported(problem, method) for method in transparent.methods}
    assert told == {
        "the transparent engine has no tangential spring under Hertz's law",
        "the method differentiates impacts without friction only",
        "cannot run a motion",
    }
    assert any(transparent.unsupported(without, method) is None for method in transparent.methods)


def _without(element):
    if isinstance(element, Contact):
        return Contact(law="hertz", stiffness=element.stiffness, branch="R")
    return element
