"""A right program for a mass on a spring that stays alive, and one misbehaviour a method: a zoo.

usage: program.py [START], requests as lines on standard input; START is a misbehaviour before the
first request. usage: program.py REQUEST TRAJECTORY runs one request and ends. Every LATER method
behaves well until its process has answered one request.
"""

import contextlib
import fcntl
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

MARK = "grandchild of " + os.path.abspath(__file__)
"""In the command line of every process that is left behind, so that a test finds it."""
SLEEPS = [sys.executable, "-c", "import time; time.sleep(600)", MARK]
HEADER = "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz"
KEPT = {"answered": 0}
"""What the program keeps from one request to the next."""
METHODS = {}
"""What a method does instead of an answer, with the request as it was asked."""


def method(function):
    """A misbehaviour of a request."""
    METHODS[function.__name__.replace("_", "-")] = function
    return function


def say(**words):
    """One line of answer."""
    print(json.dumps(words), flush=True)


def trajectory(request, kept=None):
    """Rows of velocity Verlet for a mass on a spring; what is `kept` replaces the scene's."""
    (body,) = request["scene"]["bodies"]
    (spring,) = request["scene"]["elements"]
    stiffness = spring["stiffness"] / body["mass"]
    anchor = spring.get("anchor_b", [0.0])[0]
    x = body["position"][0]
    v = body.get("velocity", [0.0])[0]
    if kept is not None:
        stiffness = kept.setdefault("stiffness", stiffness)
        v = kept.get("velocity", v)
    h = request["step"]
    start = request["times"][0]
    rows = []
    for n in range(len(request["times"])):
        for _ in range(request["stride"] if n > 0 else 0):
            v -= h / 2 * stiffness * (x - anchor)
            x += h * v
            v -= h / 2 * stiffness * (x - anchor)
        rows.append([start + n * request["stride"] * h, 0, x, 0, 0, v, 0, 0])
    if kept is not None and kept.get("keeps_velocity"):
        kept["velocity"] = v
    return rows


def write(path, rows):
    """The rows as CSV."""
    with open(path, "w") as out:
        print(HEADER, file=out)
        for row in rows:
            print(*row, *[""] * 7, sep=",", file=out)


def good(asked):
    """The right answer."""
    with open(asked["request"]) as file:
        request = json.load(file)
    write(asked["trajectory"], trajectory(request))
    say(id=asked["id"], done=True)


def solved(asked):
    """Writes the right trajectory, without an answer."""
    with open(asked["request"]) as file:
        write(asked["trajectory"], trajectory(json.load(file)))


def says_bytes(line):
    """Bytes on standard output."""
    sys.stdout.buffer.write(line)
    sys.stdout.buffer.flush()


def later(asked):
    """Whether the process has answered a request; one more has come now."""
    KEPT["answered"] += 1
    return KEPT["answered"] > 1


# Ends ----------------------------------------------------------------------------------------


@method
def hangs(asked):
    subprocess.Popen(SLEEPS)
    time.sleep(600)


@method
def crashes(asked):
    print("about to crash", file=sys.stderr, flush=True)
    os.kill(os.getpid(), signal.SIGSEGV)


@method
def crashes_later(asked):
    if later(asked):
        os.abort()
    good(asked)


@method
def exits(asked):
    sys.exit(3)


@method
def half_a_line(asked):
    print('{"id": "' + asked["id"] + '", "do', end="", flush=True)
    os._exit(0)


@method
def ends_after_each_answer(asked):
    good(asked)
    os._exit(0)


@method
def closes_its_output(asked):
    os.close(1)
    time.sleep(600)


@method
def leaves_the_answer_to_a_child(asked):
    if os.fork() == 0:
        time.sleep(60)
        good(asked)
    os._exit(0)


@method
def hands_its_pipes_on(asked):
    good(asked)
    subprocess.Popen(SLEEPS, start_new_session=True)
    os._exit(0)


@method
def starts_anew(asked):
    good(asked)
    os.execv(sys.executable, [sys.executable, os.path.abspath(__file__), *sys.argv[1:]])


@method
def kills_its_parent(asked):
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(600)


@method
def takes_its_folder_away_and_ends(asked):
    os.rmdir(os.getcwd())
    os._exit(5)


@method
def closes_its_input(asked):
    os.close(0)
    good(asked)
    time.sleep(600)


@method
def takes_more_memory_each_time(asked):
    """64 MB more a request, up to 1 GB."""
    kept = KEPT.setdefault("blocks", [])
    if len(kept) < 16:
        kept.append(b"x" * 2**26)
    good(asked)


@method
def takes_all_memory(asked):
    kept = []
    while True:
        kept.append(b"x" * 2**26)


# Time ----------------------------------------------------------------------------------------


@method
def stops_itself(asked):
    os.kill(os.getpid(), signal.SIGSTOP)


@method
def warms_up_and_hangs(asked):
    say(id=asked["id"], warm=True)
    time.sleep(600)


@method
def answers_drop_by_drop_for_ever(asked):
    while True:
        says_bytes(b"{")
        time.sleep(0.05)


@method
def ends_its_line_with_a_carriage_return(asked):
    solved(asked)
    says_bytes(json.dumps({"id": asked["id"], "done": True}).encode() + b"\r")
    time.sleep(600)


# Says ----------------------------------------------------------------------------------------


@method
def prints(asked):
    print("step 1 of 100")
    good(asked)


@method
def prints_after_its_answer(asked):
    solved(asked)
    print(json.dumps({"id": asked["id"], "done": True}) + "\ngoodbye", flush=True)


@method
def answers_twice(asked):
    good(asked)
    say(id=asked["id"], done=True)


@method
def answers_another(asked):
    say(id="7000", done=True)


@method
def answers_without_id(asked):
    say(done=True)


@method
def answers_everything(asked):
    say(id=asked["id"], done=True, failed="no")


@method
def answers_a_list(asked):
    say_list = json.dumps(["done", asked["id"]])
    print(say_list, flush=True)


@method
def answers_deep(asked):
    print("[" * 50_000, flush=True)


@method
def answers_in_colour(asked):
    print("\x1b[31mred\x1b[0m", flush=True)


@method
def answers_without_end(asked):
    while True:
        print("x" * 4096, end="", flush=True)


@method
def messages_without_end(asked):
    while True:
        print("x" * 4096, file=sys.stderr)


@method
def says_done_and_wrote_nothing(asked):
    say(id=asked["id"], done=True)


@method
def writes_a_huge_file(asked):
    # Python ignores the signal of a file that grows too large, and sees an error instead.
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
    with open(asked["trajectory"], "wb") as out:
        while True:
            out.write(b"x" * 2**20)


@method
def fails(asked):
    say(id=asked["id"], failed="the solver diverged at t = 3\x1b[31m")


@method
def refuses(asked):
    say(id=asked["id"], unsupported="no springs on Saturdays")


@method
def refuses_later(asked):
    if later(asked):
        refuses(asked)
    else:
        good(asked)


def ends_with(asked, done):
    """The right trajectory, and another value of `done` than true."""
    with open(asked["request"]) as file:
        write(asked["trajectory"], trajectory(json.load(file)))
    say(id=asked["id"], done=done)


@method
def done_is_false(asked):
    ends_with(asked, False)


@method
def done_is_null(asked):
    ends_with(asked, None)


@method
def done_is_a_word(asked):
    ends_with(asked, "yes")


@method
def done_is_one(asked):
    ends_with(asked, 1)


@method
def refuses_without_a_word(asked):
    say(id=asked["id"], unsupported=True)


@method
def fails_without_a_word(asked):
    say(id=asked["id"], failed=None)


@method
def is_not_warm(asked):
    say(id=asked["id"], warm=False)
    good(asked)


@method
def warms_up_for_ever(asked):
    """Each of these lines would move the limit on the time of the request."""
    for _ in range(100_000):
        say(id=asked["id"], warm=True)
        time.sleep(0.02)


@method
def answers_in_utf16(asked):
    solved(asked)
    line = json.dumps({"id": asked["id"], "done": True}) + "\n"
    says_bytes(line.encode("utf-16-le"))


@method
def answers_in_no_text(asked):
    solved(asked)
    says_bytes(b'{"id": "%s", "done": true, "by": "\xff\xfe"}\n' % asked["id"].encode())


@method
def answers_with_nul(asked):
    solved(asked)
    says_bytes(b'{"id": "%s", "done": true}\0\n' % asked["id"].encode())


@method
def answers_two_requests_in_a_line(asked):
    solved(asked)
    both = [json.dumps({"id": str(int(asked["id"]) + n), "done": True}) for n in range(2)]
    print(*both, flush=True)


@method
def says_one_word_twice(asked):
    solved(asked)
    print('{"id": "' + asked["id"] + '", "done": false, "done": true}', flush=True)


@method
def counts_without_end(asked):
    solved(asked)
    print('{"id": "' + asked["id"] + '", "done": true, "steps": ' + "9" * 50_000 + "}", flush=True)


@method
def answers_by_no_number(asked):
    print("NaN", flush=True)


@method
def says_an_empty_line(asked):
    solved(asked)
    print(flush=True)
    say(id=asked["id"], done=True)


@method
def says_ready_again(asked):
    solved(asked)
    say(ready=True)
    say(id=asked["id"], done=True)


@method
def fails_in_commands_at_length(asked):
    """Just within the length of a line."""
    say(id=asked["id"], failed="::error file=a::no\n##[error]no\x1b[2J\u202e" * 1200)


@method
def answers_the_next_request_too(asked):
    solved(asked)
    both = [json.dumps({"id": str(int(asked["id"]) + n), "done": True}) for n in range(2)]
    print(*both, sep="\n", flush=True)


@method
def is_warm_too_late(asked):
    solved(asked)
    both = [json.dumps({"id": asked["id"], word: True}) for word in ("done", "warm")]
    print(*both, sep="\n", flush=True)


# Files ---------------------------------------------------------------------------------------


@method
def answers_into_a_pipe(asked):
    os.mkfifo(asked["trajectory"])
    KEPT["pipe"] = os.open(asked["trajectory"], os.O_RDWR)
    say(id=asked["id"], done=True)


@method
def holds_its_answer(asked):
    """Who opens the file waits until the kernel takes it from the program, or is told to come
    later.
    """
    solved(asked)
    signal.signal(signal.SIGIO, signal.SIG_IGN)
    KEPT["held"] = os.open(asked["trajectory"], os.O_WRONLY)
    fcntl.fcntl(KEPT["held"], fcntl.F_SETLEASE, fcntl.F_WRLCK)
    say(id=asked["id"], done=True)


@method
def lifts_its_limit(asked):
    """Eight times of what a file may have."""
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    with open(asked["trajectory"], "wb") as out:
        out.write(b"x" * 2**25)
    say(id=asked["id"], done=True)


@method
def takes_the_folder_of_its_request_away(asked):
    shutil.rmtree(os.path.dirname(asked["request"]))
    say(id=asked["id"], done=True)


# Keeps ---------------------------------------------------------------------------------------


@method
def keeps_velocity(asked):
    KEPT["keeps_velocity"] = True
    with open(asked["request"]) as file:
        write(asked["trajectory"], trajectory(json.load(file), KEPT))
    say(id=asked["id"], done=True)


@method
def keeps_stiffness(asked):
    with open(asked["request"]) as file:
        write(asked["trajectory"], trajectory(json.load(file), KEPT))
    say(id=asked["id"], done=True)


@method
def softens_after_a_small_mass(asked):
    """What comes after a scene of small mass has a spring of half the stiffness."""
    with open(asked["request"]) as file:
        request = json.load(file)
    mass = request["scene"]["bodies"][0]["mass"]
    if KEPT.get("is_small"):
        request["scene"]["elements"][0]["stiffness"] /= 2
    write(asked["trajectory"], trajectory(request))
    KEPT["is_small"] = mass < 1
    say(id=asked["id"], done=True)


@method
def draws_lots(asked):
    """Answers that differ from process to process, and from request to request."""
    with open(asked["request"]) as file:
        rows = trajectory(json.load(file))
    rows[1][2] += 1e-9 * time.monotonic_ns() % 1e-6
    write(asked["trajectory"], rows)
    say(id=asked["id"], done=True)


@method
def answers_with_the_trajectory_before(asked):
    with open(asked["request"]) as file:
        rows = trajectory(json.load(file))
    write(asked["trajectory"], KEPT.get("rows", rows))
    KEPT["rows"] = rows
    say(id=asked["id"], done=True)


@method
def remembers_on_disk(asked):
    """The first process that was ever asked answers otherwise than all that come later."""
    memory = os.path.join(os.path.dirname(os.path.abspath(__file__)), "memory")
    is_later = KEPT.setdefault("is_later", os.path.exists(memory))
    open(memory, "w").close()
    with open(asked["request"]) as file:
        rows = trajectory(json.load(file))
    rows[1][2] += 1e-6 * is_later
    write(asked["trajectory"], rows)
    say(id=asked["id"], done=True)


# Harmless ------------------------------------------------------------------------------------


@method
def warms_up(asked):
    time.sleep(0.4)
    say(id=asked["id"], warm=True)
    good(asked)


@method
def takes_the_id_for_a_number(asked):
    good(asked | {"id": int(asked["id"])})


@method
def writes_an_array(asked):
    import numpy as np

    with open(asked["request"]) as file:
        rows = trajectory(json.load(file))
    np.save(asked["trajectory_npy"], np.array([row + [np.nan] * 7 for row in rows]))
    say(id=asked["id"], done=True)


@method
def talks_on_standard_error(asked):
    print("thinking " * 10, file=sys.stderr, flush=True)
    good(asked)


@method
def answers_in_more_words(asked):
    solved(asked)
    words = '"method": "another", "seconds": NaN, "error": 1e999, "\\u001b[31m": [null], "": {}'
    print('{"id": "' + asked["id"] + '", "done": true, ' + words + "}", flush=True)


@method
def answers_byte_by_byte(asked):
    solved(asked)
    for byte in json.dumps({"id": asked["id"], "done": True}).encode() + b"\n":
        says_bytes(bytes([byte]))
        time.sleep(0.001)


@method
def ends_its_lines_as_windows(asked):
    solved(asked)
    says_bytes(json.dumps({"id": asked["id"], "done": True}).encode() + b"\r\n")


@method
def goes_and_takes_its_folder_away(asked):
    if "gone" not in KEPT:
        KEPT["gone"] = os.getcwd()
        os.rmdir(KEPT["gone"])
    good(asked)


@method
def leaves_children_in_sessions(asked):
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    subprocess.Popen(SLEEPS, start_new_session=True, cwd="/", env={})
    good(asked)


@method
def floods_between_requests(asked):
    good(asked)
    sys.stderr.write("thinking\n" * 2**20)


@method
def closes_its_errors(asked):
    with contextlib.suppress(OSError):
        os.close(2)
    good(asked)


@method
def takes_the_name_of_its_messages(asked):
    os.symlink("/dev/zero", os.path.join(os.path.dirname(asked["request"]), "stderr.txt"))
    good(asked)


@method
def empties_its_request(asked):
    solved(asked)
    open(asked["request"], "w").close()
    say(id=asked["id"], done=True)


@method
def stays_for_ever(asked):
    KEPT["stays"] = True
    good(asked)


# Starts --------------------------------------------------------------------------------------


READINESS = {
    "says-no": b'{"ready": false}\n',
    "twice": b'{"ready": true}\n{"ready": true}\n',
    "no-line-end": b'{"ready": true}',
    "more-words": b'{"version": "3.1", "ready": true, "most": Infinity}\r\n',
}
"""What is said instead of the line that it is ready."""


def start(how):
    """What happens before the first request."""
    if how == "dies":
        sys.exit("libphysics.so.3 is not there")
    if how == "dies-after-half-a-line":
        print('{"rea', end="", flush=True)
        os._exit(4)
    if how == "banner":
        print("PHYSICS 3.1 (c) 1999", flush=True)
    if how == "silent":
        time.sleep(600)
    if how == "never-reads":
        print('{"ready": true}', flush=True)
        for number in range(1, 100_000):
            say(id=str(number), failed="guessed")
        time.sleep(600)
    if how in READINESS:
        says_bytes(READINESS[how])
    else:
        print('{"ready": true}', flush=True)
    if how == "goes":
        os._exit(6)
    if how == "no-line-end":
        time.sleep(600)


def stay():
    """Lives on, whatever it is told."""
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    time.sleep(600)


def main(words):
    """One run, or requests until standard input ends."""
    if len(words) == 2:
        with open(words[0]) as file:
            write(words[1], trajectory(json.load(file)))
        return
    start("".join(words))
    for line in sys.stdin:
        asked = json.loads(line)
        METHODS.get(asked["method"], good)(asked)
    if KEPT.get("stays"):
        stay()


if __name__ == "__main__":
    main(sys.argv[1:])
