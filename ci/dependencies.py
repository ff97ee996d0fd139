"""Prints what refdem needs, one requirement a line: its build, its dependencies and the extras
named as arguments.
"""

import sys
import tomllib
from pathlib import Path

if __name__ == "__main__":
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())
    extras = project["project"]["optional-dependencies"]
    wanted = [*project["build-system"]["requires"], *project["project"]["dependencies"]]
    print("\n".join([*wanted, *(line for name in sys.argv[1:] for line in extras[name])]))
