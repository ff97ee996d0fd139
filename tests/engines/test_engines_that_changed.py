"""An engine that is built in another way than its adapter knows, or that loses count, is an error
and not a motion.
"""

import ctypes

import mujoco
import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.mujoco import loop
from refdem.engines.pymunk import ENGINE as PYMUNK
from refdem.engines.pymunk import run as pymunk_run
from refdem.errors import EngineError
from refdem.scene import Body, Scene

FLIGHT = Motion(Scene.of([Body(mass=1.0, velocity=(1.0, 0.0, 0.0))]), np.array([0.0, 0.5, 1.0]))


class Changed:
    """A library as it is, but for the functions named."""

    def __init__(self, library, **functions):
        self._library = library
        self.__dict__.update(functions)

    def __getattr__(self, name):
        return getattr(self._library, name)


def fly():
    """A free flight in pymunk, eight steps."""
    return PYMUNK.run(Request(problem=FLIGHT, method=PYMUNK.methods[0].name, step=1 / 8))


def test_pymunk_that_lost_a_step_is_an_error(monkeypatch):
    lossy = Changed(pymunk_run.engine_lib, cpSpaceGetTimestamp=lambda space: 7)
    monkeypatch.setattr(pymunk_run, "_engine", _made_before(pymunk_run._engine, monkeypatch, lossy))
    with pytest.raises(EngineError, match="counted 7 steps; expected 8"):
        fly()


def _made_before(engine, monkeypatch, lossy):
    """Addresses are taken from the library itself; only then is it the one that lost count."""

    def made(*arguments, **options):
        addresses = engine(*arguments, **options)
        monkeypatch.setattr(pymunk_run, "engine_lib", lossy)
        return addresses

    return made


@pytest.mark.parametrize(("name", "other"), [("cpFloat", 4), ("cpVect", 12)])
def test_pymunk_with_other_numbers_than_doubles_is_an_error(monkeypatch, name, other):
    real = pymunk_run.engine_ffi
    narrow = Changed(real, sizeof=lambda kind: other if kind == name else real.sizeof(kind))
    monkeypatch.setattr(pymunk_run, "engine_ffi", narrow)
    with pytest.raises(EngineError, match="cpFloat has"):
        fly()


def test_mujoco_without_its_library_is_an_error(monkeypatch, tmp_path):
    monkeypatch.setattr(mujoco, "__file__", str(tmp_path / "__init__.py"))
    with pytest.raises(EngineError, match="no libmujoco beside"):
        loop._step_address.__wrapped__()


def test_mujoco_with_its_clock_elsewhere_is_an_error():
    class Moved:
        """Data whose energy does not stand behind the time."""

        def __init__(self):
            self.room = np.zeros(4)
            self.energy = self.room[2:]
            self.time = 0.25

    data = Moved()
    with pytest.raises(EngineError, match="time does not stand before"):
        loop.clock_address(data)
    assert data.time == 0.25


def test_the_clock_of_mujoco_is_found_and_left_as_it_was():
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    data = mujoco.MjData(model)
    data.time = 0.75
    address = loop.clock_address(data)
    assert ctypes.c_double.from_address(address).value == 0.75
