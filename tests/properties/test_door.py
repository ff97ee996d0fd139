"""Only exact numbers go from a case to its truth, and from a truth into a proof: held by types, by
the source, and by perturbing floats.
"""

import ast
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import refdem
from refdem.cases.impact_benchmarks import MEMBERS
from refdem.certification.reproof import given_of
from refdem.core import discovery
from refdem.core.parameters import Parameters
from refdem.core.selection import Selection
from refdem.core.truth import Ball
from refdem.errors import NotCertifiedError
from refdem.truth import load
from refdem.truth.closed_forms.harmonic_oscillator import HarmonicOscillator
from refdem.truth.closed_forms.two_spheres import TwoSpheres
from refdem.truth.exact import number, vector
from refdem.truth.maps.rectangle import Rectangle
from refdem.truth.reals import Real, pi
from refdem.truth.refiner import Refiner
from refdem.truth.sphere_pair import sphere_pair
from refdem.truth.traced_field import traced

CASES = sorted(Path(refdem.__file__).with_name("cases").rglob("*.py"))
TRUTHS = sorted(Path(refdem.__file__).with_name("truth").rglob("*.py"))
ROUNDED = [0.5, np.float64(0.5), Decimal("0.5")]
ROUNDING = (
    "limit_denominator",
    "from_float",
    "from_decimal",
    "as_integer_ratio",
    "from_number",
    "Decimal",
    "decimal",
)
TEXTS = {"Fraction(default)", "map(Fraction, MATERIALS[numbers['material']])"}
"""What a case may make a Fraction of besides literals: texts of its own tables."""
ELEMENTARY = {
    "pi",
    "sin",
    "cos",
    "tan",
    "sqrt",
    "exp",
    "atan2",
    "acos",
    "asin",
    "gamma",
    "e",
    "tau",
}
GUESSES = {"collision.py": {"pi", "sqrt"}, "tumbling_stop.py": {"atan2"}}
"""What a proof will cost, and the arc of directions that it tries, may be guessed by rounded
numbers: no value comes from them.
"""
TINY = 1 + 2.0**-20


def motions():
    """Every case at its defaults, every member of the impact benchmarks, and every choice (of a
    flow, a law) that a certified set makes.
    """
    names = [
        name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
    ]
    found = [(name, {}) for name in names if name != "impact-benchmarks"] + [
        ("impact-benchmarks", {"member": m}) for m in MEMBERS
    ]
    for one in load():
        declared = {p.name: p for p in discovery.case(one.case).parameters}
        if one.case != "impact-benchmarks":
            chosen = {name: text for name, text in given_of(one).items() if declared[name].choices}
        else:
            chosen = {}
        if chosen and (one.case, chosen) not in found:
            found.append((one.case, chosen))
    return found


def is_literal(node):
    """A number or a text as it is written, or a sum, product and so on of such."""
    if isinstance(node, ast.BinOp):
        return is_literal(node.left) and is_literal(node.right)
    if isinstance(node, ast.UnaryOp):
        return is_literal(node.operand)
    return isinstance(node, ast.Constant) and isinstance(node.value, int | str)


def made_of_what_may_be_rounded(source):
    """The calls of a file that make a Fraction of something that is not written there."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        called = ast.unparse(node.func)
        makes = called == "Fraction" or (
            called == "map" and ast.unparse(node.args[0]) == "Fraction"
        )
        if makes and not all(map(is_literal, node.args)):
            found.append(ast.unparse(node))
    return found


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_no_case_makes_an_exact_number_of_a_rounded_one(path):
    source = path.read_text()
    assert set(made_of_what_may_be_rounded(source)) <= TEXTS
    names = {node.attr for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Attribute)}
    names |= {node.id for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Name)}
    assert names.isdisjoint(ROUNDING)


@pytest.mark.parametrize(
    "source",
    ["Fraction(1.25 * half)", "Fraction(getattr(v, 'x'))", "map(Fraction, sizes)", "Fraction(0.5)"],
)
def test_the_search_would_find_them(source):
    assert made_of_what_may_be_rounded(source) == [source]


@pytest.mark.parametrize("path", TRUTHS, ids=lambda path: path.stem)
def test_no_proof_knows_decimals_or_elementary_functions_of_binary64(path):
    """ceil, log2 and the like of a float choose a step or a precision; a sine, a root or pi of one
    would be a value.
    """
    tree = ast.parse(path.read_text())
    imported = [
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module == "math"
        for alias in node.names
    ]
    assert ELEMENTARY & set(imported) <= GUESSES.get(path.name, set())
    assert "decimal" not in {
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for alias in node.names
    }
    assert "decimal" not in {
        node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)
    }


@pytest.mark.parametrize("rounded", ROUNDED, ids=str)
def test_every_door_of_a_truth_refuses_a_rounded_number(rounded):
    one = Fraction(1)
    pair = sphere_pair(discovery.case("two-spheres").at().p)
    scale = {"r1.x": 1.0}
    with pytest.raises(TypeError, match="expected exact numbers"):
        TwoSpheres(Refiner.of(scale), type(pair)(**{**vars(pair), "damping": rounded}))
    with pytest.raises(TypeError, match="expected exact numbers"):
        TwoSpheres(Refiner.of(scale), type(pair)(**{**vars(pair), "masses": (one, rounded)}))
    with pytest.raises(TypeError, match="expected exact numbers"):
        Rectangle((one, one), (rounded, one), (one, one), {"position.x": 1.0})
    with pytest.raises(TypeError, match="expected an int, a Fraction or a Real"):
        traced(lambda y: [y[0] * rounded], 1)
    with pytest.raises(TypeError, match="expected a number"):
        number({"mass": rounded}, "mass")
    with pytest.raises(TypeError, match="expected exact numbers"):
        Ball(one, rounded)
    with pytest.raises(TypeError, match="expected a vector"):
        vector({"masses": rounded}, "masses")


def test_a_number_that_follows_from_parameters_passes_every_door():
    pair = sphere_pair(discovery.case("two-spheres").at().p)
    TwoSpheres(Refiner.of({"r1.x": 1.0}), type(pair)(**{**vars(pair), "damping": pi()}))
    outputs, _ = traced(lambda y: [y[0] * pi() + pi()], 1)
    assert len(outputs) == 1


def answers(instance):
    """Scalars, and the values early in the motion, as far as they are certified."""
    truth = instance.truth().refined(15)
    if "duration" not in instance.p:
        times = []
    else:
        times = [Fraction(1, 2**10), Fraction(1, 32)]
    length = Fraction(float(instance.scales.duration))
    found = {}
    for ask in (truth.scalars, *(lambda part=part: truth.at(length * part) for part in times)):
        try:
            found |= {(len(found), name): ball for name, ball in ask().items()}
        except NotCertifiedError:
            found[len(found), "not certified"] = None
    return found


def moved_away(case, given, monkeypatch):
    """Which balls move when every float that the case can get from its parameters, or from what
    follows from them, is moved by 1e-6.
    """
    instance = case.at(**given)
    if "duration" in instance.p:
        given = {**given, "duration": str(Fraction(instance.scales.duration) / 8)}
        instance = case.at(**given)
    lasting = instance.scales
    plain = answers(instance)
    rounded = Parameters.__getattr__
    nearest = Real.__float__

    def moved(self, name):
        value = rounded(self, name)
        is_whole = name in self.declared and self.declared[name].whole
        if is_whole or isinstance(value, str | None):
            return value
        return value * TINY

    monkeypatch.setattr(Parameters, "__getattr__", moved)
    monkeypatch.setattr(Real, "__float__", lambda self: nearest(self) * TINY)
    again = case.at(**given)
    vars(again)["scales"] = lasting
    shifted = answers(again)
    assert shifted.keys() == plain.keys()
    told = [key for key, ball in plain.items() if ball is not None]
    return [
        key
        for key in told
        if abs(plain[key].mid - shifted[key].mid) > plain[key].radius + shifted[key].radius
    ]


def words(value):
    """A setting as a test is named."""
    if isinstance(value, str):
        return value
    return "-".join(value.values())


@pytest.mark.parametrize(("case", "given"), motions(), ids=words)
def test_rounded_numbers_of_a_case_have_no_say_in_its_truth(case, given, monkeypatch):
    assert moved_away(discovery.case(case), given, monkeypatch) == []


def test_a_case_that_hands_its_truth_a_float_is_found(monkeypatch):
    class Rounded(type(discovery.case("harmonic-oscillator"))):
        def truth(self, p):
            scale = {q.name: q.scale for q in self.quantities(p)}
            exact = {name: p[name] for name in ("mass", "gravity", "x0", "v0")}
            return HarmonicOscillator(
                refiner=Refiner.of(scale), stiffness=Fraction(p.stiffness), **exact
            )

    assert len(moved_away(Rounded(), {}, monkeypatch)) > 2
