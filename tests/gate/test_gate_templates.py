"""The templates for other repositories, run step by step as their services would."""

import json
import os
import re
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]


REFDEM = f'#!/bin/sh\nexec {sys.executable} -c "from refdem.cli import main; main()" "$@"\n'
PIP = """#!/bin/sh
if [ "$1 $2 $3 $4" = "-I -m pip install" ]; then
  echo "$@" >>{told}
  exit 0
fi
exec {python} "$@"
"""
VENV = """#!/bin/sh
if [ "$1 $2 $3" = "-I -m venv" ]; then
  mkdir -p "$4/bin"
  cp {tools}/made/* "$4/bin"
  exit 0
fi
exec {python} "$@"
"""


@pytest.fixture
def runner(program):
    """Runs a shell script in the program's folder. Environments that it makes have `refdem`, and
    a pip that writes down what it is asked for.
    """
    tools = program.folder / "bin"
    words = {"told": program.folder / "installed", "tools": tools, "python": sys.executable}
    (tools / "made").mkdir(parents=True)
    scripts = {"python3": VENV, "made/python": PIP, "made/refdem": REFDEM}
    for name, text in scripts.items():
        is_template = name != "made/refdem"
        (tools / name).write_text(text.format(**words) if is_template else text)
        (tools / name).chmod(stat.S_IRWXU)

    def run(script, **environment):
        own = {
            "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}",
            "REFDEM_STORE": str(program.folder / "store.sqlite"),
        }
        own |= {"GITHUB_STEP_SUMMARY": str(program.folder / "summary.md"), "GITHUB_ACTIONS": "true"}
        done = subprocess.run(
            ["bash", "-eo", "pipefail", "-c", script],
            cwd=program.folder,
            env=os.environ | own | environment,
            capture_output=True,
            text=True,
            timeout=300,
        )
        return done.returncode, done.stdout + done.stderr

    return run


def github(runner, program):
    """Every step of the action with its inputs at their defaults; the status of the first that
    fails.
    """
    action = yaml.safe_load((ROOT / "action.yml").read_text())
    known = {f"inputs.{name}": value["default"] for name, value in action["inputs"].items()}
    known |= {
        "github.action_path": str(ROOT),
        "runner.temp": str(program.folder / "temporary"),
    }
    for step in action["runs"]["steps"]:
        environment = dict(step["env"])
        for name, value in known.items():
            environment = {
                key: text.replace("${{ " + name + " }}", value) for key, text in environment.items()
            }
        assert "${{" not in step["run"] + "".join(environment.values())
        status, output = runner(step["run"], **environment)
        if status:
            return status, output
    return 0, output


@pytest.fixture(scope="session")
def published(tmp_path_factory):
    """A repository with what the template installs from, and its commit."""
    folder = tmp_path_factory.mktemp("published")
    shutil.copytree(ROOT / "ci", folder / "ci", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "requirements.lock"):
        shutil.copy(ROOT / name, folder / name)
    git = ["git", "-C", str(folder), "-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "all"]):
        subprocess.run([*git, *words], check=True, capture_output=True)
    commit = subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    return folder, commit.stdout.strip()


def gitlab_job():
    """The job of the template."""
    return yaml.safe_load((ROOT / "ci" / "gate" / "gitlab.yml").read_text())["refdem-gate"]


def gitlab(runner, program, published, **other):
    """The script of the job with its variables and those that it asks for."""
    folder, commit = published
    place = program.folder / "place"
    shutil.rmtree(place, ignore_errors=True)
    job = gitlab_job()
    asked = {
        "REFDEM_IMAGE": f"python:3.12@sha256:{'0' * 64}",
        "REFDEM_REPOSITORY": str(folder),
        "REFDEM_COMMIT": commit,
        "REFDEM_PLACE": str(place),
    }
    return runner("\n".join(job["script"]), **(job["variables"] | asked | other))


def told_to_the_host(program):
    """The results in the SARIF file that the action names as its output."""
    (output,) = yaml.safe_load((ROOT / "action.yml").read_text())["outputs"].values()
    (run,) = json.loads((program.folder / output["value"]).read_text())["runs"]
    return run["results"]


@pytest.mark.parametrize("service", ["github", "gitlab"])
def test_a_service_opens_for_a_blessed_program_and_closes_for_a_spoiled_one(
    program, runner, published, service
):
    def judged():
        if service == "github":
            return github(runner, program)
        return gitlab(runner, program, published)

    program.bless()
    status, output = judged()
    assert status == 0, output
    packages, itself = (program.folder / "installed").read_text().splitlines()
    assert "--require-hashes" in packages
    assert "--no-deps --no-build-isolation" in itself
    if service == "github":
        assert told_to_the_host(program) == []
        installed_from = str(ROOT)
    else:
        installed_from = str(program.folder / "place" / "source")
    assert itself.endswith(f" {installed_from}")
    program.spoil("x += h * v", "x -= h * v")
    status, output = judged()
    assert status == 1
    assert "is closed" in (program.folder / "refdem-gate.md").read_text()
    assert (program.folder / "refdem-report" / "index.html").is_file()
    if service == "github":
        assert told_to_the_host(program)
        assert "is closed" in (program.folder / "summary.md").read_text()
        assert "::error title=" in output


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("REFDEM_IMAGE", "python:3.12"),
        ("REFDEM_IMAGE", "python:3.12@sha256:0123"),
        ("REFDEM_IMAGE", ""),
        ("REFDEM_COMMIT", "main"),
        ("REFDEM_COMMIT", "v0.1.0"),
        ("REFDEM_COMMIT", "0123abc"),
    ],
)
def test_what_somebody_else_could_move_is_refused(program, runner, published, name, value):
    status, output = gitlab(runner, program, published, **{name: value})
    assert status == 2, output
    assert f"{name} is '{value}'; expected" in output
    assert not (program.folder / "installed").exists()


def test_the_templates_name_nothing_that_somebody_else_could_move():
    assert gitlab_job()["image"] == "$REFDEM_IMAGE"
    assert "REFDEM_IMAGE" not in gitlab_job()["variables"]
    assert "REFDEM_COMMIT" not in gitlab_job()["variables"]
    used = re.findall(r"uses: (\S+)@(.*)", (ROOT / "action.yml").read_text())
    assert len(used) == 2
    for action, pinned in used:
        assert pinned.startswith("<40 hexadecimal digits"), action
