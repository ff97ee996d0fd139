"""What REBOUND cannot say is refused by the scene's content, in words."""

import subprocess
import sys

import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.rebound import ENGINE
from refdem.errors import UsageError
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

POINT = Body(mass=1.0, position=(1.0, 0.0, 0.0))
BALL = Body(mass=1.0, inertia=(0.1, 0.1, 0.1), position=(1.0, 0.0, 0.0), shape=Sphere(radius=0.5))
TOP = Body(mass=1.0, inertia=(1.0, 2.0, 3.0), omega=(0.9, 1.1, 1.3))
ROTOR = Body(mass=1.0, inertia=(0.0, 1.0, 1.0), omega=(0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("method", "scene", "words"),
    [
        ("ias15", Scene.of([TOP]), "rotation"),
        ("bs", Scene.of([ROTOR]), "zero"),
        ("ias15", Scene.of([POINT], [Slider(a=0, friction=0.1, normal_force=1.0)]), "dry friction"),
        ("ias15", Scene.of([BALL], [Contact(law="linear", stiffness=10.0)]), "at an edge"),
        ("bs", Scene.of([BALL], [Contact(law="linear", stiffness=10.0)]), "at an edge"),
        (
            "leapfrog",
            Scene.of([BALL], [Contact(law="linear", stiffness=10.0, damping=1.0)]),
            "contact:damping (its force depends on velocities",
        ),
        (
            "leapfrog",
            Scene.of([BALL], [Contact(law="linear", stiffness=10.0, friction=0.5)]),
            "friction between particles",
        ),
        ("leapfrog", Scene.of([BALL], [Contact(law="linear", stiffness=10.0), Plane()]), "walls"),
        ("leapfrog", Scene.of([POINT], [Rod(a=0, length=1.0)]), "depends on velocities"),
        ("whfast", Scene.of([POINT], [Spring(a=0, stiffness=1.0)]), "one attracting centre"),
        ("whfast", Scene.of([POINT]), "one attracting centre"),
        # It would attract them, whatever `gravity` is (deviations/rebound_bounces.py).
        ("whfast", Scene.of([BALL, BALL], [Contact(law="rigid")]), "one attracting centre"),
        (
            "whfast",
            Scene.of([POINT], [CentralField(gm=1.0), Spring(a=0, stiffness=1.0)]),
            "one attracting centre",
        ),
        ("ias15", Scene.of([POINT], [Rod(a=0, length=2.0)]), "differs from the initial"),
        (
            "ias15",
            Scene.of([POINT, TOP], [Rod(a=0, length=1.0), Rod(a=0, b=1, length=1.0)]),
            "share a body",
        ),
        (
            "bs",
            Scene.of([BALL], [Spring(a=0, stiffness=1.0, anchor_a=(0.1, 0.0, 0.0))]),
            "off the centre",
        ),
    ],
)
def test_the_missing_feature_is_named(method: str, scene: Scene, words: str) -> None:
    assert words in (
        ENGINE.unsupported_motion(Motion(scene, np.linspace(0.0, 1.0, 5)), ENGINE.method(method))
        or ""
    )


def test_a_tolerance_that_no_step_can_meet_is_a_usage_error() -> None:
    problem = Motion(Scene.of([POINT], [CentralField(gm=1.0)]), np.linspace(0.0, 1.0, 5))
    with pytest.raises(UsageError, match="no step is accepted"):
        ENGINE.run(Request(problem=problem, method="bs", tolerance=1e-16))


def test_importing_the_adapter_does_not_import_rebound() -> None:
    code = (
        "import sys; from refdem.engines.rebound import ENGINE; ENGINE.version();"
        " sys.exit('rebound' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
