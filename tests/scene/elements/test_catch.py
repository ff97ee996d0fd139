"""The hook: features, refusals, and that it keeps energy and angular momentum about itself."""

import pytest

from refdem.core.balance import torque_reason
from refdem.errors import SceneError
from refdem.scene import Body, Scene
from refdem.scene.elements.catch import Catch

MASS = Body(mass=1.0, position=(0.0, 1.0, 0.0))


def test_a_hook_at_the_origin_keeps_angular_momentum_and_energy_but_not_momentum():
    scene = Scene.of([MASS], [Catch(a=0, radius=1.0)])
    assert torque_reason(scene) is None
    assert scene.is_conservative()
    assert not scene.is_isolated()
    assert "catch" in str(
        torque_reason(Scene.of([MASS], [Catch(a=0, radius=1.0, anchor_b=(1.0, 0.0, 0.0))]))
    )
    assert Scene.of([MASS, MASS], [Catch(a=0, b=1, radius=1.0)]).is_isolated()


def test_a_hook_without_reach_is_refused():
    with pytest.raises(SceneError, match="radius is 0"):
        Scene.of([MASS], [Catch(a=0, radius=0.0)])
