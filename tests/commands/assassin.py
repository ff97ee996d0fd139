"""Runs refdem, or is a program of it, and ends a process of that command at a moment of its work.

usage: assassin.py refdem WORD ... runs the command; assassin.py REQUEST TRAJECTORY, and
assassin.py alone with requests on standard input, answers as a right program for a mass on a
spring. The environment has the kill: KILL_AT, the moment (a place in refdem and the number of the
call, or `program`), KILL_WHO and KILL_BY, the number of the signal. Each command kills once.
"""

import importlib
import json
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from tests.foreign.served import program

WORDS = {
    "refdem": "assassin.py\0refdem",
    "worker": "spawn_main",
    "tracker": "resource_tracker",
    "supervisor": "supervisor.py",
    "guard": "supervisor.py",
}
"""What is in the command line of each kind of process."""


def kin() -> "Iterator[tuple[int, str]]":
    """Numbers and command lines of all processes with the store of this command."""
    store = f"REFDEM_STORE={os.environ['REFDEM_STORE']}\0".encode()
    for path in Path("/proc").glob("[0-9]*"):
        try:
            if store in (path / "environ").read_bytes():
                yield int(path.name), (path / "cmdline").read_bytes().decode()
        except OSError:
            # It has ended since it was listed, or cannot be read any more.
            continue


def parent_of(process: int) -> int:
    """The number of the process that started another."""
    text = Path(f"/proc/{process}/stat").read_text()
    return int(text.rpartition(")")[2].split()[1])


def victims(who: str) -> "list[int]":
    """The processes of a kind; of the two of a supervisor, the one that guards is the parent."""
    if who == "itself":
        return [os.getpid()]
    found = [process for process, words in kin() if WORDS[who] in words]
    if who == "guard":
        return [process for process in found if parent_of(process) not in found]
    if who == "supervisor":
        return [process for process in found if parent_of(process) in found]
    return found


def kill() -> None:
    """Ends what the environment says, the first time that a process of this command comes here."""
    try:
        os.mkdir(os.environ["KILL_MARK"])
    except FileExistsError:
        return
    number = int(os.environ["KILL_BY"])
    who = os.environ["KILL_WHO"]
    if who == "group":
        os.killpg(0, number)
    elif who == "everything":
        hit([process for process, _ in kin() if process != os.getpid()], number)
        os.kill(os.getpid(), number)
    else:
        hit(victims(who), number)


def hit(processes: "list[int]", number: int) -> None:
    """Sends the signal to each process; there must be one."""
    assert processes, os.environ["KILL_WHO"]
    for process in processes:
        os.kill(process, number)


def arm(place: str, call: int) -> None:
    """Lets the call of that number of a function of refdem kill before it does its work."""
    module_name, _, path = place.partition(":")
    *outer, name = path.split(".")
    owner: Any = importlib.import_module(module_name)
    for part in outer:
        owner = getattr(owner, part)
    before: Callable[..., Any] = getattr(owner, name)
    calls = iter(range(1, sys.maxsize))

    def armed(*given: Any, **named: Any) -> Any:
        if next(calls) == call:
            kill()
        return before(*given, **named)

    setattr(owner, name, armed)


def refdem(words: "list[str]") -> None:
    """The command, in a process that a shell might have started."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    place, _, call = os.environ["KILL_AT"].partition("#")
    if ":" in place:
        arm(place, int(call))
    from refdem.cli import main

    sys.argv = ["refdem", *words]
    main()


def answer(asked: "dict[str, str]") -> None:
    """Writes the right trajectory, with the program that the zoo of programs is made of."""
    if os.environ["KILL_AT"] == "program":
        kill()
    program.solved(asked)


def serve() -> None:
    """Answers requests until standard input ends."""
    print('{"ready": true}', flush=True)
    for line in sys.stdin:
        asked = json.loads(line)
        answer(asked)
        print(json.dumps({"id": asked["id"], "done": True}), flush=True)


def main(words: "list[str]") -> None:
    """The command, one run, or requests."""
    if words[:1] == ["refdem"]:
        refdem(words[1:])
    elif words:
        request, trajectory = words
        answer({"request": request, "trajectory": trajectory})
    else:
        serve()


if __name__ == "__main__":
    main(sys.argv[1:])
