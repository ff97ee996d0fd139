"""Builds the conda package of conda/recipe.yaml without a conda channel: from one that it makes of
the distributions that are installed beside this Python, and with this machine's C compiler.

usage: python ci/packaging/conda_package.py FOLDER, which gets the channel and the package.
"""

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from rattler_build import (
    EnvironmentIsolation,
    FileEntry,
    Package,
    RenderConfig,
    RenderedVariant,
    Stage0Recipe,
    ToolConfiguration,
    VariantConfig,
    assemble_package,
)
from rattler_build.progress import SimpleProgressCallback

ROOT = Path(__file__).resolve().parents[2]
RECIPE = Path("ci", "packaging", "conda", "recipe.yaml")
COMPILER = "system"
"""What the recipe's `compiler("c")` stands for here, without the platform."""
RELEASE = ".".join(map(str, sys.version_info[:3]))
SITE = Path("lib", f"python{sys.version_info[0]}.{sys.version_info[1]}", "site-packages")
RELAY = b"""#!/bin/sh
'''exec' "$(dirname "$0")/python" "$0" "$@"
' '''
"""
"""The head of a script for the Python beside it, wherever both are installed: a shell runs the
second line, and Python reads a string."""


def conda_name(name: str) -> str:
    """The name of a distribution as conda writes it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def required(distribution: metadata.Distribution) -> list[str]:
    """Names of what a distribution needs on this machine, without extras."""
    found = []
    for line in distribution.requires or []:
        requirement = Requirement(line)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            found.append(conda_name(requirement.name))
    return found


def installed(names: Iterable[str]) -> list[metadata.Distribution]:
    """The distributions of these names and all that they need."""
    found: dict[str, metadata.Distribution] = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = metadata.distribution(name)
            waiting += required(found[name])
    return list(found.values())


def files(distribution: metadata.Distribution, stage: Path) -> list[FileEntry]:
    """The files of a distribution and their places below a prefix.

    Scripts name the Python of their environment; copies in `stage` start the one beside them.
    """
    found = []
    for name in distribution.files or []:
        source = Path(str(distribution.locate_file(name)))
        if source.suffix == ".pyc" or not source.is_file():
            continue
        # Paths of a record begin at site-packages: ../../../bin/meson.
        place = Path(os.path.normpath(SITE / name))
        if place.parts[0] == "bin" and source.read_bytes().startswith(b"#!"):
            body = source.read_bytes().partition(b"\n")[2]
            source = stage / place.name
            source.write_bytes(RELAY + body)
            source.chmod(0o755)
        found.append(FileEntry.from_paths(source, place))
    return found


def interpreter(stage: Path) -> None:
    """Writes a prefix that is a virtual environment of this machine's Python."""
    base = Path(sys.base_prefix, "bin", f"python{sys.version_info[0]}.{sys.version_info[1]}")
    (stage / "bin").mkdir()
    for name in ("python", "python3", base.name):
        (stage / "bin" / name).symlink_to(base)
    # Packages of that Python stay out, as they do of an environment of conda.
    lines = [f"home = {base.parent}", "include-system-site-packages = false", ""]
    (stage / "pyvenv.cfg").write_text("\n".join(lines))


def write_index(folder: Path, platform: str) -> None:
    """Writes the list of the packages in the folder of a platform."""
    listed = {}
    for path in sorted(folder.glob("*.conda")):
        package = Package.from_file(path)
        content = path.read_bytes()
        listed[path.name] = {
            "name": package.name,
            "version": package.version,
            "build": package.build_string,
            "build_number": package.build_number,
            "depends": package.depends,
            "subdir": platform,
            "md5": hashlib.md5(content).hexdigest(),
            "sha256": hashlib.sha256(content).hexdigest(),
            "size": len(content),
        }
    index = {"info": {"subdir": platform}, "packages": {}, "packages.conda": listed}
    (folder / "repodata.json").write_text(json.dumps(index))


def make_channel(channel: Path, platform: str, names: Iterable[str]) -> None:
    """Makes a channel of Python, a compiler, and distributions of these names with their needs."""
    folder = channel / platform
    folder.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as stage:
        interpreter(Path(stage))
        assemble_package("python", RELEASE, platform, "0", folder, files_dir=stage)
    with tempfile.TemporaryDirectory() as stage:
        Path(stage, "system-compiler.txt").write_text("The C compiler of this machine is used.\n")
        assemble_package(f"{COMPILER}_{platform}", "1", platform, "0", folder, files_dir=stage)
    for distribution in installed(names):
        with tempfile.TemporaryDirectory() as stage:
            assemble_package(
                conda_name(distribution.name),
                distribution.version,
                platform,
                "0",
                folder,
                files=files(distribution, Path(stage)),
                depends=["python", *required(distribution)],
                compression_level=1,
                detect_prefix=False,
            )
    write_index(folder, platform)
    (channel / "noarch").mkdir()
    write_index(channel / "noarch", "noarch")


def asked(recipe: RenderedVariant) -> set[str]:
    """Names of what a rendered recipe asks for, without Python and the compiler."""
    requirements = recipe.recipe.requirements
    every = [*requirements.build, *requirements.host, *requirements.run]
    # What is no text follows from another requirement.
    names = {line.split()[0] for line in every if isinstance(line, str)}
    return {name for name in names if name != "python" and not name.startswith(f"{COMPILER}_")}


def copy_sources(folder: Path) -> None:
    """Copies the files that git knows. In the tree itself what runs beside the build, as tests do,
    makes and removes files, and a folder that vanishes ends the build.
    """
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, stdout=subprocess.PIPE)
    for name in os.fsdecode(listed.stdout).split("\0")[:-1]:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name, follow_symlinks=False)


def build(folder: Path) -> Path:
    """Builds the package from a channel of its own, runs its tests, and returns its path."""
    sources = folder / "sources"
    copy_sources(sources)
    recipe = Stage0Recipe.from_file(sources / RECIPE)
    (rendered,) = recipe.render(VariantConfig({"c_compiler": [COMPILER]}))
    channel = folder / "channel"
    make_channel(channel, RenderConfig().target_platform, asked(rendered))
    # What is unpacked of this channel is of no use to another.
    os.environ["RATTLER_CACHE_DIR"] = str(folder / "cache")
    result = rendered.run_build(
        ToolConfiguration(test_strategy="native"),
        folder / "built",
        [channel.as_uri()],
        progress_callback=SimpleProgressCallback(),
        # HOME is that of the user, where ccache has the kernels.
        env_isolation=EnvironmentIsolation.CONDA_BUILD,
    )
    (package,) = result.packages
    return Path(package)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    package = build(Path(sys.argv[1]).resolve())
    print(f"{package}: {len(Package.from_file(package).files)} files")
