"""Codes are found by the names of their folders, and one that is not installed is told of."""

import json
import os
import sys

import pytest

from refdem.core import codes, discovery
from refdem.errors import EngineMissingError, UsageError

DESCRIBED = """
[engine]
name = "{name}"
command = ["{command}"]
install = "install it with: get {name}"
supports = ["rotation"]

[[engine.methods]]
name = "verlet"
order = 2

[[audit]]
setting = "damping"
default = "0.04"
used = "0"
why = "no scene has\\na drag of this kind"
"""


def code(folder, name, command="./not-there"):
    """A folder of that name with a description; its path."""
    home = folder / name
    home.mkdir(parents=True)
    toml = home / "refdem.toml"
    toml.write_text(DESCRIBED.format(name=name, command=command))
    return toml


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder of codes, which REFDEM_CODES names."""
    place = tmp_path / "codes"
    place.mkdir()
    monkeypatch.setenv("REFDEM_CODES", str(place))
    return place


def test_codes_of_the_variable_and_those_that_come_with_refdem_are_found(folder):
    mine = code(folder, "mydem")
    found = codes.descriptions()
    assert found["mydem"] == mine.resolve()
    assert {"lammps", "kratos", "yade", "liggghts"} <= set(found)
    assert list(found) == sorted(found)


def test_the_first_of_two_places_with_a_name_counts(tmp_path, monkeypatch):
    first = code(tmp_path / "first", "lammps")
    code(tmp_path / "second", "lammps")
    places = [tmp_path / "first", tmp_path / "second", tmp_path / "nowhere"]
    monkeypatch.setenv("REFDEM_CODES", os.pathsep.join(map(str, places)))
    assert codes.descriptions()["lammps"] == first.resolve()


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project whose .venv has an installed refdem, with copies of descriptions inside it."""
    project = tmp_path / "project"
    package = project / ".venv" / "lib" / "refdem"
    monkeypatch.setattr(sys, "prefix", str(project / ".venv"))
    monkeypatch.setattr(codes, "PACKAGE", package)
    monkeypatch.delenv("REFDEM_CODES", raising=False)
    code(package / codes.FOLDER, "mydem")
    return project


def test_an_installed_refdem_finds_the_programs_of_its_project(project):
    toml = code(project / codes.FOLDER, "mydem", "../../../.venv-field/mydem/python")
    program = project / ".venv-field" / "mydem" / "python"
    program.parent.mkdir(parents=True)
    program.symlink_to(sys.executable)
    engine = discovery.engine("mydem")
    assert engine.address == str(toml)
    assert engine.missing() is None


def test_a_copy_inside_the_package_says_where_codes_were_looked_for(project):
    reason = discovery.engine("mydem").missing()
    assert "install it with: get mydem; do so in a checkout of refdem" in reason
    assert "let REFDEM_CODES name its validation/codes" in reason
    assert reason.endswith(f"codes were looked for in {codes.PACKAGE / codes.FOLDER}")


def test_an_engine_of_refdem_is_not_replaced_by_a_folder_of_its_name(folder):
    code(folder, "reference")
    assert discovery.engine("reference").is_reference


def test_a_code_is_an_engine_by_its_name(folder):
    toml = code(folder, "mydem")
    engine = discovery.engine("mydem")
    assert engine.address == str(toml.resolve())
    (line,) = engine.audit
    assert line.setting == "damping"
    assert "\n" not in line.why


def test_a_misspelt_code_is_answered_with_the_nearest(folder):
    code(folder, "mydem")
    with pytest.raises(UsageError, match="no engine 'mydme'; did you mean 'mydem'") as error:
        discovery.engine("mydme")
    assert str(folder) in str(error.value)


def test_codes_are_in_no_campaign_that_does_not_name_them(folder):
    code(folder, "mydem")
    assert "mydem" not in discovery.names("engines")


def test_what_is_missing_says_how_to_install_it(folder):
    code(folder, "mydem")
    reason = discovery.engine("mydem").missing()
    assert reason is not None
    assert reason.endswith("install it with: get mydem")
    assert discovery.engine("lammps").name == "lammps"


def test_the_list_says_what_is_not_installed(folder, command_line):
    code(folder, "mydem")
    code(folder, "there", sys.executable)
    done = command_line("list", "engines", "--json")
    listed = {item["id"]: item for item in json.loads(done.stdout)}
    assert not listed["mydem"]["installed"]
    assert "not installed; " in listed["mydem"]["title"]
    assert listed["mydem"]["title"].endswith("install it with: get mydem")
    assert listed["there"]["installed"]


def run(command_line, folder, *engines):
    """`refdem run` of one short case in engines."""
    named = [word for engine in engines for word in ("--engine", engine)]
    case = "newtons-first-law[velocity=0,0,0 duration=4 samples=16]"
    options = ["--no-cache", "--jobs", "1", "--out", str(folder / "report")]
    # Folders of codes alone: the report goes beside them.
    return command_line("run", case, *named, *options, cwd=folder)


def test_a_run_without_one_of_its_engines_goes_on_and_is_not_green(folder, command_line):
    code(folder, "mydem")
    done = run(command_line, folder, "mydem", "reference")
    assert done.returncode == 2
    assert "engine mydem is not installed here; " in done.stdout
    assert " pass" in done.stdout
    assert (folder / "report" / "index.html").is_file()


def test_a_run_with_none_of_its_engines_is_refused(folder, command_line):
    code(folder, "mydem")
    done = run(command_line, folder, "mydem")
    assert done.returncode == 2
    assert "engine mydem is not installed here; " in done.stderr
    assert not (folder / "report").exists()


def test_a_gate_of_a_code_that_is_not_there_names_the_way_to_install_it(folder, command_line):
    toml = code(folder, "mydem")
    done = command_line("gate", str(toml), cwd=folder)
    assert done.returncode == EngineMissingError.exit_status
    assert "install it with: get mydem" in done.stderr
