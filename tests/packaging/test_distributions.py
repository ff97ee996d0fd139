"""What the wheel and the source distribution hold, and that one can be made from the other."""

import csv
import os
import re
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
GENERATED = {"__pycache__"}
ENVIRONMENT = os.environ | {
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
}
"""meson and ninja are beside Python."""
WITHOUT_PYTHON = {
    name: value for name, value in os.environ.items() if not name.startswith("PYTHON")
}
PROGRAM = "../../../bin/refdem"
"""pip makes it at the installation; the wheel holds only its name."""


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
def unpacked(sdist: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the unpacked source distribution."""
    folder = tmp_path_factory.mktemp("unpacked")
    with tarfile.open(sdist) as archive:
        # An attribute and no argument: filters came with Python 3.11.4, and any 3.11 will do.
        archive.extraction_filter = getattr(tarfile, "data_filter", None)
        archive.extractall(folder)
    return folder / f"refdem-{VERSION}"


@pytest.fixture(scope="module")
def installed(unpacked: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with nothing else, as the action installs it: the unpacked source distribution
    is built, and each package that is installed has its digest in the lock.
    """
    place = tmp_path_factory.mktemp("gate") / "installed"
    install = ["bash", str(unpacked / "ci" / "gate" / "install"), str(place)]
    environment = WITHOUT_PYTHON | {
        "PYTHON": sys.executable,
        # Most modules are never imported here: what is imported is compiled then.
        "PIP_COMPILE": "0",
    }
    subprocess.run(install, cwd=place.parent, env=environment, check=True, timeout=1800)
    return place


@pytest.fixture(scope="module")
def wheel(installed: Path) -> set[str]:
    """Names of the files that came out of the wheel, which pip lists with their digests."""
    (record,) = installed.glob(f"lib/python*/site-packages/refdem-{VERSION}.dist-info/RECORD")
    with record.open(newline="") as rows:
        return {name for name, digest, _ in csv.reader(rows) if digest}


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
    tops = {name.partition("/")[0] for name in wheel - {PROGRAM}}
    assert tops == {"refdem", f"refdem-{VERSION}.dist-info"}
    assert not [name for name in wheel if GENERATED & set(Path(name).parts)]


def test_the_wheel_carries_the_licence(wheel: set[str]) -> None:
    assert any(name.endswith("LICENSE") for name in wheel)


OWN_INTEGRATOR = """
import refdem


def leapfrog(t, r, v, h, a):
    v = v + h / 2 * a(t, r, v)
    r = r + h * v
    return r, v + h / 2 * a(t + h, r, v)


judged = refdem.judge(leapfrog, "two-body-orbit", order=2)
print(judged)
raise SystemExit(not judged.holds)
"""


def test_an_environment_with_nothing_else_judges_an_integrator_of_its_own(
    installed: Path, tmp_path: Path
) -> None:
    environment = WITHOUT_PYTHON | {"REFDEM_STORE": str(tmp_path / "store.sqlite")}
    python = installed / "bin" / "python"
    subprocess.run([python, "-m", "pip", "check"], cwd=tmp_path, env=environment, check=True)
    twice = OWN_INTEGRATOR.replace("h / 2", "h")
    for program, status, word in ((OWN_INTEGRATOR, 0, " pass"), (twice, 1, " fail")):
        (tmp_path / "leapfrog.py").write_text(program)
        done = subprocess.run(
            [python, "leapfrog.py"],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,
        )
        assert done.returncode == status, done.stdout + done.stderr
        assert word in done.stdout


def test_an_extra_that_stands_for_others_names_extras_that_are_there() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    for name in ("engines", "all"):
        (requirement,) = extras[name]
        assert requirement.startswith("refdem[")
        assert requirement.endswith("]")
        assert set(requirement[len("refdem[") : -1].split(",")) <= set(extras)


def test_a_release_takes_actions_by_their_commits() -> None:
    text = (ROOT / ".github" / "workflows" / "release.yml").read_text()
    assert set(yaml.safe_load(text)["jobs"]) == {"sdist", "wheels"}
    used = re.findall(r"uses: (\S+)", text)
    assert used
    for action in used:
        assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action), action
