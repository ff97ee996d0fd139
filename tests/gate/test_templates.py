"""The templates for other repositories, run step by step as their services would."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]


@pytest.fixture
def runner(program):
    """Runs a shell script in the program's folder with `refdem` and a pip that is told what is
    installed already.
    """
    tools = program.folder / "bin"
    tools.mkdir()
    refdem = f'#!/bin/sh\nexec {sys.executable} -c "from refdem.cli import main; main()" "$@"\n'
    pip = (
        f'#!/bin/sh\n[ "$1 $2 $3" = "-m pip install" ] && echo "$5" > {program.folder}/installed &&'
        f' exit 0\nexec {sys.executable} "$@"\n'
    )
    for name, text in (("refdem", refdem), ("python3", pip)):
        (tools / name).write_text(text)
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


def github(runner):
    """Every step of the action with its inputs at their defaults; the status of the first that
    fails.
    """
    action = yaml.safe_load((ROOT / "ci" / "gate" / "action.yml").read_text())
    for step in action["runs"]["steps"]:
        environment = dict(step["env"])
        for name, value in action["inputs"].items():
            environment = {
                key: text.replace("${{ inputs." + name + " }}", value["default"])
                for key, text in environment.items()
            }
        assert "${{" not in step["run"] + "".join(environment.values())
        status, output = runner(step["run"], **environment)
        if status:
            return status, output
    return 0, output


def gitlab(runner):
    """The script of the job with its variables."""
    job = yaml.safe_load((ROOT / "ci" / "gate" / "gitlab.yml").read_text())["refdem-gate"]
    return runner("\n".join(job["script"]), **job["variables"])


@pytest.mark.parametrize("service", [github, gitlab])
def test_a_service_opens_for_a_blessed_program_and_closes_for_a_spoiled_one(
    program, runner, service
):
    program.bless()
    status, output = service(runner)
    assert status == 0, output
    assert (program.folder / "installed").read_text() == "refdem\n"
    program.spoil("x += h * v", "x -= h * v")
    status, output = service(runner)
    assert status == 1
    assert "is closed" in (program.folder / "refdem-gate.md").read_text()
    assert (program.folder / "refdem-report" / "index.html").is_file()
    if service is github:
        assert "is closed" in (program.folder / "summary.md").read_text()
        assert "::error title=" in output
