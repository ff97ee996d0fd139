"""The mirror of density counts what it says."""

import density

PYTHON = '''"""A module."""

a, b = 1, 2  # packed
a, b = b, a
# A comment.
c = a if b else 0


def pairs(rows):
    """All of all."""
    return [x for row in rows for x in row]
'''


def test_what_is_packed_is_counted_and_a_swap_is_not(tmp_path):
    path = tmp_path / "module.py"
    path.write_text(PYTHON)
    found = density.Density()
    density.counted(path, found)
    assert found.packed == 1
    assert found.branches == 1
    assert found.nested == 1
    assert found.comments == 2
    assert found.lines == 5
    assert len(found.sizes) == 4
    assert found.functions == [(max(found.sizes[3:]), f"{path}:9 pairs")]


def test_c_is_counted_without_its_comments(tmp_path):
    (tmp_path / "kernel.c").write_text(
        "/* a ? b : c, x = 1, y = 2 */\nvoid f(void) {\n  int a = 1, b = 2;\n  a = b ? 1 : 2;\n}\n"
    )
    assert density.c_row(tmp_path) == "250.0 conditional expressions, 250.0 chained assignments"
    assert density.c_row(tmp_path / "none") == ""


def test_the_densest_functions_of_all_folders_come_last(tmp_path):
    for name, text in (
        ("one", "def f():\n    return 1\n"),
        ("two", "def g():\n    return 1 + 2\n"),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "module.py").write_text(text + "x = 1\n")
    lines = density.table([tmp_path / "one", tmp_path / "two"], worst=2).splitlines()
    assert lines[-2].endswith("two/module.py:1 g")
    assert lines[-1].endswith("one/module.py:1 f")
