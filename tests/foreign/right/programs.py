"""Programs that are right: their sources, switches, and what each truly claims.

A program is one source of this folder compiled with some switches, and a refdem.toml written beside
it. Whatever a check says against one of them is a fault of the program or a false alarm.
"""

import json
import platform
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
FLAGS = ("-std=c11", "-D_DEFAULT_SOURCE", "-O2", "-Wall", "-Wextra", "-Werror")
SOFT = (
    "rotation",
    "spring",
    "spring:exponent",
    "spring:quadratic",
    "spring:cubic",
    "dashpot",
    "dashpot:van_der_pol",
    "drag",
    "force",
    "uniform_gravity",
    "central_field",
    "piecewise_field",
    "plane",
    "contact:linear",
    "contact:hertz",
    "friction",
    "periodic_box",
)
RODS = ("rod", "constraint", "spring", "uniform_gravity")
TURNING = ("rotation", "uniform_gravity")
RIGID = (
    "rotation",
    "uniform_gravity",
    "plane",
    "contact:rigid",
    "contact:tangential-restitution",
    "friction",
)
SLIDING = (
    "spring",
    "dashpot",
    "force",
    "uniform_gravity",
    "slider",
    "slider:belt",
    "slider:stribeck",
    "friction",
)


def _method(name: str, order: int, **claims: Any) -> dict[str, Any]:
    """A method and its claims; times may fall."""
    return {"name": name, "order": order, "backward": True, **claims}


TOUCH = {"contact": 1}
"""A step that holds a touch has an error of first order, whatever the method."""
LAGGING = {"contact": 1, "dashpot": 1, "drag": 1}
"""Forces of velocities that are half a step late."""
SPLIT: dict[str, Any] = {"symplectic": True, "conserves": ["momentum", "angular-momentum"]}
METHODS = {
    "kick-drift": _method("kick-drift", 1, **SPLIT),
    "drift-kick": _method("drift-kick", 1, **SPLIT),
    "verlet-predicted": _method("verlet-predicted", 2, order_with=TOUCH, reversible=True, **SPLIT),
    "verlet-half-step": _method(
        "verlet-half-step", 2, order_with=LAGGING, reversible=True, **SPLIT
    ),
    "verlet-iterated": _method("verlet-iterated", 2, order_with=TOUCH, reversible=True, **SPLIT),
    "yoshida": _method("yoshida", 4, order_with=TOUCH, reversible=True, **SPLIT),
    "midpoint": _method("midpoint", 2, order_with=TOUCH, conserves=["momentum"]),
    "heun": _method("heun", 2, order_with=TOUCH, conserves=["momentum"]),
    "rk4": _method("rk4", 4, order_with=TOUCH, conserves=["momentum"]),
    "dormand-prince": _method("dormand-prince", 5, order_with=TOUCH, conserves=["momentum"]),
    "implicit-midpoint": _method(
        "implicit-midpoint", 2, order_with=TOUCH, reversible=True, **SPLIT
    ),
}
LOOKING_BACK: dict[str, Any] = {
    "order_with": TOUCH,
    "complete_state": False,
    "conserves": ["momentum"],
}
"""Earlier steps are part of the state of these methods."""
MULTISTEP = {
    "stoermer": _method(
        "stoermer", 2, order_with=TOUCH, symplectic=True, differenced_velocities=True
    ),
    "beeman": _method("beeman", 2, **LOOKING_BACK),
    "newmark": _method(
        "newmark", 2, order_with=TOUCH, reversible=True, symplectic=True, conserves=["momentum"]
    ),
    "generalized-alpha": _method("generalized-alpha", 2, **LOOKING_BACK),
    "adams-bashforth-2": _method("adams-bashforth-2", 2, **LOOKING_BACK),
    "adams-bashforth-moulton-4": _method("adams-bashforth-moulton-4", 4, **LOOKING_BACK),
    "bdf2": _method("bdf2", 2, **LOOKING_BACK),
}
ADAPTIVE = _method("adaptive", 5, control="tolerance", conserves=["momentum"])
LEAPFROG = _method("leapfrog", 2, order_with=LAGGING, backward=False, conserves=["momentum"])
IN_SPACE = {"conserves": ["momentum", "angular-momentum"]}
TURNS = {
    "euler": _method("euler", 1, conserves=["momentum"]),
    "rk4": _method("rk4", 4, conserves=["momentum"]),
    "splitting": _method("splitting", 2, reversible=True, **SPLIT),
    "buss": _method("buss", 2, **IN_SPACE),
    "omelyan": _method("omelyan", 2, reversible=True, **IN_SPACE),
    "momentum-midpoint": _method("momentum-midpoint", 2, **IN_SPACE),
    "momentum-rk4": _method("momentum-rk4", 4, **IN_SPACE),
}
EVENT_DRIVEN = {"name": "event-driven", "control": "exact", "locates_events": True}
LATE = {"name": "late", "order": 1, "conserves": ["momentum"]}
MOREAU = {"name": "moreau", "order": 1, "conserves": ["momentum"], "complete_state": True}
SLIDERS = (
    {"name": "moreau", "order": 2, "order_with": {"friction": 1, "dashpot": 1}},
    {"name": "implicit-friction", "order": 1},
)
CONSTRAINED = (
    _method(
        "rattle", 2, reversible=True, symplectic=True, conserves=[*SPLIT["conserves"], "constraint"]
    ),
    _method("rk4", 4, conserves=["momentum"]),
)


@dataclass(frozen=True)
class Program:
    """A source with switches; `engine` has more lines of its refdem.toml."""

    name: str
    source: str
    supports: tuple[str, ...]
    methods: tuple[dict[str, Any], ...]
    switches: tuple[str, ...] = ()
    engine: dict[str, Any] = field(default_factory=dict)

    @property
    def has_events(self) -> bool:
        """True of the programs that tell contacts: at the ends of steps, so that one which chooses
        its steps by a tolerance tells none.
        """
        is_stepping = all(method.get("control") != "tolerance" for method in self.methods)
        return self.source in ("soft", "multistep", "rigid") and is_stepping

    def built(self, folder: Path, home_of_sources: Path = HERE) -> Path:
        """The refdem.toml of the program, compiled into a folder of its own below `folder`."""
        home = folder / self.name
        home.mkdir(parents=True, exist_ok=True)
        switches = [fused(switch) for switch in self.switches]
        sources = [str(home_of_sources / f"{self.source}.c")]
        output = ["-o", str(home / "program")]
        words = [word for words in switches for word in words]
        command = ["cc", *FLAGS, *words, *output, *sources, "-lm", "-pthread"]
        subprocess.run(command, check=True, timeout=120)
        path = home / "refdem.toml"
        path.write_text(self.description())
        return path

    def description(self) -> str:
        """The text of the refdem.toml."""
        command = ["./program"]
        if not self.engine.get("serve"):
            command += ["{request_txt}", "{trajectory}"]
            command += ["{events}"] * self.has_events
        engine = {
            "name": f"right-{self.name}",
            "command": command,
            "supports": list(self.supports),
            "timeout": 20,
            **self.engine,
        }
        tables = [f"[engine]\n{lines(engine)}"]
        tables += [f"[[engine.methods]]\n{lines(method)}" for method in self.methods]
        return "\n".join(tables)


def fused(switch: str) -> list[str]:
    """The words of the compiler for a switch: FUSED allows fused multiply-add where the processor
    has it.
    """
    if switch != "FUSED":
        return [f"-D{switch}"]
    words = ["-ffp-contract=fast"]
    cpu = Path("/proc/cpuinfo")
    if platform.machine() == "x86_64" and cpu.exists() and " fma " in cpu.read_text():
        words.append("-mfma")
    return words


def lines(table: dict[str, Any]) -> str:
    """A table of TOML: values as JSON has them, and one level of tables inline."""
    text = ""
    for name, value in table.items():
        if isinstance(value, dict):
            inline = ", ".join(f'"{key}" = {json.dumps(entry)}' for key, entry in value.items())
            text += f"{name} = {{ {inline} }}\n"
        else:
            text += f"{name} = {json.dumps(value)}\n"
    return text


def _some(methods: dict[str, dict[str, Any]], *names: str) -> tuple[dict[str, Any], ...]:
    """The methods of these names."""
    return tuple(methods[name] for name in names)


SINGLE = {"precision": "single"}
STAGGERED = {"velocity_time": "minus-half-step"}
PROGRAMS = (
    Program("soft", "soft", SOFT, tuple(METHODS.values())),
    Program("soft-adaptive", "soft", SOFT, (ADAPTIVE,), engine={"timeout": 20}),
    Program("soft-leapfrog", "soft", SOFT, (LEAPFROG,), engine=STAGGERED),
    Program(
        "soft-single",
        "soft",
        SOFT,
        _some(METHODS, "drift-kick", "verlet-predicted", "verlet-iterated", "midpoint", "rk4"),
        ("SINGLE",),
        SINGLE,
    ),
    Program("soft-leapfrog-single", "soft", SOFT, (LEAPFROG,), ("SINGLE",), SINGLE | STAGGERED),
    Program(
        "soft-fused",
        "soft",
        SOFT,
        _some(METHODS, "kick-drift", "verlet-half-step", "rk4", "dormand-prince"),
        ("FUSED",),
    ),
    Program(
        "soft-single-fused",
        "soft",
        SOFT,
        _some(METHODS, "verlet-predicted", "rk4"),
        ("SINGLE", "FUSED"),
        SINGLE,
    ),
    Program(
        "soft-compensated",
        "soft",
        SOFT,
        _some(METHODS, "kick-drift", "verlet-predicted"),
        ("COMPENSATED",),
    ),
    Program(
        "soft-two-writers",
        "soft",
        SOFT,
        _some(METHODS, "verlet-predicted"),
        ("TWO_WRITERS", "COUNTER32"),
    ),
    Program("soft-signs", "soft", SOFT, _some(METHODS, "verlet-predicted", "rk4"), ("SIGNS",)),
    Program(
        "soft-served",
        "soft",
        SOFT,
        _some(METHODS, "verlet-predicted"),
        engine={"serve": True},
    ),
    Program("multistep", "multistep", SOFT, tuple(MULTISTEP.values())),
    Program(
        "multistep-single",
        "multistep",
        SOFT,
        _some(MULTISTEP, "beeman", "newmark", "generalized-alpha", "adams-bashforth-2", "bdf2"),
        ("SINGLE",),
        SINGLE,
    ),
    Program("turning", "turning", TURNING, tuple(TURNS.values())),
    Program(
        "turning-single",
        "turning",
        TURNING,
        _some(TURNS, "splitting", "rk4", "buss", "omelyan", "momentum-rk4"),
        ("SINGLE",),
        SINGLE,
    ),
    Program(
        "turning-signs",
        "turning",
        TURNING,
        _some(TURNS, "splitting", "rk4"),
        ("SIGNS", "COUNTER32"),
    ),
    Program("turning-fused", "turning", TURNING, _some(TURNS, "splitting", "buss"), ("FUSED",)),
    Program("rigid", "rigid", RIGID, (EVENT_DRIVEN, LATE, MOREAU)),
    Program("rigid-single", "rigid", RIGID, (LATE, MOREAU), ("SINGLE",), SINGLE),
    Program("rigid-signs", "rigid", RIGID, (EVENT_DRIVEN, LATE), ("SIGNS",)),
    Program("rigid-served", "rigid", RIGID, (EVENT_DRIVEN,), engine={"serve": True}),
    Program("rods", "rods", RODS, CONSTRAINED),
    Program("rods-fused", "rods", RODS, CONSTRAINED[:1], ("FUSED",)),
    Program("rods-single", "rods", RODS, CONSTRAINED, ("SINGLE",), SINGLE),
    Program("sliding", "sliding", SLIDING, SLIDERS),
    Program("sliding-single", "sliding", SLIDING, SLIDERS, ("SINGLE",), SINGLE),
)
"""Each with some methods; a method of a program is what a pair of `alarms` judges."""
