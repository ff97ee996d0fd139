"""The helper of C and C++ that refdem init writes: rows with rotation, elements by their kind."""

import csv
import io
import subprocess
from pathlib import Path

import pytest

from refdem.cli.starter import HEADER, TEMPLATES

REQUEST = """\
scene.bodies.0.attitude.0 0.5
scene.bodies.0.attitude.1 -0.5
scene.bodies.0.attitude.2 0.5
scene.bodies.0.attitude.3 0.5
scene.elements.count 4
scene.elements.0.kind spring
scene.elements.1.kind contact
scene.elements.2.kind spring
scene.elements.3.kind plane
"""
PROGRAM = """\
#include "refdem_driver.h"

static const char *solve(FILE *trajectory)
{
    const char *const two[] = {"spring", "contact", NULL};
    const char *const all[] = {"plane", "contact", "spring", NULL};
    double v[3] = {4, 5, 6}, q[4], omega[3] = {7, 8, 9.1}, r[3] = {1, 2, 3};
    refdem_attitude(q, 0);
    refdem_body(trajectory, 0.1, 3, r, v, q, omega);
    for (int i = refdem_element("spring", 0); i >= 0; i = refdem_element("spring", i + 1))
        fprintf(stderr, "spring %d\\n", i);
    fprintf(stderr, "rod %d\\n", refdem_element("rod", 0));
    fprintf(stderr, "other %s\\n", refdem_other_element(two));
    fprintf(stderr, "others %d\\n", refdem_other_element(all) != NULL);
    return NULL;
}

int main(int argc, char **argv)
{
    return refdem_run(argc, argv, solve);
}
"""


@pytest.mark.parametrize(
    ("source", "compiler"),
    [
        ("program.c", ["gcc", "-std=c11", "-D_DEFAULT_SOURCE", "-Wconversion"]),
        ("program.cpp", ["g++", "-std=c++17"]),
    ],
)
def test_rows_have_the_rotation_and_elements_are_found_by_kind(
    tmp_path: Path, source: str, compiler: list[str]
) -> None:
    for name, template in HEADER.items():
        (tmp_path / name).write_text((TEMPLATES / template).read_text())
    (tmp_path / source).write_text(PROGRAM)
    (tmp_path / "request.txt").write_text(REQUEST)
    strict = ["-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined"]
    subprocess.run([*compiler, *strict, "-o", "program", source], cwd=tmp_path, check=True)
    done = subprocess.run(
        ["./program", "request.txt", "trajectory.csv"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    said = ["spring 0", "spring 2", "rod -1", "other plane", "others 0"]
    assert done.stderr.splitlines() == said
    (row,) = csv.DictReader(io.StringIO((tmp_path / "trajectory.csv").read_text()))
    assert {name: float(text) for name, text in row.items()} == {
        "t": 0.1,
        "body": 3,
        **dict(zip(("x", "y", "z", "vx", "vy", "vz"), range(1, 7), strict=True)),
        **dict(zip(("qw", "qx", "qy", "qz"), (0.5, -0.5, 0.5, 0.5), strict=True)),
        **dict(zip(("wx", "wy", "wz"), (7, 8, 9.1), strict=True)),
    }
