"""A small program in Python with a refdem.toml beside it, and one misbehaviour a method."""

import sys
from pathlib import Path

import pytest

PROGRAM = """
import json, math, os, signal, subprocess, sys, time

VERSION = "1.0"
if sys.argv[1:] == ["--version"]:
    print(VERSION)
    sys.exit(0)
request, trajectory, events = sys.argv[1:]
asked = json.load(open(request))
method, times, h = asked["method"], asked["times"], asked["step"]
(body,), (spring,) = asked["scene"]["bodies"], asked["scene"]["elements"]
if sorted(os.listdir()) != ["request.json", "request.txt", "stderr.txt", "stdout.txt"]:
    sys.exit("the folder is not fresh: " + " ".join(os.listdir()))
if method == "refuses":
    sys.exit(print("loading ...\\nno springs on Saturdays", file=sys.stderr) or 77)
if method == "fails":
    sys.exit("segment 3: no convergence \\x1b[31m")
if method == "silent":
    sys.exit(0)
if method == "aborts":
    os.kill(os.getpid(), signal.SIGABRT)
MARK = "grandchild of " + os.path.abspath(__file__)
SLEEPS = [sys.executable, "-c", "import time; time.sleep(600)", MARK]
if method == "hangs":
    subprocess.Popen(SLEEPS)
    time.sleep(600)
if method == "leaves":
    subprocess.Popen(SLEEPS)
if method == "floods":
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
    with open("big", "w") as file:
        while True:
            file.write("x" * 2**20)
rate, x, v = spring["stiffness"] / body["mass"], body["position"][0], body["velocity"][0]
anchor = spring["anchor_b"][0]
rows = []
for n, t in enumerate(times):
    for _ in range(asked["stride"] if n else 0):
        v -= 0.5 * h * rate * (x - anchor)
        x += h * v
        v -= 0.5 * h * rate * (x - anchor)
    rows.append(f"{t!r},0,{x!r},0,0,{v!r},0,0,,,,,,,")
header = "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz"
if method == "short":
    rows.pop()
if method == "long":
    rows.append(rows[-1])
if method == "nan":
    rows[5] = rows[5].replace(",0,0,", ",nan,0,", 1)
if method == "words":
    rows[5] = "here comes sample five"
if method == "late":
    rows = [str(float(r.split(",")[0]) + h) + r[r.index(","):] for r in rows]
if method == "other-body":
    rows[4] = rows[4].replace(",0,", ",1,", 1)
if method == "no-header":
    header = rows[0]
if method == "binary":
    open(trajectory, "wb").write(bytes(range(256)) * 9)
    sys.exit(0)
with open(trajectory, "w") as file:
    file.write("\\n".join([header, *rows]) + "\\n")
if method in ("symbolic-link", "hard-link"):
    os.rename(trajectory, "elsewhere.csv")
    (os.symlink if method == "symbolic-link" else os.link)("elsewhere.csv", trajectory)
if method == "pipe":
    os.remove(trajectory)
    os.mkfifo(trajectory)
if method == "silent-pipe":
    os.remove("stderr.txt")
    os.mkfifo("stderr.txt")
    sys.exit("a pipe in the place of stderr.txt")
if method == "session":
    for _ in range(3):
        subprocess.Popen(SLEEPS, start_new_session=True, cwd="/", env={})
if method == "forks":
    for _ in range(3):
        if os.fork() == 0:
            os.setsid()
            if os.fork() == 0:
                os.execv(sys.executable, SLEEPS)
            os._exit(0)
if method == "breeds":
    FORKS = "[os.setsid() for _ in range(6) if os.fork() == 0]"
    SLEEPS[2] = "import os, time; " + FORKS + "; time.sleep(600)"
    subprocess.Popen(SLEEPS)
if method == "deep":
    for _ in range(3000):
        os.mkdir("d")
        os.chdir("d")
if method == "locked":
    os.makedirs("locked/inside")
    os.chmod("locked", 0)
if method == "kills-its-parent":
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(600)
if method == "reserves":
    import mmap
    MAP_NORESERVE = 0x4000
    kind = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | MAP_NORESERVE
    reserved = mmap.mmap(-1, 2**44, kind)
if method == "devours":
    kept = []
    while True:
        kept.append(bytearray(2**24))
with open(events, "w") as file:
    file.write("time,kind,body\\n0.5,turn,0\\n")
    if method == "bad-event":
        file.write("soon,turn,0\\n")
"""

MISBEHAVIOURS = """
refuses fails silent aborts hangs leaves floods short long nan words late other-body no-header
symbolic-link hard-link pipe silent-pipe session forks breeds deep locked kills-its-parent
devours binary bad-event
"""
METHODS = ("good", "reserves", *MISBEHAVIOURS.split())


def described(
    folder: Path,
    *,
    command: str = "",
    more: str = "",
    methods: "list[str] | tuple[str, ...]" = METHODS,
) -> Path:
    """A refdem.toml in `folder` for the program there."""
    words = (
        command
        or f'["{sys.executable}", "program.py", "{{request}}", "{{trajectory}}", "{{events}}"]'
    )
    tables = [
        f'[[engine.methods]]\nname = "{name}"\norder = 2\nsymplectic = true\nreversible ='
        ' true\nconserves = ["momentum"]\n'
        for name in methods
    ]
    text = (
        f'[engine]\nname = "small"\ncommand = {words}\nsupports = ["spring",'
        f' "dimension:1"]\ntimeout = 600\n{more}\n'
    )
    path = folder / "refdem.toml"
    path.write_text(text + "\n".join(tables))
    return path


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the small program; failed runs are kept beside a store of its own."""
    folder = tmp_path / "small"
    folder.mkdir()
    (folder / "program.py").write_text(PROGRAM)
    described(folder, more=f'version_command = ["{sys.executable}", "program.py", "--version"]')
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "kept" / "store.sqlite"))
    return folder
