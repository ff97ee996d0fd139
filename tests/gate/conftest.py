"""A small program under a gate: a harmonic oscillator by leapfrog, in plain Python, whose source a
test may spoil.
"""

import os
import sys

import pytest

PROGRAM = '''
"""usage: spring.py REQUEST TRAJECTORY"""
import json, sys
request = json.load(open(sys.argv[1]))
body, spring = request["scene"]["bodies"][0], request["scene"]["elements"][0]
if any(spring["anchor_b"]):
    print("springs hang at the origin only", file=sys.stderr)
    sys.exit(77)
times, h = request["times"], request["step"]
if times[1] < times[0]:
    h = -h
rate = spring["stiffness"] / body["mass"]
x, v = body["position"][0], body["velocity"][0]
with open(sys.argv[2], "w") as out:
    print("t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz", file=out)
    t = times[0]
    for n, sample in enumerate(times):
        if n:
            for _ in range(round((sample - times[n - 1]) / h)):
                v -= h / 2 * rate * x
                x += h * v
                v -= h / 2 * rate * x
                t += h
        print("%.17g,0,%.17g,0,0,%.17g,0,0,,,,,,," % (t, x, v), file=out)
'''
TOML = f"""
[engine]
name = "spring"
command = ["{sys.executable}", "spring.py", "{{request}}", "{{trajectory}}"]
version_command = ["{sys.executable}", "-c", "print('spring 1.0')"]
supports = ["spring", "dimension:1"]
may_refuse = ["shifted"]
timeout = 30
[[engine.methods]]
name = "leapfrog"
order = 2
reversible = true
symplectic = true
backward = true
[gate]
cases = ["harmonic-oscillator"]
levels = 3
"""


class Program:
    """The folder of the program, and its gate from the command line."""

    def __init__(self, folder, command_line):
        self.folder = folder
        self.command_line = command_line
        (folder / "spring.py").write_text(PROGRAM)
        (folder / "refdem.toml").write_text(TOML)

    def spoil(self, *change):
        text = (self.folder / "spring.py").read_text()
        assert text.count(change[0]) == 1
        (self.folder / "spring.py").write_text(text.replace(*change))

    def gate(self, *arguments, **environment):
        environment = (
            os.environ
            | {"REFDEM_STORE": str(self.folder / "store.sqlite"), "GITHUB_ACTIONS": "false"}
            | environment
        )
        return self.command_line("gate", *arguments, cwd=self.folder, env=environment)

    def bless(self):
        done = self.gate("--bless", "--why", "it was looked at")
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture
def program(tmp_path, command_line):
    return Program(tmp_path, command_line)
