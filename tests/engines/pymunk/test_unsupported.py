"""What pymunk cannot say is refused by the scene's content, in words."""

import numpy as np
import pytest

from refdem.core.problem import Motion
from refdem.engines.pymunk import ENGINE
from refdem.scene import Body, Scene, Sphere, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.uniform_gravity import UniformGravity

BALL = Body(mass=1.0, inertia=(0.1, 0.1, 0.1), position=(1.0, 0.0, 0.0), shape=Sphere(radius=0.5))
POINT = Body(mass=1.0, position=(1.0, 0.0, 0.0))
SLOPED = Body(mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.0))
TOP = Body(mass=1.0, inertia=(1.0, 2.0, 3.0), omega=(0.9, 1.1, 1.3))
BLOCK = Body(mass=1.0, inertia=(1.0, 1.0, 1.0), position=(0.0, 0.0, 0.5), shape=box(1.0, 1.0, 1.0))
FLAT = Body(mass=1.0, position=(0.0, 0.5, 0.0), shape=box(1.0, 1.0, 1.0))


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (Scene.of([TOP]), "three dimensions"),
        (
            Scene.of([BLOCK], [Plane(), UniformGravity(g=(0.0, 0.0, -9.8)), Contact(law="rigid")]),
            "three dimensions",
        ),
        (
            Scene.of([BALL], [Contact(law="linear", stiffness=10.0, friction=0.5)]),
            "friction of a contact that has a stiffness",
        ),
        (
            Scene.of([POINT, BALL], [Dashpot(a=0, b=1, damping=1.0)]),
            "resists in all directions",
        ),
        (
            Scene.of([SLOPED], [Slider(a=0, friction=0.1, normal_force=1.0)]),
            "dry friction along one axis",
        ),
        (
            Scene.of([FLAT], [Contact(law="rigid"), Plane(normal=(0.0, 1.0, 0.0))]),
            "moment of inertia",
        ),
    ],
)
def test_the_missing_feature_is_named(scene: Scene, words: str) -> None:
    assert words in (
        ENGINE.unsupported_motion(Motion(scene, np.linspace(0.0, 1.0, 5)), ENGINE.methods[0]) or ""
    )


def test_time_does_not_run_backwards() -> None:
    assert "negative" in (
        ENGINE.unsupported_motion(
            Motion(Scene.of([POINT]), -np.linspace(0.0, 1.0, 5)), ENGINE.methods[0]
        )
        or ""
    )


def test_importing_the_adapter_does_not_import_pymunk() -> None:
    import subprocess
    import sys

    code = (
        "import sys; from refdem.engines.pymunk import ENGINE; ENGINE.version(); sys.exit('pymunk'"
        " in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
