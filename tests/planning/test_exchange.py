"""Programs that run elsewhere: what is exported is enough to run them, and what comes back is
judged.
"""

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

from refdem.core.finding import Record
from refdem.core.parameters import labelled
from refdem.core.store import Store
from refdem.core.trajectory_csv import COLUMNS
from refdem.errors import UsageError
from refdem.planning.exchange import FORMAT, MANIFEST, RUNS, exported, judged
from refdem.planning.specification import Entry

TOML = """
[engine]
name = "far"
command = ["./far", "{request}", "{trajectory}"]
supports = ["spring"]
[[engine.methods]]
name = "leapfrog"
order = 2
symplectic = true
reversible = true
conserves = ["momentum"]
"""


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    path = tmp_path / "refdem.toml"
    path.write_text(TOML)
    return path


def written(toml: Path, folder: Path, *cases: str) -> list[str]:
    """The runs that an export waits for."""
    store = Store(toml.parent / "store.sqlite")
    waiting = exported(
        folder,
        [toml],
        [Entry(case) for case in cases or ("harmonic-oscillator",)],
        3,
        store,
        lambda *_: None,
    )
    store.close()
    return waiting


def record(toml: Path, folder: Path) -> Record:
    """What is found in the folder."""
    store = Store(toml.parent / "store.sqlite")
    (found,) = (
        sheet for sheet in judged(folder, store, lambda *_: None) if isinstance(sheet, Record)
    )
    store.close()
    return found


def run(folder: Path, pull: float = 1.0) -> None:
    """What a program far away would do in one folder: leapfrog on a spring to the origin."""
    asked = json.loads((folder / "request.json").read_text())
    assert (folder / "request.txt").read_text().startswith("format 1\nmethod leapfrog\n")
    (body,), (spring,), times = (
        asked["scene"]["bodies"],
        asked["scene"]["elements"],
        np.array(asked["times"]),
    )
    center = np.array(spring["anchor_b"])
    rate = pull * spring["stiffness"] / body["mass"]
    x = np.array(body["position"])
    v = np.array(body["velocity"])
    rows = [",".join(COLUMNS)]
    stride = asked["stride"]
    h = (times[1] - times[0]) / stride
    for n, t in enumerate(times):
        for _ in range(stride if n else 0):
            v = v - h / 2 * rate * (x - center)
            x = x + h * v
            v = v - h / 2 * rate * (x - center)
        rows.append(",".join(map(repr, [float(t), 0, *x.tolist(), *v.tolist()])) + "," * 7)
    (folder / "trajectory.csv").write_text("\n".join(rows) + "\n")


def test_what_comes_back_is_judged_and_what_goes_on_from_it_is_written_next(
    toml: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "to-run"
    first = written(toml, folder)
    assert (folder / RUNS).read_text().split() == first
    for name in first:
        run(folder / name)
    before = record(toml, folder)
    assert {f.outcome for f in before.findings} == {"pass", "error"}
    assert "`refdem export` into the same folder" in next(
        f.sentence for f in before.findings if f.outcome == "error"
    )
    second = written(toml, folder)
    assert second
    assert not set(second) & set(first)
    for name in second:
        run(folder / name)
    after = record(toml, folder)
    assert {f.outcome for f in after.findings} == {"pass"}
    assert "reversal" in {f.check for f in after.findings}
    assert written(toml, folder) == []


def test_the_folder_of_a_run_is_named_after_its_case_program_method_and_step(
    toml: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "to-run"
    labels = ("harmonic-oscillator", "harmonic-oscillator[x0=-3/2]", "harmonic-oscillator[x0=3/2]")
    store = Store(tmp_path / "store.sqlite")
    entries = [Entry(*labelled(label)) for label in labels]
    names = exported(folder, [toml], entries, 3, store, lambda *_: None)
    store.close()
    # On some file systems names that differ by case alone are one name.
    assert len({name.lower() for name in names}) == len(names)
    of_case: dict[str, set[float]] = {}
    for name in names:
        case, program, method, step, digest = name.split("_")
        asked = json.loads((folder / name / "request.json").read_text())
        assert (program, method) == ("far", "leapfrog")
        assert step == f"step={asked['step']:.6g}"
        assert re.fullmatch("[0-9a-f]{16}(-[0-9]+)?", digest)
        of_case.setdefault(case, set()).add(asked["scene"]["bodies"][0]["position"][0])
    plain = "harmonic-oscillator"
    assert set(of_case) == {plain, f"{plain}-x0=-1.5", f"{plain}-x0=1.5"}
    assert -1.5 in of_case[f"{plain}-x0=-1.5"]
    assert 1.5 in of_case[f"{plain}-x0=1.5"]
    assert {1.5, -1.5}.isdisjoint(of_case[plain])


def test_a_folder_with_names_of_an_older_format_is_refused(toml: Path, tmp_path: Path) -> None:
    folder = tmp_path / "to-run"
    written(toml, folder)
    manifest = folder / MANIFEST
    text = manifest.read_text()
    assert text.count(f'"format": {FORMAT}') == 1
    manifest.write_text(text.replace(f'"format": {FORMAT}', '"format": 1'))
    with pytest.raises(UsageError, match=f"has format 1; expected {FORMAT}: export again"):
        record(toml, folder)


def test_a_missing_trajectory_is_an_error(toml: Path, tmp_path: Path) -> None:
    folder = tmp_path / "to-run"
    names = written(toml, folder)
    for name in names[1:]:
        run(folder / name)
    found = record(toml, folder)
    (error,) = (f for f in found.findings if f.outcome == "error")
    assert f"{names[0]}/trajectory.csv is missing" in error.sentence


def test_a_wrong_force_fails_from_afar(toml: Path, tmp_path: Path) -> None:
    folder = tmp_path / "to-run"
    for name in written(toml, folder):
        run(folder / name, pull=1.001)
    assert "error/x" in {
        f"{f.check}/{f.quantity}" for f in record(toml, folder).findings if f.outcome == "fail"
    }


def test_a_refusal_comes_back_as_a_file(toml: Path, tmp_path: Path) -> None:
    folder = tmp_path / "to-run"
    for name in written(toml, folder):
        (folder / name / "unsupported.txt").write_text("no springs here\n")
    (finding,) = record(toml, folder).findings
    assert finding.outcome == "unsupported"
    assert "no springs here" in finding.sentence


def test_a_folder_of_another_export_is_not_mixed_up(toml: Path, tmp_path: Path) -> None:
    written(toml, tmp_path / "to-run")
    with pytest.raises(UsageError, match="the export of other cases"):
        written(toml, tmp_path / "to-run", "harmonic-oscillator", "pendulum")


@pytest.mark.parametrize(
    ("text", "says"), [(None, "No such file"), ("{}", "missing required field"), ("[", "manifest")]
)
def test_a_folder_without_a_good_manifest_is_refused(
    toml: Path, tmp_path: Path, text: str | None, says: str
) -> None:
    folder = tmp_path / "other"
    folder.mkdir()
    if text is not None:
        (folder / MANIFEST).write_text(text)
    with pytest.raises(UsageError, match=says):
        record(toml, folder)


def test_the_export_of_another_refdem_is_refused(toml: Path, tmp_path: Path) -> None:
    folder = tmp_path / "to-run"
    written(toml, folder)
    manifest = folder / MANIFEST
    manifest.write_text(manifest.read_text().replace('"refdem": "', '"refdem": "9'))
    with pytest.raises(UsageError, match="export again"):
        record(toml, folder)


def test_mass_properties_come_back_as_a_table(toml: Path, tmp_path: Path) -> None:
    toml.write_text(
        TOML.replace('"spring"', '"solid:cuboid"')
        .replace("order = 2", 'answers = "solid"')
        .partition("symplectic")[0]
    )
    names = written(toml, tmp_path / "out", "moments-of-inertia")
    for name in names:
        asked = json.loads((tmp_path / "out" / name / "request.json").read_text())
        rows = ["solid,mass,x,y,z,xx,yy,zz,xy,xz,yz"]
        for solid in asked["problem"]["solids"]:
            if not solid.get("hollow"):
                sides = solid["shape"].get("sides")
            else:
                sides = None
            if sides:
                mass = solid["density"] * sides[0] * sides[1] * sides[2]
            else:
                mass = ""
            rows.append(
                f"{solid['name']},{mass!r},,,,,,,,," if sides else f"{solid['name']},,,,,,,,,,"
            )
        (tmp_path / "out" / name / "trajectory.csv").write_text("\n".join(rows) + "\n")
    found = {
        finding.quantity: finding.outcome
        for finding in record(toml, tmp_path / "out").findings
        if finding.check == "error"
    }
    assert found["cuboid.mass"] == "pass"
    assert "ellipsoid.mass" not in found


@pytest.mark.parametrize("levels", [1, 2])
def test_an_export_of_few_levels_is_written(tmp_path: Path, levels: int) -> None:
    path = tmp_path / "refdem.toml"
    path.write_text(TOML.replace('["spring"]', '["contact:rigid", "plane"]'))
    store = Store(tmp_path / "store.sqlite")
    case = [Entry("hard-wall")]
    waiting = exported(tmp_path / "out", [path], case, levels, store, lambda *_: None)
    store.close()
    assert waiting


def put(path: Path, kind: str, target: Path) -> None:
    """Puts what is no plain file at a path: a link to a file of this machine, a pipe, a folder."""
    path.unlink(missing_ok=True)
    if kind == "link":
        path.symlink_to(target)
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        path.mkdir()


KINDS = ("link", "pipe", "folder")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", [MANIFEST, "far.toml", "far-answers.jsonl"])
def test_what_comes_back_in_place_of_a_file_is_neither_followed_nor_waited_for(
    toml: Path, tmp_path: Path, name: str, kind: str
) -> None:
    folder = tmp_path / "to-run"
    written(toml, folder)
    secret = tmp_path / "secret"
    secret.write_text((folder / name).read_text() if (folder / name).exists() else "{}")
    put(folder / name, kind, secret)
    with pytest.raises(UsageError, match=f"{name}.*expected a plain file"):
        record(toml, folder)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["unsupported.txt", "trajectory.csv"])
def test_a_run_with_such_a_file_is_an_error_and_tells_nothing_of_this_machine(
    toml: Path, tmp_path: Path, name: str, kind: str
) -> None:
    folder = tmp_path / "to-run"
    names = written(toml, folder)
    for other in names:
        run(folder / other)
    secret = tmp_path / "secret"
    secret.write_text("the password is swordfish")
    put(folder / names[0] / name, kind, secret)
    found = record(toml, folder)
    assert "error" in {finding.outcome for finding in found.findings}
    sentences = " ".join(finding.sentence for finding in found.findings)
    assert "swordfish" not in sentences
    assert name in sentences


def test_of_a_reason_without_end_only_the_end_is_read(toml: Path, tmp_path: Path) -> None:
    folder = tmp_path / "to-run"
    names = written(toml, folder)
    for name in names:
        path = folder / name / "unsupported.txt"
        with path.open("wb") as file:
            file.truncate(2**36)
            file.seek(0, os.SEEK_END)
            file.write("\nno springs on Saturdays, at 20 °C".encode())
    found = record(toml, folder)
    assert {finding.outcome for finding in found.findings} == {"unsupported"}
    assert "no springs on Saturdays, at 20 °C" in found.findings[0].sentence
