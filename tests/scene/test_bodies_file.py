"""Scenes of more bodies than JSON lists: their file holds them to the last bit, and nothing else is
taken for it.
"""

import io
import pickle

import msgspec
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.errors import SceneError
from refdem.planning.exchange import written
from refdem.scene import Bodies, Point, Scene, Sphere, bodies_file, box
from refdem.scene.elements.uniform_gravity import UniformGravity

N = bodies_file.MOST_LISTED + 1


def scene(n=N, seed=1):
    rng = np.random.default_rng(seed)
    attitude = rng.normal(size=(n, 4))
    columns = {name: rng.normal(size=(n, 3)) for name in ("position", "velocity", "omega")}
    columns["attitude"] = attitude / np.linalg.norm(attitude, axis=1, keepdims=True)
    shapes = (Point(), Sphere(radius=0.5), box(1.0, 2.0, 3.0), Sphere(radius=0.25))
    shape = tuple(shapes[k] for k in rng.integers(0, 4, n))
    bodies = Bodies(
        mass=rng.uniform(1, 2, n),
        inertia=np.ones((n, 3)),
        shape=shape,
        fixed=rng.random(n) < 0.1,
        **columns,
    )
    return Scene(bodies, (UniformGravity(g=(0.0, 0.0, -1.0)),))


SCENE = scene()


def request(of=SCENE):
    return Request(problem=Motion(of, np.array([0.0, 1.0])), method="m", step=0.5)


def same(one, other):
    assert all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in (*bodies_file.WIDTH, "fixed", "radius")
    )
    assert one.shape == other.shape


def test_a_request_of_many_bodies_travels_with_their_file_and_stays_small():
    asked = request()
    assert len(asked.to_json()) < 1000
    assert msgspec.json.decode(asked.to_json())["scene"]["bodies"]["count"] == N
    again = Request.unpacked(asked.packed())
    same(asked.problem.scene.bodies, again.problem.scene.bodies)
    assert again.problem.scene.elements == SCENE.elements
    assert again.key() == asked.key()
    assert asked.packed() != asked.to_json()


def test_a_scene_of_few_bodies_lists_them():
    few = request(scene(10))
    assert few.bodies_file is None
    assert few.packed() == few.to_json()
    assert b'"mass"' in few.to_json()
    same(few.problem.scene.bodies, Request.unpacked(few.packed()).problem.scene.bodies)


@pytest.mark.parametrize("name", [*bodies_file.WIDTH, "fixed", "shape"])
def test_the_key_is_of_all_that_the_file_holds(name):
    bodies = SCENE.bodies
    if name == "shape":
        changed = {"shape": (Sphere(radius=0.375), *bodies.shape[1:])}
    elif name == "fixed":
        changed = {"fixed": np.roll(bodies.fixed, 1)}
    elif name == "attitude":
        changed = {"attitude": np.roll(bodies.attitude, 1, axis=0)}
    else:
        changed = {name: getattr(bodies, name).copy()}
        changed[name][-1] = np.nextafter(changed[name][-1], 0)
    columns = {n: getattr(bodies, n) for n in (*bodies_file.WIDTH, "fixed", "shape")} | changed
    assert request(Scene(Bodies(**columns), SCENE.elements)).key() != request().key()


def archive(**changed):
    """A file of the scene's bodies with some arrays replaced, or left out if they are None."""
    with np.load(io.BytesIO(bodies_file.packed(SCENE.bodies))) as read:
        held = {**read, **changed}
    found = io.BytesIO()
    np.savez(found, **{name: array for name, array in held.items() if array is not None})
    return found.getvalue()


class Trap:
    def __reduce__(self):
        return (pytest.fail, ("a pickle was run",))


ROWS = np.zeros((N, 3))
BAD = {
    "no archive": (lambda: b"{}", "cannot be read"),
    "cut short": (lambda: archive()[:-5000], "cannot be read"),
    "a pickle": (lambda: archive(mass=np.array([Trap()] * N, object)), "allow_pickle"),
    "a pickle alone": (lambda: pickle.dumps(Trap()), "cannot be read"),
    "a column too few": (lambda: archive(omega=None), "expected attitude, fixed"),
    "a column too many": (lambda: archive(colour=ROWS), "colour"),
    "single precision": (lambda: archive(position=ROWS.astype("f4")), "expected <f8"),
    "other byte order": (lambda: archive(position=ROWS.astype(">f8")), "expected <f8"),
    "a row too few": (lambda: archive(velocity=ROWS[1:]), "velocity is"),
    "far too long": (lambda: archive(velocity=np.zeros((2 * N, 3))), "at most"),
    "a shape that is not listed": (lambda: archive(shape=np.full(N, 4)), "expected 0..3"),
    "a shape below the first": (lambda: archive(shape=np.full(N, -1)), "expected 0..3"),
    "shapes of another kind": (
        lambda: archive(shapes=np.frombuffer(b'[{"kind":"cube"}]', np.uint8)),
        "shapes: ",
    ),
    "not a number": (lambda: archive(position=np.full((N, 3), np.nan)), "finite"),
    "no mass": (lambda: archive(mass=np.zeros(N)), "mass"),
    "other content": (lambda: archive(position=ROWS), "sha256"),
}


@pytest.mark.parametrize("name", list(BAD))
def test_a_file_that_is_not_the_scenes_is_refused(name):
    made, told = BAD[name]
    with pytest.raises(SceneError, match=told):
        bodies_file.unpacked(made(), bodies_file.reference(SCENE.bodies))


def test_a_scene_without_the_file_that_it_names_is_refused():
    with pytest.raises(SceneError, match=r"bodies.npz, which was not supplied"):
        Scene.from_json(SCENE.to_json())
    with pytest.raises(SceneError, match="count is 0"):
        bodies_file.unpacked(b"", bodies_file.BodiesFile(file="bodies.npz", count=0, sha256=""))


def test_a_scene_is_read_with_its_file_beside_it(tmp_path):
    (tmp_path / "bodies.npz").write_bytes(bodies_file.packed(SCENE.bodies))
    same(SCENE.bodies, Scene.from_json(SCENE.to_json(), tmp_path / "bodies.npz").bodies)


TOML = """
[engine]
name = "many"
command = ["true"]
supports = ["uniform_gravity", "rotation", "tumbling", "fixed"{more}]
[[engine.methods]]
name = "m"
order = 2
"""


@pytest.mark.parametrize(
    ("more", "refused"),
    [("", "bodies_file (not in `supports` of refdem.toml)"), (', "bodies_file"', None)],
)
def test_a_program_gets_the_file_if_it_says_that_it_reads_it(tmp_path, more, refused):
    (tmp_path / "refdem.toml").write_text(TOML.format(more=more))
    engine = discovery.engine(str(tmp_path / "refdem.toml"))
    asked = request()
    assert engine.unsupported_motion(asked.problem, engine.methods[0]) == refused
    assert engine.unsupported_motion(request(scene(10)).problem, engine.methods[0]) is None
    written(asked, tmp_path)
    same(SCENE.bodies, Scene.from_json(SCENE.to_json(), tmp_path / "bodies.npz").bodies)
    assert f"scene.bodies.count {N}\nscene.bodies" in (tmp_path / "request.txt").read_text()
    assert "scene.bodies.file bodies.npz" in (tmp_path / "request.txt").read_text()
