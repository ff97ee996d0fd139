"""What the wheel and the source distribution hold, and that one can be made from the other."""

import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
GENERATED = {"__pycache__"}
ENVIRONMENT = os.environ | {
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
}
"""meson and ninja are beside Python."""


def sources(folder: str) -> set[str]:
    """Files that git tracks below a folder."""
    listed = subprocess.run(
        ["git", "ls-files", folder], cwd=ROOT, check=True, capture_output=True, text=True
    )
    return set(listed.stdout.split())


@pytest.fixture(scope="module")
def sdist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution of what is committed."""
    folder = tmp_path_factory.mktemp("sdist")
    code = f"import mesonpy; mesonpy.build_sdist({str(folder)!r})"
    subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env=ENVIRONMENT, check=True, capture_output=True
    )
    (made,) = folder.glob("*.tar.gz")
    return made


@pytest.fixture(scope="module")
def wheel(sdist: Path, tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    """Names in the wheel that is built from the unpacked source distribution."""
    folder = tmp_path_factory.mktemp("wheel")
    with tarfile.open(sdist) as archive:
        # An attribute and no argument: filters came with Python 3.11.4, and any 3.11 will do.
        archive.extraction_filter = getattr(tarfile, "data_filter", None)
        archive.extractall(folder)
    build = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--no-deps",
        "--no-build-isolation",
        # As deep as in the Makefile: ccache has compiled the kernels already.
        "-Cbuild-dir=build/wheel",
        "--wheel-dir",
        str(folder),
    ]
    subprocess.run(
        [*build, str(folder / f"refdem-{VERSION}")],
        env=ENVIRONMENT,
        check=True,
        capture_output=True,
    )
    (made,) = folder.glob("*.whl")
    return set(zipfile.ZipFile(made).namelist())


def test_the_source_distribution_holds_every_tracked_file(sdist: Path) -> None:
    with tarfile.open(sdist) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    assert (
        not (
            sources("refdem")
            | sources("validation")
            | {"meson.build", "LICENSE", "README.md", "Makefile"}
        )
        - held
    )


def test_the_wheel_holds_the_package_and_the_campaigns(wheel: set[str]) -> None:
    validation = {f"refdem/{name}" for name in sources("validation")}
    assert validation
    assert not (sources("refdem") | validation) - wheel


def test_the_wheel_holds_a_compiled_extension_for_every_kernel_family(wheel: set[str]) -> None:
    families = {path.stem for path in (ROOT / "refdem" / "kernels").glob("*.c")}
    assert families
    built = {Path(name).name.partition(".")[0] for name in wheel if name.endswith(".so")}
    assert built == {f"_{family}" for family in families}


def test_the_wheel_holds_nothing_else(wheel: set[str]) -> None:
    tops = {name.partition("/")[0] for name in wheel}
    assert tops == {"refdem", f"refdem-{VERSION}.dist-info"}
    assert not [name for name in wheel if GENERATED & set(Path(name).parts)]


def test_the_wheel_carries_the_licence(wheel: set[str]) -> None:
    assert any(name.endswith("LICENSE") for name in wheel)
