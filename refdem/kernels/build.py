"""Which kernel families there are, and the cffi glue of each; called by meson.

`build.py` alone prints the families: every C file of this folder is one. `build.py FOLDER` writes
the glue of all of them there: starting cffi takes longer than what it writes.
"""

import re
import sys
from pathlib import Path

from cffi import FFI

FOLDER = Path(__file__).parent
SHARED = "kernels.h"
"""Holds the declarations of most families; one that has a header of its own keeps them there."""


def families() -> list[str]:
    """The names of all families, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.c"))


def sections(header: Path) -> dict[str, str]:
    """The parts of a header by family: each goes from `/* == family == */` to the next such line.

    Comments and lines of the preprocessor are left out; a header that is not there has no parts.
    """
    if not header.is_file():
        return {}
    parts = re.split(r"/\* == (\w+) == \*/", header.read_text())
    named = zip(parts[1::2], parts[2::2], strict=True)
    return {name: re.sub(r"/\*.*?\*/|^#.*?$", "", text, flags=re.S | re.M) for name, text in named}


def declared(family: str) -> tuple[str, str]:
    """The header that declares a family, and its declarations; ends the program if none does."""
    own_header = f"{family}_kernel.h"
    for name in (SHARED, own_header):
        declarations = sections(FOLDER / name)
        if family in declarations:
            return name, declarations[family]
    raise SystemExit(
        f"{family}.c is a kernel family that no header declares; write its functions below the line"
        f" '/* == {family} == */' in {own_header}"
    )


def write_glue(family: str, folder: Path) -> None:
    """Writes the C source of the extension `refdem.kernels._<family>`; one that is the same stays
    as it is.
    """
    header, declarations = declared(family)
    ffi = FFI()
    ffi.cdef(declarations)
    ffi.set_source(f"refdem.kernels._{family}", f'#include "{header}"')
    ffi.emit_c_code(str(folder / f"_{family}_glue.c"))


if __name__ == "__main__":
    if sys.argv[1:]:
        for family in families():
            write_glue(family, Path(sys.argv[1]))
    else:
        print("\n".join(families()))
