"""MuJoCo: free bodies with sphere geometries between six planes, `mj_step` in its own loop."""

from importlib.util import find_spec
from time import perf_counter

from refdem.bench.crowds._crowd import Crowd, Gas
from refdem.scene.elements.plane import Plane

OFF = ("GRAVITY", "LIMIT", "EQUALITY", "FRICTIONLOSS", "ACTUATION", "SENSOR", "PASSIVE")
SOLREF = (0.02, 1.0)
TURN: dict[tuple[float, ...], str] = {
    (1, 0, 0): "0 90 0",
    (-1, 0, 0): "0 -90 0",
    (0, 1, 0): "-90 0 0",
    (0, -1, 0): "90 0 0",
    (0, 0, 1): "0 0 0",
    (0, 0, -1): "180 0 0",
}


class Mujoco(Crowd):
    """A gas in MuJoCo's own soft contacts, with the cheapest settings for so many bodies: conjugate
    gradients and a sparse Jacobian.
    """

    name = "MuJoCo"
    note = "its own soft contacts"

    def missing(self) -> str | None:
        """None if the package is installed, else what to install."""
        if find_spec("mujoco"):
            return None
        return "install refdem[mujoco]"

    def unsupported(self, gas: Gas) -> str | None:
        """None for a gas between walls, else why it cannot be moved."""
        if gas.periodic:
            return "no periodic box"
        return None

    def seconds(self, gas: Gas, steps: int) -> float:
        """The time of `mj_step` with its own count of steps, after one that is not counted."""
        import mujoco

        model = mujoco.MjModel.from_xml_string(_document(gas))
        data = mujoco.MjData(model)
        data.qvel.reshape(-1, 6)[:, :3] = gas.velocity
        mujoco.mj_step(model, data)
        began = perf_counter()
        mujoco.mj_step(model, data, nstep=steps)
        return perf_counter() - began


def _document(gas: Gas) -> str:
    """MJCF of the gas; with friction contacts have two tangential directions."""
    rubs = gas.law.friction > 0
    flags = " ".join(f'{name.lower()}="disable"' for name in OFF if name != "PASSIVE")
    if rubs:
        condim = 3
    else:
        condim = 1
    shape = (
        f'<geom size="{gas.diameter / 2!r}" mass="{gas.mass!r}" condim="{condim}"'
        f' friction="{gas.law.friction or 1!r} 0 0"/>'
    )
    spheres = ""
    for x, y, z in gas.position.tolist():
        spheres += f'<body pos="{x!r} {y!r} {z!r}"><freejoint/>{shape}</body>'
    walls = ""
    for plane in gas.instance.scene.all(Plane):
        x, y, z = plane.point
        walls += (
            f'<geom type="plane" size="0 0 1" condim="1" pos="{x!r} {y!r} {z!r}"'
            f' euler="{TURN[plane.normal]}"/>'
        )
    option = (
        f'<option timestep="{gas.step!r}" solver="CG" jacobian="sparse"><flag {flags}/></option>'
    )
    return f'<mujoco>{option}<size memory="2G"/><worldbody>{walls}{spheres}</worldbody></mujoco>'


CROWD = Mujoco()
