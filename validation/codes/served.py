"""What the drivers that stay alive share: requests as lines, what a scene says, and trajectories.

Import it before the code: what the code prints then goes to standard error.
"""

import copy
import json
import os
import sys
from functools import partial
from pathlib import Path

import border
from border import UnsupportedError, cannot

NOT_SUPPORTED = 77
"""The exit status of a program that cannot run the scene of its request."""


class Scene:
    """A request, as drivers read it.

    `warm()` says that what had to be compiled is compiled, so that stepping is timed from there;
    `bodies` are those of the scene, `step` [s] and `stride` (steps from sample to sample) those of
    the request, `gravity` (3,) [m/s^2] the sum of all uniform fields; `sensitivities` are the keys
    of the numbers that the request asks derivatives by.
    """

    def __init__(self, request, known, warm=lambda: None):
        self.warm = warm
        self.request = request
        self.known = known
        self.sensitivities = request.get("sensitivities", [])
        self.method = request["method"]
        self.bodies = request["scene"]["bodies"]
        self.elements = request["scene"]["elements"]
        self.times = request["times"]
        self.step = request["step"]
        self.stride = request["stride"]
        self.rows = []
        self.slopes = []
        for element in self.elements:
            cannot(element["kind"] not in known, f"element {element['kind']}")
        cannot(any(body["fixed"] for body in self.bodies), "fixed bodies")
        fields = self.of_kind("uniform_gravity")
        self.gravity = [sum(field["g"][axis] for field in fields) for axis in range(3)]

    def of_kind(self, kind):
        """The elements of one kind."""
        return [element for element in self.elements if element["kind"] == kind]

    def rigid_contact(self):
        """The rigid contact law, or None; raises UnsupportedError for another."""
        laws = self.of_kind("contact")
        cannot(any(law["law"] != "rigid" for law in laws), "contact laws other than the rigid one")
        reversing = any(law.get("tangential_restitution", 0.0) for law in laws)
        cannot(reversing, "a tangential restitution")
        if laws:
            return laws[0]
        return None

    def chain(self):
        """The numbers of the bodies of a chain of rods, from that which is joined to the world on,
        and the place (3) [m] of the pivot; raises UnsupportedError for rods of another kind.
        """
        rods = self.of_kind("rod")
        held = [rod for rod in rods if rod["b"] == -1]
        cannot(len(held) != 1, "rods without one that is held by the world")
        cannot(any(any(rod["anchor_a"]) for rod in rods), "anchors off the centre")
        cannot(any(any(rod["anchor_b"]) for rod in rods if rod["b"] >= 0), "anchors off the centre")
        numbers = [held[0]["a"]]
        joins = [(rod["a"], rod["b"]) for rod in rods if rod["b"] >= 0]
        while joins:
            last = numbers[-1]
            following = [pair for pair in joins if last in pair]
            cannot(len(following) != 1, "rods other than a chain")
            joins.remove(following[0])
            numbers.append(sum(following[0]) - last)
        cannot(sorted(numbers) != list(range(len(self.bodies))), "rods other than a chain")
        return numbers, held[0]["anchor_b"]

    def moments(self, body, least=0.0):
        """The principal moments of inertia (3) [kg m^2] of a body; those of a point, which are 0,
        become `least` if the code takes no zero.
        """
        return [moment or least for moment in body["inertia"]]

    def sampled(self, advance, states):
        """Steps by `advance()`, `stride` of them from sample to sample, and keeps the rows of all
        bodies at each: position, velocity, attitude and omega from `states()`.
        """
        for sample, t in enumerate(self.times):
            if sample > 0:
                for _ in range(self.stride):
                    advance()
            for number, state in enumerate(states()):
                self.rows.append((t, number, *state))

    def with_numbers(self, dual):
        """The same scene, with `dual(value, k)` in place of the k-th number of `sensitivities`."""
        request = copy.deepcopy(self.request)
        for k, key in enumerate(self.sensitivities):
            replace_number(request, key, lambda value, k=k: dual(value, k))
        return Scene(request, self.known)

    def changes(self):
        """The derivative of the scene by each number of `sensitivities`: a scene in which all
        numbers that need not be whole are 0, but for that number, which is 1.
        """
        found = []
        for key in self.sensitivities:
            request = {**self.request, "scene": zeroed(self.request["scene"])}
            replace_number(request, key, lambda value: 1.0)
            found.append(Scene(request, self.known))
        return found

    def differentiated(self, dual, slopes_of):
        """Keeps the derivatives of the rows of a run in dual numbers; `slopes_of(number)` are those
        of a number by all `sensitivities`, or none for a constant.
        """
        for k, key in enumerate(self.sensitivities):
            for t, number, *vectors in dual.rows:
                slopes = [[component(slopes_of(x), k) for x in vector] for vector in vectors]
                self.slopes.append((key, t, number, *slopes))


def replace_number(request, key, another):
    """Puts `another(value)` in place of the number at a key."""
    *path, last = key.split(".")
    holder = request
    for word in path:
        holder = entry(holder, word)[1]
    place, value = entry(holder, last)
    holder[place] = another(value)


def zeroed(document):
    """A copy of a document with 0 for each number that need not be whole."""
    if isinstance(document, dict):
        return {name: zeroed(value) for name, value in document.items()}
    if isinstance(document, list):
        return [zeroed(value) for value in document]
    if isinstance(document, float):
        return 0.0
    return document


def entry(holder, word):
    """Where a list or a table has an entry, and the entry."""
    place = word
    if isinstance(holder, list):
        place = int(word)
    return place, holder[place]


def component(slopes, k):
    """The k-th derivative; 0 of a constant, which has none."""
    if len(slopes) == 0:
        return 0.0
    return slopes[k]


def half_sides(shape):
    """The half sides (3) [m] of a polyhedron that is a box along the axes of its body."""
    corners = {tuple(corner) for corner in shape["vertices"]}
    half = [max(corner[axis] for corner in corners) for axis in range(3)]
    signs = (-1.0, 1.0)
    expected = {
        (a * half[0], b * half[1], c * half[2]) for a in signs for b in signs for c in signs
    }
    cannot(corners != expected, "polyhedra other than boxes about their centre")
    return half


def answer(solve, known, asked, warm=lambda: None):
    """One run of a request, whose files are `asked`; raises UnsupportedError."""
    request, trajectory, *sensitivities = asked
    scene = Scene(json.loads(Path(request).read_text()), known, warm)
    solve(scene)
    border.write(trajectory, scene.rows)
    if scene.slopes:
        border.write_slopes(*sensitivities, scene.slopes)


def run(solve, *known):
    """Answers requests until standard input ends, or the one request of the command line.

    `solve(scene)` fills `scene.rows`; scenes with elements of kinds other than `known` are refused.
    """
    if len(sys.argv) > 2:
        try:
            answer(solve, known, sys.argv[1:])
        except UnsupportedError as reason:
            print(reason, file=sys.stderr)
            sys.exit(NOT_SUPPORTED)
        return
    said({"ready": True})
    for line in sys.stdin:
        asked = json.loads(line)
        number = asked["id"]
        outcome = {"done": True}
        try:
            files = (asked["request"], asked["trajectory"], asked["sensitivities"])
            answer(solve, known, files, partial(said, {"id": number, "warm": True}))
        except UnsupportedError as reason:
            outcome = {"unsupported": str(reason)}
        except Exception as error:
            outcome = {"failed": f"{type(error).__name__}: {error}"}
        said({"id": number} | outcome)


def said(line):
    """Writes one line of JSON to whom asked."""
    print(json.dumps(line), file=ANSWERS, flush=True)


# Standard output is for answers alone: whatever a library prints goes to standard error. A program
# that prints before its script runs has the number of that output in its environment.
ANSWERS = os.fdopen(os.dup(int(os.environ.get("ANSWERS", "1"))), "w")
os.dup2(2, 1)
