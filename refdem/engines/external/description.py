"""refdem.toml: the description of a program by its author, its claims and its gate."""

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from refdem.core.deviation import Deviation
from refdem.core.engine import Method
from refdem.core.outside import one_line
from refdem.engines.external.features import FEATURES

Picture = Literal["shifted", "rotated", "boosted", "mirrored", "relabelled", "rescaled", "delayed"]
ReportedEvent = Literal["contact", "release"]
Law = Literal["energy", "momentum", "angular-momentum", "constraint"]

Feature = Annotated[str, Meta(extra_json_schema={"enum": sorted(FEATURES)})]


def doc(words: str) -> Any:
    """The description of a field in the output of `refdem schema toml`."""
    return Meta(description=words)


class MethodTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One method of the program and its claims."""

    name: Annotated[str, doc("comes to the program as `method` of the request")]
    summary: str = ""
    answers: Literal["motion", "solid"] = "motion"
    control: Annotated[
        Literal["step", "tolerance", "exact"],
        doc(
            "what the request sets: the step [s] with its `stride`, the number of steps from each"
            " sample to the next, which the program counts (it never compares times), or a"
            " tolerance"
        ),
    ] = "step"
    order: Annotated[int, doc("claimed: errors fall as step**order")] = 0
    order_with: Annotated[
        dict[str, int], doc("the lower order with a feature of the scene, such as contact = 1")
    ] = {}
    constant: Annotated[
        float, doc("C of the bound C (1 + t/tau) (h/tau)**order, in units of the scales")
    ] = 1.0
    constant_reason: str = ""
    conserves: Annotated[list[Law], doc("kept to round-off, whatever the step")] = []
    reversible: Annotated[
        bool, doc("with velocities reversed it returns to its start, to round-off")
    ] = False
    symplectic: Annotated[bool, doc("no secular drift of energy, also where bodies turn")] = False
    backward: Annotated[
        bool, doc("it accepts sample times that decrease; the step stays positive")
    ] = False
    differenced_velocities: Annotated[
        bool, doc("velocities are differences of places over a step h, which rounds them by u r/h")
    ] = False
    locates_events: Annotated[
        bool,
        doc("events are reported at their own times, not at the end of the step that detects them"),
    ] = False
    cuts_steps: Annotated[
        bool,
        doc("steps end at each kink of the force: where a contact begins, sticks, slips or ends"),
    ] = False
    tells: Annotated[
        list[ReportedEvent],
        doc(
            "kinds of events of which it reports every one, between bodies and at walls, so that a"
            " missing one is detected even in a run without any"
        ),
    ] = []
    complete_state: Annotated[
        bool, doc("a run can go on from positions, velocities, attitudes and omegas alone")
    ] = True
    deterministic: Annotated[bool, doc("the same request gives the same bits")] = True
    threads: Annotated[
        bool,
        doc(
            "a request may have `threads` above 1, and any number of them gives the same bits;"
            " one run on two threads is then compared with that on one"
        ),
    ] = False

    differentiates: Annotated[
        bool,
        doc(
            "a request may name numbers of the scene as `sensitivities`; the program then writes"
            " the derivatives of its states by them to {sensitivities}"
        ),
    ] = False

    def method(self, engine: "EngineTable") -> Method:
        """The method as the checks use it.

        A method with staggered velocities cannot continue from its end state, and mass properties
        have no step.
        """
        fields = msgspec.structs.asdict(self)
        fields["conserves"] = frozenset(self.conserves)
        fields["tells"] = frozenset(self.tells)
        fields["summary"] = one_line(self.summary)
        fields["constant_reason"] = one_line(self.constant_reason)
        fields["complete_state"] = self.complete_state and engine.velocity_time == "synchronous"
        if self.answers == "solid":
            fields |= {
                "control": "exact",
                "knows": frozenset(name for name in engine.supports if name.startswith("solid:")),
            }
        summed = self.control == "step"
        return Method(
            **fields,
            precision=engine.precision,
            velocity_time=engine.velocity_time,
            summed_clock=summed,
        )


class EngineTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The program: its command (never a shell), what belongs to it, what it can do."""

    name: str
    install: Annotated[str, doc("what to do on a machine without the program, in a few words")] = ""
    command: Annotated[
        list[str],
        doc(
            "argv, run in an empty folder; {request} {request_txt} {trajectory} {events} stand for"
            " files, events as CSV time,kind,body; {trajectory_npy} for a trajectory as an array"
            " in NumPy's format, {sensitivities} for derivatives as CSV"
        ),
    ]
    methods: list[MethodTable]
    inputs: Annotated[
        list[str],
        doc(
            "patterns of files below this one whose change makes results stale, sources for"
            " instance"
        ),
    ] = []
    version_command: list[str] = []
    supports: Annotated[
        list[Feature], doc("what its scenes may have; a case that needs more is left out")
    ] = []
    precision: Literal["double", "single"] = "double"
    velocity_time: Annotated[
        Literal["synchronous", "minus-half-step"],
        doc(
            "minus-half-step: velocities and omegas of a row hold half a step before its t, at the"
            " first row too"
        ),
    ] = "synchronous"
    may_refuse: Annotated[
        list[Picture],
        doc(
            "images of a scene (shifted, rotated, mirrored) that it may refuse with exit status 77"
            " although it runs the scene itself; any other is an error"
        ),
    ] = []
    serve: Annotated[
        bool,
        doc(
            "the program stays alive: it reads requests as lines of JSON on standard input, with"
            " the paths of files, and answers each with a line; its command names no files"
        ),
    ] = False
    start_timeout: Annotated[
        float, doc("[s] with `serve`, that it may take until it says that it is ready")
    ] = 60.0
    warm_up: Annotated[
        float,
        doc(
            "[s] with `serve`, that a request may take beyond `timeout` until the program says that"
            " it is warm, after a compilation for instance"
        ),
    ] = 0.0
    timeout: Annotated[float, doc("[s] a run may take")] = 60.0
    budget: Annotated[float, doc("[s] a gate may take")] = 600.0
    memory: Annotated[
        float | None, doc("[GB] a process of a run may take; without it 9/10 of what there is")
    ] = None


class GateTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What its gate runs: cases (none: all that the program supports), levels, baseline."""

    cases: Annotated[
        list[str],
        doc(
            "`pendulum` or `pendulum[theta0=2 mass=3]`; none: all that it supports, some at several"
            " settings, and the probes of `refdem smoke`"
        ),
    ] = []
    levels: int = 4
    baseline: str = "refdem-baseline.jsonl"


class AuditTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One setting of the program: its default, the value that the driver sets, the reason, and the
    page or source that documents the default.
    """

    setting: str
    default: str
    used: str
    why: str
    link: str = ""


class Description(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The contents of a refdem.toml file."""

    engine: EngineTable
    audit: Annotated[
        list[AuditTable], doc("settings of the program that its driver sets or leaves alone")
    ] = []
    gate: GateTable = GateTable()
    expected: list[Deviation] = []
