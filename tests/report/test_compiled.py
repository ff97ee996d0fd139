"""Templates are compiled once, and again when they, Jinja or refdem have changed."""

import sys
from pathlib import Path

import pytest
from jinja2 import DictLoader, Environment

from refdem.core import fingerprint
from refdem.report import compiled, html

HELLO = "Hello {{ name }}"


class Counting(Environment):
    """An environment that counts how many templates it compiles."""

    compilations = 0

    def _generate(self, *arguments, **options):
        self.compilations += 1
        return super()._generate(*arguments, **options)


def greeting(folder: Path, text: str = HELLO) -> tuple[str, int]:
    """The page of a template, by a new environment, and how many templates that compiled."""
    cache = compiled.CompiledTemplates(folder)
    environment = Counting(loader=DictLoader({"page": text}), bytecode_cache=cache)
    page = environment.get_template("page").render(name="Euler")
    return page, environment.compilations


@pytest.fixture(autouse=True)
def writing(monkeypatch):
    """Bytecode is written, whatever this Python was told."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)


def test_a_template_is_compiled_once(tmp_path):
    assert greeting(tmp_path / "new") == ("Hello Euler", 1)
    assert greeting(tmp_path / "new") == ("Hello Euler", 0)


def test_a_changed_template_is_compiled_again(tmp_path):
    greeting(tmp_path)
    assert greeting(tmp_path, "Bye {{ name }}") == ("Bye Euler", 1)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("part", ["version_of", "of_refdem"])
def test_another_state_of_jinja_or_refdem_compiles_again(tmp_path, monkeypatch, part):
    greeting(tmp_path)
    monkeypatch.setattr(fingerprint, part, lambda *names: "another state")
    assert greeting(tmp_path) == ("Hello Euler", 1)
    assert greeting(tmp_path) == ("Hello Euler", 0)


def test_a_damaged_file_is_replaced(tmp_path):
    greeting(tmp_path)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    for damaged in (b"", whole[:-1], whole[:40], b"\0" * len(whole)):
        file.write_bytes(damaged)
        assert greeting(tmp_path) == ("Hello Euler", 1)
        assert file.read_bytes() == whole


def test_a_folder_that_cannot_be_written_ends_no_report(tmp_path):
    (tmp_path / "file").write_text("in the way")
    folder = tmp_path / "file" / "folder"
    assert greeting(folder) == ("Hello Euler", 1)
    assert greeting(folder) == ("Hello Euler", 1)


def test_nothing_is_written_where_python_writes_no_bytecode(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert greeting(tmp_path) == ("Hello Euler", 1)
    assert list(tmp_path.iterdir()) == []


def test_compiled_templates_lie_where_python_keeps_compiled_modules(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "pycache_prefix", None)
    beside = compiled.cache_beside(tmp_path)
    assert beside is not None
    assert beside.folder == tmp_path / "__pycache__"
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "prefix"))
    below = compiled.cache_beside(tmp_path)
    assert below is not None
    assert tmp_path / "prefix" in below.folder.parents
    monkeypatch.setattr(sys.implementation, "cache_tag", None)
    assert compiled.cache_beside(tmp_path) is None


def test_the_digest_of_refdem_does_not_see_compiled_templates(tmp_path):
    (tmp_path / "page.html").write_text(HELLO)
    before = fingerprint.of_tree(tmp_path)
    greeting(tmp_path / "__pycache__")
    assert len(list((tmp_path / "__pycache__").iterdir())) == 1
    assert fingerprint.of_tree(tmp_path) == before


def test_templates_of_reports_are_compiled_once(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path))
    html.environment().get_template("engines.html")
    kept = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert kept
    monkeypatch.setattr(html.Environment, "_generate", None)
    assert html.environment().get_template("engines.html").name == "engines.html"
