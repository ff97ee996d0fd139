"""What holds for every folder of validation/codes, whether its code is installed or not."""

import ast
import importlib
import json
import re
import shutil
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from refdem.core import codes, discovery
from refdem.core.parameters import labelled
from refdem.engines.external.description import Description
from refdem.engines.external.sense import read
from refdem.planning.deviations import of_engine

CODES = Path(__file__).resolve().parents[3] / "validation/codes"
NAMES = sorted(path.parent.name for path in CODES.glob("*/refdem.toml"))
IN_PYTHON = sorted(path.parent.name for path in CODES.glob("*/requirements.in"))
IN_JAVASCRIPT = sorted(path.parent.name for path in CODES.glob("*/package.json"))
OF_DEBIAN = sorted(path.parent.name for path in CODES.glob("*/debian.txt"))
FIELD = sorted(IN_PYTHON + IN_JAVASCRIPT + OF_DEBIAN)
"""Those with an environment of their own, which `make field` makes."""
DEVIATIONS = sorted(CODES.glob("*/deviations/*.*"))


@pytest.mark.parametrize("name", NAMES)
def test_the_description_makes_sense_and_bears_the_name_of_its_folder(name):
    description: Description = read(CODES / name / "refdem.toml")
    assert description.engine.name == name
    assert discovery.engine(name).name == name


@pytest.mark.parametrize("name", NAMES)
def test_every_case_of_the_gate_can_be_asked(name):
    cases = read(CODES / name / "refdem.toml").gate.cases
    assert cases
    for label in cases:
        case, given = labelled(label)
        assert discovery.case(case).at(**given).label


@pytest.mark.parametrize("name", NAMES)
def test_the_baseline_is_that_of_the_gate(name):
    lines = (CODES / name / "refdem-baseline.jsonl").read_text().splitlines()
    header, *findings = map(json.loads, lines)
    assert header["engine"] == name
    assert header["why"]
    cases = {finding["id"].partition(f"/{name}/")[0] for finding in findings}
    asked = {case.partition("[")[0] for case in read(CODES / name / "refdem.toml").gate.cases}
    assert {case.partition("[")[0] for case in cases} == asked


@pytest.mark.parametrize("name", NAMES)
def test_every_expected_deviation_is_of_a_case_of_the_gate(name):
    description = read(CODES / name / "refdem.toml")
    cases = {case.partition("[")[0] for case in description.gate.cases}
    methods = {method.name for method in description.engine.methods}
    for deviation in description.expected:
        assert deviation.case in cases
        assert deviation.method in methods
        assert deviation.link.startswith("https://")


EXPECTED = CODES.parent / "expected"
OF_ENGINES = [
    deviation
    for path in sorted(EXPECTED.glob("*.toml"))
    for deviation in of_engine(discovery.engine(path.stem))
]
"""The deviations of the engines that come with refdem."""


def is_exact(link):
    """True for a link to a page below the top page of a site, and for a file of a version."""
    place = urlsplit(link)
    parts = [part for part in place.path.split("/") if part not in ("", "en", "stable", "latest")]
    return place.scheme == "https" and bool(parts)


def scripts_of(text, folder):
    """The scripts without refdem that a text names; each is there."""
    names = re.findall(r"deviations/[\w.]+\.(?:py|js|cpp)", text)
    for name in names:
        assert (folder / name).is_file(), name
    return names


def names_its_evidence(reason, folder):
    """True if a reason begins with "Unexplained", or names a script or the version of a code."""
    is_unexplained = reason.startswith("Unexplained")
    names_version = bool(re.search(r"(?:[A-Z]\w+|pymunk|package) \d+\.\d+", reason))
    return is_unexplained or names_version or bool(scripts_of(reason, folder))


@pytest.mark.parametrize(
    ("link", "exact"),
    [
        ("https://rapier.rs/", False),
        ("https://exudyn.readthedocs.io/en/latest/", False),
        ("http://www.pymunk.org/en/latest/pymunk.html", False),
        ("https://www.pymunk.org/en/latest/pymunk.html#pymunk.Space.iterations", True),
        ("https://github.com/dimforge/rapier/blob/v0.35.2/src/dynamics/rigid_body.rs", True),
    ],
)
def test_a_link_to_a_top_page_is_not_exact(link, exact):
    assert is_exact(link) == exact


@pytest.mark.parametrize("name", NAMES)
def test_a_reason_names_a_script_or_a_version_and_links_to_the_page(name):
    description = read(CODES / name / "refdem.toml")
    for deviation in description.expected:
        assert names_its_evidence(deviation.reason, CODES / name), deviation.reason
        assert is_exact(deviation.link), deviation.link
    for line in description.audit:
        assert is_exact(line.link), line.setting
        scripts_of(f"{line.default} {line.used} {line.why}", CODES / name)


@pytest.mark.parametrize(
    "deviation", OF_ENGINES, ids=lambda d: f"{d.case}-{d.method}-{d.check}-{d.quantity}"
)
def test_a_reason_of_an_engine_names_a_script_or_a_version_and_links_to_the_page(deviation):
    assert names_its_evidence(deviation.reason, EXPECTED), deviation.reason
    assert is_exact(deviation.link), deviation.link


@pytest.mark.parametrize("path", sorted(EXPECTED.glob("deviations/*.py")), ids=lambda p: p.stem)
def test_a_deviation_of_an_engine_is_shown_without_refdem_and_told_of(path):
    assert "refdem" not in modules_of(path)
    audits = CODES.parents[1].glob("refdem/engines/*/audit.py")
    told = "".join(file.read_text() for file in (*EXPECTED.glob("*.toml"), *audits))
    assert f"deviations/{path.name}" in told


@pytest.mark.parametrize("path", sorted(CODES.rglob("*.py")), ids=str)
def test_every_driver_and_script_compiles(path):
    tree = ast.parse(path.read_text(), str(path))
    assert ast.get_docstring(tree)


@pytest.mark.parametrize("name", IN_PYTHON)
def test_every_requirement_is_pinned_with_digests(name):
    folder = CODES / name
    asked = {
        re.split(r"[=<>]", line)[0].lower().replace("_", "-")
        for line in (folder / "requirements.in").read_text().splitlines()
        if line and not line.startswith("#")
    }
    blocks = re.split(r"^(?=\w)", (folder / "requirements.txt").read_text(), flags=re.MULTILINE)
    pinned = {block.partition("==")[0].lower(): block for block in blocks if "==" in block}
    assert asked <= set(pinned)
    assert all("--hash=sha256:" in block for block in pinned.values())


@pytest.mark.parametrize("name", IN_JAVASCRIPT)
def test_every_package_of_node_is_pinned_with_a_digest(name):
    asked = json.loads((CODES / name / "package.json").read_text())["dependencies"]
    locked = json.loads((CODES / name / "package-lock.json").read_text())["packages"]
    assert locked.pop("")["dependencies"] == asked
    assert all(package["integrity"].startswith("sha512-") for package in locked.values())
    versions = {path.removeprefix("node_modules/"): p["version"] for path, p in locked.items()}
    assert {package: versions[package] for package in asked} == asked


@pytest.mark.parametrize("name", OF_DEBIAN)
def test_every_package_of_debian_is_pinned_with_a_digest(name):
    title, *packages = (CODES / name / "debian.txt").read_text().splitlines()
    assert title.startswith("# ")
    assert packages
    for package in packages:
        assert re.fullmatch(r"[a-z0-9.+-]+=[\w.:+~-]+ --hash=sha256:[0-9a-f]{64}", package)


@pytest.mark.parametrize("name", FIELD)
def test_a_code_of_the_field_stays_alive_and_says_how_it_is_installed(name):
    description = read(CODES / name / "refdem.toml")
    assert description.engine.serve
    assert description.engine.install == f"install it with: make field CODES={name}"
    program, helper = ("python", "../served.py")
    if name in IN_JAVASCRIPT:
        program, helper = ("node", "../served.js")
    if name in OF_DEBIAN:
        program, helper = ("driver", "driver.cpp")
    assert description.engine.command[0] == f"../../../.venv-field/{name}/bin/{program}"
    assert description.audit
    assert helper in description.engine.inputs


def modules_of(path):
    """The first words of the modules that a script in Python, JavaScript or C++ imports."""
    if path.suffix == ".cpp":
        return set(re.findall(r"""#include [<"](\w+)""", path.read_text()))
    if path.suffix == ".js":
        return set(re.findall(r"""require\(["'][./]*([^."']+)""", path.read_text()))
    tree = ast.parse(path.read_text())
    modules = {
        name.name.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for name in node.names
    }
    modules |= {
        str(node.module).partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
    }
    return modules


@pytest.mark.parametrize("path", DEVIATIONS, ids=lambda path: f"{path.parts[-3]}/{path.stem}")
def test_a_deviation_is_shown_without_refdem_and_told_of_in_its_description(path):
    assert not modules_of(path) & {"refdem", "refdem_driver", "served", "border", "hinges"}
    told = (path.parents[1] / "refdem.toml").read_text()
    assert f"deviations/{path.name}" in told


@pytest.mark.parametrize("name", FIELD)
def test_a_code_that_is_not_there_is_listed_as_not_installed(name, tmp_path, monkeypatch):
    copy = tmp_path / "codes"
    shutil.copytree(CODES / name, copy / name)
    for shared in ("served.py", "served.js", "border.py", "hinges.py"):
        shutil.copy(CODES / shared, copy / shared)
    monkeypatch.setenv(codes.VARIABLE, str(copy))
    # Its environment would be three folders above the copy, where there is none.
    missing = discovery.engine(name).missing()
    assert missing is not None
    assert missing.endswith(f"install it with: make field CODES={name}")


def test_the_shared_quaternion_of_a_rotation_is_that_of_the_rotation(monkeypatch):
    monkeypatch.syspath_prepend(CODES)
    border = importlib.import_module("border")
    # Unit quaternions in binary fractions, each with another largest component, and half turns.
    for q in (
        (0.5, 0.5, 0.5, 0.5),
        (0.28, 0.96, 0.0, 0.0),
        (0.0, 1.0, 0.0, 0.0),
        (0.0, 0.6, 0.8, 0.0),
        (0.1, -0.1, -0.7, 0.7),
        (0.7, -0.7, 0.1, -0.1),
        (0.2, 0.4, 0.4, -0.8),
    ):
        rows = border.matrix(q)
        found = border.quaternion(rows)
        assert found[0] >= 0
        # q and -q are one rotation; ten times the few roundings of nine products.
        overlap = abs(sum(a * b for a, b in zip(q, found, strict=True)))
        assert abs(overlap - 1) < 1e-14


COLUMNS = (
    ("lammps", "gran"),
    ("lammps", "granular"),
    ("lammps-debian", "gran"),
    ("lammps-debian", "granular"),
    ("liggghts", "stiffness"),
    ("yade", "leapfrog"),
)
"""Code and method of each column of the table of the DEM canon."""


def largest_errors(code, method):
    """The largest error at the finest step by member of impact-benchmarks, from a baseline."""
    errors = {}
    for line in (CODES / code / "refdem-baseline.jsonl").read_text().splitlines()[1:]:
        finding = json.loads(line)
        label, found, _ = finding["id"].partition(f"/{code}/{method}/error/")
        if not found or label.partition("[")[0] != "impact-benchmarks":
            continue
        member = labelled(label)[1].get("member", "co-4")
        errors[member] = max(errors.get(member, 0.0), finding["value"])
    return errors


def test_the_table_of_the_dem_canon_is_that_of_the_baselines():
    page = (CODES.parents[1] / "reports/findings.md").read_text()
    section = page.partition("## The DEM canon in DEM codes")[2].partition("\n## ")[0]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if line[:2] == "| "]
    shown = {column: {} for column in COLUMNS}
    for member, *cells in rows[1:]:
        for column, cell in zip(COLUMNS, cells, strict=True):
            if re.fullmatch(r"\d\.\de[-+]\d\d", cell):
                shown[column][member] = cell
    for column in COLUMNS:
        errors = largest_errors(*column)
        assert errors
        assert shown[column] == {member: f"{error:.1e}" for member, error in errors.items()}
