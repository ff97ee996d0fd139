"""Writes the cffi glue of one kernel family: `build.py FAMILY kernels.h OUTPUT.c`, called by
meson.
"""

import re
import sys
from pathlib import Path

from cffi import FFI


def declarations(header: str, family: str) -> str:
    """The part of the header between `/* == family == */` and the next such line, without
    comments.
    """
    parts = re.split(r"/\* == (\w+) == \*/", header)
    sections = dict(zip(parts[1::2], parts[2::2], strict=True))
    if family not in sections:
        raise SystemExit(f"kernels.h has no section {family!r}; it has {', '.join(sections)}")
    return re.sub(r"/\*.*?\*/|^#.*?$", "", sections[family], flags=re.S | re.M)


def main(family: str, header: str, output: str) -> None:
    """Writes the C source of the extension `refdem.kernels._<family>`."""
    ffi = FFI()
    ffi.cdef(declarations(Path(header).read_text(), family))
    ffi.set_source(f"refdem.kernels._{family}", '#include "kernels.h"')
    ffi.emit_c_code(output)


if __name__ == "__main__":
    main(*sys.argv[1:])
