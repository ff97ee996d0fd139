"""Installs refdem as a link to a tree: a path file, the command, and the metadata by which pip and
entry points know it.
"""

import sys
import sysconfig
import tomllib
from pathlib import Path

COMMAND = """#!{python}
import sys

from {module} import {function}

# Worker processes import this file again: only the first of them runs the command.
if __name__ == "__main__":
    sys.exit({function}())
"""


def installed(tree: Path) -> None:
    """Writes path file, scripts and dist-info; pip removes them again by their RECORD."""
    project = tomllib.loads((tree / "pyproject.toml").read_text())["project"]
    site = Path(sysconfig.get_path("purelib"))
    scripts = Path(sysconfig.get_path("scripts"))
    info = site / f"{project['name']}-{project['version']}.dist-info"
    groups = {"console_scripts": project["scripts"], **project.get("entry-points", {})}
    sections = [
        f"[{group}]\n" + "".join(f"{name} = {target}\n" for name, target in points.items())
        for group, points in groups.items()
    ]
    files = {
        site / "refdem-tree.pth": f"{tree}\n",
        info / "METADATA": (
            f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
        ),
        info / "entry_points.txt": "\n".join(sections),
        info / "INSTALLER": "refdem\n",
    }
    for name, target in project["scripts"].items():
        module, _, function = target.partition(":")
        files[scripts / name] = COMMAND.format(
            python=sys.executable, module=module, function=function
        )
    info.mkdir(exist_ok=True)
    for path, text in files.items():
        path.write_text(text)
        path.chmod(0o755 if path.parent == scripts else 0o644)
    (info / "RECORD").write_text("".join(f"{path},,\n" for path in (*files, info / "RECORD")))


if __name__ == "__main__":
    installed(Path(sys.argv[1]))
