"""Only files whose digests are in a lock are installed, by whatever installs."""

import base64
import hashlib
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LOCKS = ("requirements.lock", "validation/codes/requirements.txt")
DIGEST = re.compile(r"--hash=sha256:[0-9a-f]{64}\b")
EXTRAS = ["every"]


def needed(*arguments: str) -> str:
    """What ci/packaging/dependencies.py prints."""
    done = subprocess.run(
        [sys.executable, "ci/packaging/dependencies.py", *arguments],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    return done.stdout


def names(text: str) -> set[str]:
    """The packages that lines of requirements name, as indexes write them."""
    found = re.findall(r"^([A-Za-z0-9][\w.-]*?)(?=[\s=><\[]|$)", text, re.MULTILINE)
    return {re.sub(r"[-_.]+", "-", name).lower() for name in found}


@pytest.mark.parametrize("lock", LOCKS)
def test_every_package_of_a_lock_has_one_version_and_digests(lock: str) -> None:
    packages = re.split(r"^(?=\w)", (ROOT / lock).read_text(), flags=re.MULTILINE)[1:]
    assert len(packages) > 3
    for package in packages:
        assert re.match(r"[\w.-]+==[\w.]+ ", package), package
        assert DIGEST.search(package), package


def test_the_lock_has_all_that_pyproject_asks_for_and_nothing_else() -> None:
    locked = needed("--locked", *EXTRAS)
    assert names(needed(*EXTRAS)) <= names(locked)
    assert names(locked) == names((ROOT / "requirements.lock").read_text())


def test_what_is_installed_for_runs_alone_leaves_the_tools_of_tests_out() -> None:
    locked = names(needed("--locked"))
    assert {"numpy", "python-dateutil", "markupsafe"} <= locked
    assert not locked & {"pytest", "ruff", "mujoco", "playwright"}


def installing() -> "list[tuple[str, str]]":
    """Every line of a tracked script, Makefile or template that calls pip's install."""
    listed = subprocess.run(
        ["git", "ls-files", "Makefile", ".ci", "ci"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    found = []
    for name in listed.stdout.split():
        for line in (ROOT / name).read_text().splitlines():
            is_comment = line.lstrip().startswith("#")
            if re.search(r"\bpip\b.*\binstall\b", line) and not is_comment:
                found.append((name, line.strip()))
    return found


def test_whatever_installs_asks_for_digests() -> None:
    """Exceptions: refdem itself, by its own sources; and uv, which writes the lock."""
    lines = installing()
    assert {"Makefile", "ci/gate/install"} <= {name for name, _ in lines}
    for name, line in lines:
        is_of_make = line.startswith("PIP := ")
        is_itself = "--no-deps --no-build-isolation" in line
        is_maker = name == "ci/packaging/lock" and line.endswith(" uv")
        asks = "--require-hashes" in line
        assert is_of_make or is_itself or is_maker or asks, f"{name}: {line}"
    made = (ROOT / "Makefile").read_text()
    for line in re.findall(r"\$\(PIP\).*", made):
        assert "--require-hashes" in line or "--no-deps --no-build-isolation" in line, line


def test_a_file_that_was_changed_on_its_way_is_not_installed(tmp_path: Path) -> None:
    """The form of the lock, in pip's hands: a package of one's own, whole and with another byte."""
    wheel = tmp_path / "thing-1.0-py3-none-any.whl"

    def made(content: bytes) -> str:
        with zipfile.ZipFile(wheel, "w") as archive:
            said = {
                "thing.py": content,
                "thing-1.0.dist-info/METADATA": b"Metadata-Version: 2.1\nName: thing\nVersion: 1.0",
                "thing-1.0.dist-info/WHEEL": b"Wheel-Version: 1.0\nTag: py3-none-any",
            }
            record = "thing-1.0.dist-info/RECORD,,\n"
            for name, data in said.items():
                archive.writestr(name, data)
                digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode()
                record += f"{name},sha256={digest.rstrip('=')},{len(data)}\n"
            archive.writestr("thing-1.0.dist-info/RECORD", record)
        return hashlib.sha256(wheel.read_bytes()).hexdigest()

    other = made(b"right = False\n")
    own = made(b"right = True\n")
    pip = [sys.executable, "-m", "pip", "install", "--no-index", "--find-links", str(tmp_path)]

    def installed(digest: str) -> "subprocess.CompletedProcess[str]":
        asked = tmp_path / "wanted.txt"
        asked.write_text(f"thing==1.0 \\\n    --hash=sha256:{digest}\n")
        target = ["--target", str(tmp_path / digest), "--require-hashes", "-r", str(asked)]
        return subprocess.run([*pip, *target], capture_output=True, text=True, check=False)

    assert installed(own).returncode == 0
    refused = installed(other)
    assert refused.returncode != 0
    assert "DO NOT MATCH" in refused.stderr
