"""The request as lines of text says what the JSON says, to the last bit."""

import json

import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.request_comments import commented
from refdem.core.request_text import request_text
from refdem.scene import Body


def request(case: str, **given: str) -> Request:
    problem = discovery.case(case).at(samples="3", **given).problem
    return Request(problem=problem, method="verlet", step=problem.interval / 4)


def leaves(key: str, value: object) -> dict[str, object]:
    """Every leaf of a JSON value by its dotted key, and the length of every list."""
    if isinstance(value, dict):
        return {
            k: v
            for name, part in value.items()
            for k, v in leaves(f"{key}.{name}".lstrip("."), part).items()
        }
    if isinstance(value, list):
        return {f"{key}.count": len(value)} | {
            k: v for n, part in enumerate(value) for k, v in leaves(f"{key}.{n}", part).items()
        }
    if value is None:
        return {}
    return {key: value}


@pytest.mark.parametrize(
    ("case", "given"),
    [
        (
            "two-spheres",
            {"damping": "1", "angle": "1/3", "friction": "1/4", "spins": "0,0,1/7,0,0,-2"},
        ),
        ("free-rigid-body", {"attitude": "1,2,3,4"}),
        ("pendulum", {}),
        ("newtons-first-law", {"member": "stack"}),
    ],
)
def test_text_and_json_agree_to_the_last_bit(case: str, given: dict[str, str]) -> None:
    asked = request(case, **given)
    lines = dict(line.split(" ", 1) for line in request_text(asked).splitlines())
    expected = leaves("", json.loads(asked.to_json()))
    assert list(lines) == list(expected)
    for key, value in expected.items():
        text = lines[key]
        if isinstance(value, bool):
            assert text == str(int(value)), key
        elif isinstance(value, float):
            assert float(text) == value, key
            assert {".", "e"} & set(text), key
        else:
            assert text == str(value), key


def test_no_line_has_more_than_a_key_and_a_word() -> None:
    assert all(len(line.split()) == 2 for line in request_text(request("two-spheres")).splitlines())


def test_a_method_controlled_by_tolerance_has_no_step() -> None:
    asked = Request(problem=request("pendulum").problem, method="dopri", tolerance=1e-6)
    assert "\nstep " not in request_text(asked)
    assert "\ntolerance 9.9999999999999995e-07\n" in request_text(asked)


def test_a_comment_comes_before_the_first_line_of_what_it_explains_and_once() -> None:
    asked = request("two-spheres")
    lines = list(commented(asked))
    assert [line for line in lines if not line.startswith("# ")] == request_text(asked).splitlines()
    comments = "\n".join(line for line in lines if line.startswith("# "))
    bodies = " ".join((Body.__doc__ or "").split())
    assert comments.replace("\n# ", " ").count(bodies[:60]) == 1
    first_of_body = next(n for n, line in enumerate(lines) if line.startswith("scene.bodies.0."))
    assert lines[first_of_body - 1].startswith("# ")
    second_of_body = next(n for n, line in enumerate(lines) if line.startswith("scene.bodies.1."))
    assert not lines[second_of_body - 1].startswith("# ")
    for name in ("scene.elements.count", "scene.elements.0."):
        place = next(n for n, line in enumerate(lines) if line.startswith(name))
        assert lines[place - 1].startswith("# "), name
