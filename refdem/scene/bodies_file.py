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
    """What JSON says in the place of the bodies."""
    return BodiesFile(file=NAME, count=len(bodies), sha256=content(bodies))


def content(bodies: Bodies) -> str:
    """sha256 of every column, whatever the file looks like that holds them."""
    digest = hashlib.sha256()
    for name, column in _columns(bodies).items():
        digest.update(f"{name}\0{column.dtype.str}\0{column.shape}\0".encode() + column.tobytes())
    return digest.hexdigest()


def packed(bodies: Bodies) -> bytes:
    """The bytes of the file, which hold every array of the bodies."""
    held = io.BytesIO()
    np.savez(held, allow_pickle=False, **_columns(bodies))
    return held.getvalue()


def unpacked(data: bytes | Path, told: BodiesFile) -> Bodies:
    """The bodies of a file; raises SceneError if it is not what the reference says, or holds what
    bodies cannot be.
    """
    where = f"scene.bodies: {told.file}"
    if told.count < 1:
        raise SceneError(f"scene.bodies.count is {told.count}; expected at least 1")
    try:
        columns = _read(data, told.count, where)
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
    if content(bodies) != told.sha256:
        raise SceneError(
            f"{where} has other content than the scene was written with: its sha256 is"
            f" {content(bodies)}, not {told.sha256}"
        )
    return bodies


def _columns(bodies: Bodies) -> dict[str, NDArray[Any]]:
    """Every array of the file by name, in the byte order that the file has."""
    shapes: dict[Shape, int] = {}
    # Equal shapes are written once.
    each = [shapes.setdefault(shape, len(shapes)) for shape in bodies.shapes]
    number = np.array(each, "<i8")[bodies.shape_number]
    held: dict[str, NDArray[Any]] = {
        name: np.ascontiguousarray(getattr(bodies, name), "<f8") for name in COLUMNS
    }
    listed = np.frombuffer(msgspec.json.encode(list(shapes)), np.uint8)
    return held | {
        "fixed": np.ascontiguousarray(bodies.fixed, bool),
        "shape": number,
        "shapes": listed,
    }


def _kinds(count: int) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Type and shape of every array of so many bodies; no shape where any length is right."""
    found: dict[str, tuple[str, tuple[int, ...]]] = {}
    for name, width in WIDTH.items():
        rows: tuple[int, ...] = (count,)
        if width > 1:
            rows = (count, width)
        found[name] = ("<f8", rows)
    return found | {
        "fixed": ("|b1", (count,)),
        "shape": ("<i8", (count,)),
        "shapes": ("|u1", ()),
    }


def _read(data: bytes | Path, count: int, where: str) -> dict[str, NDArray[Any]]:
    """The arrays, each of the type and shape it must have; sizes are looked at before anything is
    read.
    """
    kinds = _kinds(count)
    if isinstance(data, bytes):
        source: Any = io.BytesIO(data)
    else:
        source = data
    with zipfile.ZipFile(source) as archive:
        sizes = {info.filename.removesuffix(".npy"): info.file_size for info in archive.infolist()}
    if sizes.keys() != kinds.keys():
        came = ", ".join(sorted(sizes)) or "nothing"
        expected = ", ".join(sorted(kinds))
        raise SceneError(f"{where} has {came}; expected {expected}")
    for name, (kind, shape) in kinds.items():
        content = MOST_SHAPES
        if shape:
            content = int(np.prod(shape)) * np.dtype(kind).itemsize
        most = HEADER + content
        if sizes[name] > most:
            raise SceneError(
                f"{where}: {name} has {sizes[name]} bytes; expected at most {most} for {count}"
                " bodies"
            )
    found: dict[str, NDArray[Any]] = {}
    with np.load(source, allow_pickle=False) as archive:
        for name, (kind, shape) in kinds.items():
            column = archive[name]
            if shape:
                has_shape = column.shape == shape
            else:
                has_shape = column.ndim == 1
            if column.dtype.str != kind or not has_shape:
                raise SceneError(
                    f"{where}: {name} is {column.dtype.str} {column.shape}; expected {kind}"
                    f" {shape or '(bytes,)'}"
                )
            found[name] = column
    return found


def _shapes(listed: NDArray[Any], where: str) -> list[Shape]:
    """The shapes, from JSON; raises SceneError with the path of the first fault."""
    try:
        return msgspec.json.decode(listed.tobytes(), type=list[Shape])
    except UNREADABLE as error:
        raise SceneError(f"{where}: shapes: {error}") from None
