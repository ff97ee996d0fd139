"""Bodies in a file of their own, `bodies.npz`: what a scene's JSON refers to where it has too many
bodies to list them.

The file is NumPy's archive without pickles: mass (N,), inertia, position, velocity, omega (N, 3),
attitude (N, 4), float64; fixed (N,), bool; shape (N,), int64, numbers of the shapes (bytes of JSON,
a list of shapes).
"""

import hashlib
import io
import zipfile
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.errors import UNREADABLE, SceneError
from refdem.scene.bodies import COLUMNS, Bodies
from refdem.scene.shapes import Shape

NAME = "bodies.npz"
MOST_LISTED = 10_000
"""Bodies that JSON lists one by one, at most."""
WIDTH = {"mass": 1, "inertia": 3, "position": 3, "velocity": 3, "attitude": 4, "omega": 3}
HEADER = 4096
"""Bytes by which a column in the file may be longer than its numbers."""
MOST_SHAPES = 1 << 26
"""Bytes of the list of shapes, at most."""


class BodiesFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A reference to a file of bodies beside the JSON: its name, how many bodies it has, and the
    sha256 of their content.
    """

    file: str
    count: int
    sha256: str


def reference(bodies: Bodies) -> BodiesFile:
    """The reference to the file that JSON has in the place of the bodies."""
    return BodiesFile(file=NAME, count=len(bodies), sha256=content(bodies))


def content(bodies: Bodies) -> str:
    """sha256 of the names, types, shapes and numbers of all columns, independent of the archive."""
    digest = hashlib.sha256()
    for name, column in _columns(bodies).items():
        digest.update(f"{name}\0{column.dtype.str}\0{column.shape}\0".encode() + column.tobytes())
    return digest.hexdigest()


def packed(bodies: Bodies) -> bytes:
    """The bytes of the file, which hold every array of the bodies."""
    archive = io.BytesIO()
    np.savez(archive, allow_pickle=False, **_columns(bodies))
    return archive.getvalue()


def unpacked(data: bytes | Path, reference: BodiesFile) -> Bodies:
    """The bodies in a file, or in its bytes, to which a scene has the reference `reference`.

    Raises SceneError if the content is another one, or that of unphysical bodies.
    """
    where = f"scene.bodies: {reference.file}"
    if reference.count < 1:
        raise SceneError(f"scene.bodies.count is {reference.count}; expected at least 1")
    try:
        columns = _read(data, reference.count, where)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise SceneError(f"{where} cannot be read: {error}") from None
    shapes = _shapes(columns.pop("shapes"), where)
    number = columns.pop("shape")
    fixed = columns.pop("fixed")
    if len(number) and not 0 <= number.min() <= number.max() < len(shapes):
        raise SceneError(
            f"{where}: shape has numbers from {number.min()} to {number.max()}; expected"
            f" 0..{len(shapes) - 1}"
        )
    bodies = Bodies(shape=tuple(map(shapes.__getitem__, number.tolist())), fixed=fixed, **columns)
    if content(bodies) != reference.sha256:
        raise SceneError(
            f"{where} has other content than the scene was written with: its sha256 is"
            f" {content(bodies)}, not {reference.sha256}"
        )
    return bodies


def _columns(bodies: Bodies) -> dict[str, NDArray[Any]]:
    """Every array of the file by name, in the byte order of the file."""
    # Equal shapes are written once; each body has the number of its shape in that list.
    shapes: dict[Shape, int] = {}
    number_in_list = [shapes.setdefault(shape, len(shapes)) for shape in bodies.shapes]
    number = np.array(number_in_list, "<i8")[bodies.shape_number]
    columns: dict[str, NDArray[Any]] = {
        name: np.ascontiguousarray(getattr(bodies, name), "<f8") for name in COLUMNS
    }
    listed = np.frombuffer(msgspec.json.encode(list(shapes)), np.uint8)
    return columns | {
        "fixed": np.ascontiguousarray(bodies.fixed, bool),
        "shape": number,
        "shapes": listed,
    }


def _array_types(count: int) -> dict[str, tuple[str, tuple[int, ...]]]:
    """The numpy type and the shape of every array for `count` bodies; () allows any length."""
    types: dict[str, tuple[str, tuple[int, ...]]] = {}
    for name, width in WIDTH.items():
        shape: tuple[int, ...] = (count,)
        if width > 1:
            shape = (count, width)
        types[name] = ("<f8", shape)
    return types | {
        "fixed": ("|b1", (count,)),
        "shape": ("<i8", (count,)),
        "shapes": ("|u1", ()),
    }


def _read(data: bytes | Path, count: int, where: str) -> dict[str, NDArray[Any]]:
    """The arrays of the file, each of the type and shape that `count` bodies need.

    Raises SceneError for any other. Sizes are checked before anything is read, so that a damaged
    archive cannot fill the memory.
    """
    types = _array_types(count)
    if isinstance(data, bytes):
        source: Any = io.BytesIO(data)
    else:
        source = data
    with zipfile.ZipFile(source) as archive:
        sizes = {info.filename.removesuffix(".npy"): info.file_size for info in archive.infolist()}
    if sizes.keys() != types.keys():
        names = ", ".join(sorted(sizes)) or "nothing"
        expected = ", ".join(sorted(types))
        raise SceneError(f"{where} has {names}; expected {expected}")
    for name, (dtype, shape) in types.items():
        content = MOST_SHAPES
        if shape:
            content = int(np.prod(shape)) * np.dtype(dtype).itemsize
        limit = HEADER + content
        if sizes[name] > limit:
            raise SceneError(
                f"{where}: {name} has {sizes[name]} bytes; expected at most {limit} for {count}"
                " bodies"
            )
    columns: dict[str, NDArray[Any]] = {}
    with np.load(source, allow_pickle=False) as archive:
        for name, (dtype, shape) in types.items():
            column = archive[name]
            if shape:
                has_shape = column.shape == shape
            else:
                has_shape = column.ndim == 1
            if column.dtype.str != dtype or not has_shape:
                raise SceneError(
                    f"{where}: {name} is {column.dtype.str} {column.shape}; expected {dtype}"
                    f" {shape or '(bytes,)'}"
                )
            columns[name] = column
    return columns


def _shapes(listed: NDArray[Any], where: str) -> list[Shape]:
    """The shapes, from JSON; raises SceneError with the path of the first fault."""
    try:
        return msgspec.json.decode(listed.tobytes(), type=list[Shape])
    except UNREADABLE as error:
        raise SceneError(f"{where}: shapes: {error}") from None
