"""The page of `make field` says what each code did, and what is not there."""

import hashlib
import os
import shutil
import subprocess
import sys

import field
import field_page
import field_results
import pytest
from msgspec.structs import replace

from refdem.report.jsonl import RECORDS, lines
from tests.ci.field.records import errors, record


def test_a_code_without_its_environment_is_told_of(tmp_path, monkeypatch):
    monkeypatch.setattr(field, "ENVIRONMENTS", tmp_path)
    monkeypatch.setattr(field, "OUT", tmp_path / "field")
    assert field.state("pybullet", may_install=False) == field.NOT_INSTALLED
    page = field_page.page(field.CODES, field.OUT)
    assert "Never run here: " in page
    assert "validation/codes/pybullet/deviations/threshold.py" in page


def test_a_code_without_an_environment_of_its_own_is_there_or_told_of(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(field, "OUT", tmp_path / "field")
    # The program that starts YADE is Python's.
    (tmp_path / "python3").symlink_to(sys.executable)
    assert field.lock_of("yade") is None
    assert "yade" not in field.there()
    assert field.state("yade", may_install=True) == field.NOT_INSTALLED
    assert "yade does not exist or is not executable" in capsys.readouterr().err
    (tmp_path / "yade").write_text("#!/bin/sh\n")
    (tmp_path / "yade").chmod(0o755)
    assert "yade" in field.there()


def test_an_environment_of_other_requirements_is_made_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(field, "ENVIRONMENTS", tmp_path)
    (tmp_path / "pybullet").mkdir()
    stamp = tmp_path / "pybullet" / "made"
    stamp.write_text("pybullet==0.1\n")
    assert not field.is_installed("pybullet")
    stamp.write_text((field.CODES / "pybullet" / "requirements.txt").read_text())
    assert field.is_installed("pybullet")


def test_a_machine_without_node_says_so_and_goes_on(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(field, "ENVIRONMENTS", tmp_path)
    monkeypatch.setattr(field, "OUT", tmp_path / "field")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert field.state("rapier", may_install=True) == field.NOT_INSTALLED
    assert capsys.readouterr().err.startswith("rapier: node and npm are not on PATH")


def test_an_environment_of_node_finds_its_packages(tmp_path, monkeypatch):
    # Programs that say what they were asked, in the place of node and npm.
    programs = tmp_path / "programs"
    programs.mkdir()
    for name, text in (("node", 'echo "$NODE_PATH|$1"'), ("npm", "mkdir node_modules")):
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    monkeypatch.setattr(field, "ENVIRONMENTS", tmp_path)
    monkeypatch.setenv("PATH", f"{programs}:{os.environ['PATH']}")
    assert field.install("rapier")
    assert field.is_installed("rapier")
    home = tmp_path / "rapier"
    command = [home / "bin" / "node", "driver.js"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert said == f"{home / 'node_modules'}|driver.js\n"


def debian(tmp_path, monkeypatch, words):
    """Programs in the place of apt-get and dpkg-deb, of which the first writes a package; the lock
    of one package with the digest of these words.
    """
    programs = tmp_path / "programs"
    programs.mkdir()
    download = f"printf '{words}' > libode8_0.16.2.deb"
    for name, text in (("apt-get", download), ("dpkg-deb", 'cp "$2" "$3"')):
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{programs}:{os.environ['PATH']}")
    lock = tmp_path / "debian.txt"
    digest = hashlib.sha256(b"a package").hexdigest()
    lock.write_text(f"# one package\nlibode8=2:0.16.2-1 --hash=sha256:{digest}\n")
    return lock


def test_a_package_of_debian_is_unpacked_below_the_environment(tmp_path, monkeypatch):
    lock = debian(tmp_path, monkeypatch, "a package")
    assert field.installed_from_debian(tmp_path / "ode", lock)
    assert (tmp_path / "ode/root/libode8_0.16.2.deb").read_text() == "a package"


def test_a_package_of_debian_of_another_digest_is_refused(tmp_path, monkeypatch, capsys):
    lock = debian(tmp_path, monkeypatch, "another package")
    assert not field.installed_from_debian(tmp_path / "ode", lock)
    assert "another digest than debian.txt says" in capsys.readouterr().err
    assert not list((tmp_path / "ode/root").iterdir())


def test_a_machine_without_the_tools_of_debian_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(field, "ENVIRONMENTS", tmp_path)
    monkeypatch.setattr(field, "OUT", tmp_path / "field")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert field.state("ode", may_install=True) == field.NOT_INSTALLED
    assert capsys.readouterr().err.startswith("ode: apt-get, dpkg-deb, make, g++ not on PATH")


def test_a_code_that_cannot_be_built_is_not_installed(tmp_path, monkeypatch):
    monkeypatch.setattr(field, "is_installed", lambda name: True)
    monkeypatch.setattr(field, "ENVIRONMENTS", tmp_path)
    monkeypatch.setattr(field, "CODES", tmp_path)
    monkeypatch.setattr(field, "OUT", tmp_path / "field")
    (tmp_path / "ode").mkdir()
    (tmp_path / "ode" / "Makefile").write_text("all:\n\tfalse\n")
    assert field.state("ode", may_install=False) == field.NOT_INSTALLED


@pytest.mark.parametrize(
    ("states", "status"),
    [(["open", "open"], 0), (["open", "not installed"], 2), (["closed, exit status 1"] * 2, 1)],
)
def test_what_is_not_there_is_no_silent_green(states, status, tmp_path, monkeypatch):
    ended = dict(zip(("drake", "pybullet"), states, strict=True))
    monkeypatch.setattr(field, "OUT", tmp_path)
    monkeypatch.setattr(field, "state", lambda name, may_install: ended[name])
    monkeypatch.setattr("sys.argv", ["field.py", *ended])
    assert field.main() == status
    assert (tmp_path / "index.md").is_file()


@pytest.fixture
def gates(tmp_path, monkeypatch):
    """A function that runs the field for some codes, whose gates are replaced by one that finds
    an error of the given size in a pendulum; it returns the page.
    """
    for name in ("drake", "pybullet"):
        (tmp_path / "codes" / name).mkdir(parents=True)
        for file in ("requirements.in", "requirements.txt"):
            (tmp_path / "codes" / name / file).touch()
        description = (field.CODES / name / "refdem.toml").read_text()
        (tmp_path / "codes" / name / "refdem.toml").write_text(description)
    monkeypatch.setattr(field, "CODES", tmp_path / "codes")
    monkeypatch.setattr(field, "OUT", tmp_path / "field")
    monkeypatch.setattr(field, "is_installed", lambda name: True)

    def ran(names, error, status=0):
        def gated(name):
            found = record(errors("x", (error, 0.001)), engine=name)
            home = field.OUT / name
            home.mkdir(parents=True)
            (home / RECORDS).write_bytes(lines([found]))
            return status

        monkeypatch.setattr(field, "gated", gated)
        monkeypatch.setattr("sys.argv", ["field.py", *names])
        field.main()
        return (field.OUT / "index.md").read_text()

    return ran


def day(name, date):
    """Lets the last run of a code have been on a given day."""
    path = field.OUT / f"{name}.jsonl"
    kept = field_results.read(path)
    field_results.write(path, replace(kept, run=replace(kept.run, date=date)))


def test_a_run_of_some_codes_keeps_the_results_of_the_others(gates):
    gates([], 1e-5)
    day("drake", "2026-01-02")
    page = gates(["pybullet"], 1e-7, status=1)
    assert "| [drake](#drake) | 1 | 2026-01-02 | open |" in page
    assert " | closed, exit status 1 |" in page
    (line,) = [line for line in page.splitlines() if line.startswith("| pendulum")]
    assert line.index("5.0 digits") < line.index("7.0 digits")
    assert "## drake" in page


def test_a_code_that_is_not_installed_keeps_what_its_last_run_found(gates, monkeypatch):
    gates([], 1e-5)
    monkeypatch.setattr(field, "is_installed", lambda name: False)
    monkeypatch.setattr("sys.argv", ["field.py", "--no-install", "drake"])
    assert field.main() == 2
    assert field_results.read(field.OUT / "drake.jsonl").results


def test_the_page_alone_is_made_of_what_is_kept(gates, monkeypatch):
    before = gates([], 1e-5)
    (field.OUT / "index.md").unlink()
    monkeypatch.setattr(field, "state", lambda name, may_install: pytest.fail(name))
    monkeypatch.setattr("sys.argv", ["field.py", "--page"])
    assert field.main() == 0
    assert (field.OUT / "index.md").read_text() == before


def test_a_code_that_was_removed_leaves_the_page(gates):
    gates([], 1e-5)
    shutil.rmtree(field.CODES / "drake")
    page = gates(["pybullet"], 1e-7)
    assert "drake" not in page
    assert "7.0 digits" in page


def test_a_gate_without_a_report_shows_nothing_of_an_earlier_run(gates, monkeypatch):
    gates([], 1e-5)
    monkeypatch.setattr(field, "gated", lambda name: 70)
    field.run(["drake"], may_install=False)
    kept = field_results.read(field.OUT / "drake.jsonl")
    assert kept.run.state == "closed, exit status 70"
    assert kept.results == ()
