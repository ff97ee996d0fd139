"""Templates of Jinja that are compiled once: their bytecode is kept where Python keeps the bytecode
of modules.
"""

import hashlib
import sys
from contextlib import suppress
from importlib.util import MAGIC_NUMBER, cache_from_source
from pathlib import Path

from jinja2 import BytecodeCache
from jinja2.bccache import Bucket

from refdem.core import fingerprint
from refdem.core.named_file import put

DIGEST = hashlib.sha256().digest_size
"""Bytes of the digest at the beginning of a file."""


def cache_beside(folder: Path) -> "CompiledTemplates | None":
    """The bytecode of the templates in a folder, in `__pycache__` there or below
    PYTHONPYCACHEPREFIX; None for a Python that keeps no bytecode.

    Bytecode is executed. Who can write it here can also write the bytecode of refdem's modules, so
    that nobody gains a right; in a cache folder of the user or of the system that would not hold.
    """
    try:
        of_module = cache_from_source(str(folder / "template.py"))
    except NotImplementedError:
        return None
    return CompiledTemplates(Path(of_module).parent)


class CompiledTemplates(BytecodeCache):
    """Compiled templates in a folder, a file each, with a digest of the file and of all that
    compiled it.

    A file that is damaged, or that another state of refdem, Jinja or Python has made, is replaced.
    Nothing is written where Python writes no bytecode, or where the folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        """A cache in this folder, which need not exist."""
        self.folder = folder

    def load_bytecode(self, bucket: Bucket) -> None:
        """Fills the bucket with the compiled template, if the folder has it."""
        try:
            data = self._path(bucket).read_bytes()
        except OSError:
            return
        content = data[DIGEST:]
        if data[:DIGEST] == _digest_of(content):
            # Jinja compares the digest of the template's text.
            bucket.bytecode_from_string(content)

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Writes a template that has just been compiled."""
        if sys.dont_write_bytecode:
            return
        content = bucket.bytecode_to_string()
        with suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            put(self._path(bucket), _digest_of(content) + content)

    def _path(self, bucket: Bucket) -> Path:
        """The file of a template; fingerprints of refdem leave out files with this suffix."""
        return self.folder / f"{bucket.key}.{sys.implementation.cache_tag}.pyc"


def _digest_of(content: bytes) -> bytes:
    """sha256 of a compiled template and of what compiled it: Jinja, Python, and refdem, whose
    functions Jinja applies to constants.
    """
    jinja = fingerprint.version_of("jinja2")
    compiler = f"{jinja}\0{fingerprint.of_refdem()}\0".encode() + MAGIC_NUMBER
    return hashlib.sha256(compiler + content).digest()
