"""A right program for a mass on a spring, and one misbehaviour a method: a zoo.

usage: program.py REQUEST TRAJECTORY EVENTS, in the empty folder of a run. The method that is asked
for says which misbehaviour it is; `good` has none. modes.py says how each must end.
"""

import contextlib
import functools
import glob
import json
import mmap
import os
import shutil
import signal
import socket
import subprocess
import sys
import time

VERSION = "1.0"
MARK = "grandchild of " + os.path.abspath(__file__)
"""In the command line of every process that is left behind, so that a test finds it."""
SLEEPS = [sys.executable, "-c", "import time; time.sleep(600)", MARK]
FRESH = ["request.json", "request.txt", "stderr.txt", "stdout.txt"]
HEADER = "t,body,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz"
BEFORE = {}
"""What a method does before it computes anything."""
ROWS = {}
"""What a method makes of header and rows."""
AFTER = {}
"""What a method does when its trajectory is written."""


def before(function):
    """A misbehaviour at the start."""
    BEFORE[function.__name__.replace("_", "-")] = function
    return function


def rows(function):
    """A misbehaviour of what is written."""
    ROWS[function.__name__.replace("_", "-")] = function
    return function


def after(function):
    """A misbehaviour when the answer is there."""
    AFTER[function.__name__.replace("_", "-")] = function
    return function


def once(function):
    """A misbehaviour of the first run alone, so that it hits another program at most once."""

    @functools.wraps(function)
    def begun(*given):
        with contextlib.suppress(FileExistsError):
            os.mkdir(os.path.join(HOME, "begun"))
            function(*given)

    return begun


# Ends ----------------------------------------------------------------------------------------


@before
def refuses():
    print("loading ...\nno springs on Saturdays", file=sys.stderr)
    sys.exit(77)


@before
def refuses_in_silence():
    sys.exit(77)


@before
def fails():
    sys.exit("segment 3: no convergence \x1b[31m")


@before
def fails_in_silence():
    sys.exit(1)


@before
def says_that_it_failed_by_255():
    sys.exit(255)


@before
def silent():
    sys.exit(0)


@before
def aborts():
    os.kill(os.getpid(), signal.SIGABRT)


@before
def has_a_fault_of_segments():
    # A sanitizer that the program inherits would catch it.
    signal.signal(signal.SIGSEGV, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGSEGV)


@before
def kills_itself():
    os.kill(os.getpid(), signal.SIGKILL)


@before
def kills_its_parent():
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(600)


@before
def leaves_a_session_and_kills_its_parent():
    subprocess.Popen(SLEEPS, start_new_session=True, cwd="/", env={})
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(600)


@before
def kills_the_parent_of_its_parent():
    with open(f"/proc/{os.getppid()}/stat") as file:
        guard = int(file.read().rpartition(")")[2].split()[1])
    os.kill(guard, signal.SIGKILL)
    subprocess.Popen(SLEEPS, start_new_session=True, cwd="/", env={})
    sys.exit("it is done")


@before
def kills_its_group():
    os.killpg(0, signal.SIGKILL)


@before
def interrupts_its_parent():
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        os.kill(os.getppid(), number)


# Time ----------------------------------------------------------------------------------------


@before
def hangs():
    subprocess.Popen(SLEEPS)
    time.sleep(600)


@before
def turns_in_a_circle():
    while True:
        pass


@before
def stops_itself():
    os.kill(os.getpid(), signal.SIGSTOP)


@before
def hears_no_signal():
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGALRM):
        signal.signal(number, signal.SIG_IGN)
    time.sleep(600)


@before
def waits_for_input():
    # There is none: this ends at once.
    sys.stdin.read()


@before
def waits_for_a_pipe():
    os.mkfifo("pipe")
    with open("pipe") as file:
        file.read()


# Floods --------------------------------------------------------------------------------------


def unlimited():
    """The signal of a file that grows too large as C has it: an end."""
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)


@before
def floods():
    unlimited()
    with open("big", "w") as file:
        while True:
            file.write("x" * 2**20)


@before
def floods_its_output():
    unlimited()
    while True:
        sys.stdout.write("x" * 2**20)


@before
def floods_its_errors():
    unlimited()
    while True:
        sys.stderr.write("x\n" * 2**19)


@before
def devours():
    taken = []
    while True:
        taken.append(bytearray(2**24))


@before
def devours_among_orphans():
    """Orphans that end one after another wake whoever waits for processes again and again; the
    memory grows in the meantime, up to three times of what is allowed.
    """
    if os.fork() == 0:
        while True:
            if os.fork() == 0:
                if os.fork() == 0:
                    os._exit(0)
                os._exit(0)
            os.wait()
    taken = []
    while len(taken) < 96:
        taken.append(bytearray(2**24))
        time.sleep(0.01)


def shared_memory_is_filled():
    """Maps memory that other processes may share, block by block, and writes to every page; ends
    at three times of what is allowed.
    """
    taken = []
    while len(taken) < 96:
        block = mmap.mmap(-1, 2**24)
        block.write(b"x" * 2**24)
        taken.append(block)
        time.sleep(0.01)
    time.sleep(600)


@before
def devours_shared_memory():
    shared_memory_is_filled()


@before
def devours_the_shared_memory_of_an_orphan():
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            shared_memory_is_filled()
        os._exit(0)
    time.sleep(600)


@before
def reserves():
    # As the address sanitizer of C compilers does; this is no memory that is used.
    no_reserve = 0x4000
    kind = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | no_reserve
    BEFORE["reserved"] = mmap.mmap(-1, 2**44, kind)


@before
def opens_all_files():
    opened = []
    try:
        while True:
            opened.append(os.open(os.devnull, os.O_RDONLY))
    except OSError:
        for descriptor in opened:
            os.close(descriptor)


@before
def makes_many_files():
    # More than a process may hold open (1024).
    for number in range(1100):
        open(f"file {number}", "w").close()


# What it says --------------------------------------------------------------------------------


@before
def escapes():
    sys.exit("\x1b[2J\x1b]0;title\x07\x1b[31m it is red \x9b31m")


@before
def commands_a_workflow():
    sys.exit("::error file=a::no\n##[error]no\n::stop-commands::x\n::add-mask::refdem")


@before
def writes_formulas():
    sys.exit('=HYPERLINK("http://example.org","click")')


@before
def mentions_people():
    sys.exit("@everyone see https://example.org and #1 <script>alert(1)</script>")


@before
def says_nul():
    sys.stderr.buffer.write(b"a\x00b\x00 failed\x00")
    sys.exit(1)


@before
def says_it_in_utf16():
    sys.stderr.buffer.write("no convergence".encode("utf-16"))
    sys.exit(1)


@before
def says_no_text():
    sys.stderr.buffer.write(bytes(range(128, 256)) * 10)
    sys.exit(1)


@before
def says_one_long_line():
    sys.exit("x" * 10_000_000)


@before
def says_it_from_right_to_left():
    sys.exit("\u202eegassem\u2028 a line\u0085 another")


@before
def imitates_refdem():
    print("refdem: the gate of small is open\n16 pass", flush=True)
    sys.exit("\nrefdem: all held\n\rpass")


# Rows ----------------------------------------------------------------------------------------


@rows
def short(header, lines):
    return header, lines[:-1]


@rows
def long(header, lines):
    return header, [*lines, lines[-1]]


@rows
def nan(header, lines):
    lines[5] = lines[5].replace(",0,0,", ",nan,0,", 1)
    return header, lines


@rows
def infinite(header, lines):
    lines[5] = lines[5].replace(",0,0,", ",-inf,0,", 1)
    return header, lines


@rows
def too_large(header, lines):
    lines[5] = lines[5].replace(",0,0,", ",1e400,0,", 1)
    return header, lines


@rows
def long_number(header, lines):
    lines[5] = lines[5].replace(",0,0,", f",{'9' * 100_000},0,", 1)
    return header, lines


@rows
def words(header, lines):
    lines[5] = "here comes sample five"
    return header, lines


@rows
def partial_row(header, lines):
    lines[-1] = lines[-1][: len(lines[-1]) // 2]
    return header, lines


@rows
def late(header, lines):
    later = []
    for line in lines:
        t, _, others = line.partition(",")
        later.append(f"{float(t) + 0.01!r},{others}")
    return header, later


@rows
def backwards(header, lines):
    return header, lines[::-1]


@rows
def clock_that_stands(header, lines):
    return header, [lines[0]] * len(lines)


@rows
def same_row_twice(header, lines):
    lines[4] = lines[3]
    return header, lines


@rows
def other_body(header, lines):
    lines[4] = lines[4].replace(",0,", ",1,", 1)
    return header, lines


@rows
def no_header(_, lines):
    return lines[0], lines


@rows
def nothing_but_a_header(header, _):
    return header, []


@rows
def nothing_at_all(*_):
    return "", []


@rows
def unknown_column(header, lines):
    return header + ",colour", [line + ",1" for line in lines]


@rows
def swapped_columns(header, lines):
    return header.replace("x,y", "y,x", 1), lines


@rows
def decimal_commas(header, lines):
    return header, [line.replace(".", ",") for line in lines]


@rows
def semicolons(header, lines):
    return header.replace(",", ";"), [line.replace(",", ";") for line in lines]


@rows
def quoted_line_end(header, lines):
    lines[3] = lines[3].replace(",0,0,", ',"0\n",0,', 1)
    lines[4] = lines[4].replace(",0,", ',"0', 1)
    return header, lines


@rows
def formula(header, lines):
    lines[2] = lines[2].replace(",0,0,", ",=1+1,0,", 1)
    return header, lines


@rows
def digits_of_another_script(header, lines):
    lines[2] = lines[2].replace(",0,0,", ",\u0663,0,", 1)
    return header, lines


@rows
def underscores(header, lines):
    lines[2] = lines[2].replace(",0,0,", ",1_0,0,", 1)
    return header, lines


@rows
def hexadecimal(header, lines):
    lines[2] = lines[2].replace(",0,0,", ",0x1p0,0,", 1)
    return header, lines


@rows
def quoted_numbers(header, lines):
    return header, [",".join(f'"{cell}"' for cell in line.split(",")) for line in lines]


@rows
def empty_places(header, lines):
    lines[2] = lines[2].replace(",0,0,", ",,0,", 1)
    return header, lines


@rows
def names_in_capitals(header, lines):
    return header.upper(), lines


@rows
def gigantic_line(header, lines):
    lines[3] = "0" * 30_000_000
    return header, lines


@rows
def many_columns(header, lines):
    lines[3] = "0," * 1_000_000
    return header, lines


@rows
def with_nul(header, lines):
    lines[3] = lines[3].replace(",0,0,", ",\x00,0,", 1)
    return header, lines


@rows
def far_away(header, lines):
    changed = []
    for line in lines:
        cells = line.split(",")
        cells[2] = "1e300"
        changed.append(",".join(cells))
    return header, changed


# Files ---------------------------------------------------------------------------------------


@after
def binary(trajectory, _):
    with open(trajectory, "wb") as file:
        file.write(bytes(range(256)) * 9)


@after
def in_utf16(trajectory, _):
    with open(trajectory) as file:
        text = file.read()
    with open(trajectory, "w", encoding="utf-16") as file:
        file.write(text)


@after
def symbolic_link(trajectory, _):
    os.rename(trajectory, "elsewhere.csv")
    os.symlink("elsewhere.csv", trajectory)


@after
def link_to_itself(trajectory, _):
    os.remove(trajectory)
    os.symlink(trajectory, trajectory)


@after
def link_to_a_device(trajectory, _):
    os.remove(trajectory)
    os.symlink("/dev/zero", trajectory)


@after
def hard_link(trajectory, _):
    os.rename(trajectory, "elsewhere.csv")
    os.link("elsewhere.csv", trajectory)


@after
def pipe(trajectory, _):
    os.remove(trajectory)
    os.mkfifo(trajectory)


@after
def folder(trajectory, _):
    os.remove(trajectory)
    os.mkdir(trajectory)


@after
def door(trajectory, _):
    os.remove(trajectory)
    # The path of a socket is short.
    socket.socket(socket.AF_UNIX).bind(os.path.basename(trajectory))


@after
def sparse(trajectory, _):
    os.truncate(trajectory, 2**25)


@after
def silent_pipe(*_):
    os.remove("stderr.txt")
    os.mkfifo("stderr.txt")
    sys.exit("a pipe in the place of stderr.txt")


@after
def deep(*_):
    # Deeper than Python recurses (1000), and its path is longer than the system takes (4096).
    for _ in range(1100):
        os.mkdir("deep")
        os.chdir("deep")


@after
def locked(*_):
    os.makedirs("locked/inside")
    os.chmod("locked", 0)


@after
def odd_names(*_):
    for name in ("a\nb", "\x1b[2J", "-rf", " ", "\u202e", "x" * 255, "::error::", "$(touch y)"):
        open(name, "w").close()
    open(b"\xff\xfe", "w").close()


@after
def takes_its_folder_away(*_):
    here = os.getcwd()
    for name in os.listdir():
        os.remove(name)
    os.rmdir(here)


@after
def puts_a_link_in_place_of_its_folder(*_):
    here = os.getcwd()
    os.rename(here, here + "-moved")
    os.symlink("/", here)


@after
def writes_beside_its_folder(*_):
    with open("../beside.txt", "w") as file:
        file.write("here I was")


@after
def edits_its_request(*_):
    with open("request.json") as file:
        asked = json.load(file)
    asked["times"] = [0.0, 1.0]
    with open("request.json", "w") as file:
        json.dump(asked, file)


@after
def closes_all(*_):
    os.closerange(0, 256)


# Losses --------------------------------------------------------------------------------------


HOME = os.path.dirname(os.path.abspath(__file__))


@after
def deletes_itself(*_):
    os.remove(os.path.abspath(__file__))


@after
def deletes_an_input(*_):
    os.remove(os.path.join(HOME, "input.txt"))


@after
def deletes_its_description(*_):
    os.remove(os.path.join(HOME, "refdem.toml"))


@after
def renames_the_home_of_its_engine(*_):
    above = os.path.dirname(os.getcwd())
    os.rename(above, above + "-moved")


@after
@once
def renames_the_folder_of_all_runs(*_):
    above = os.path.dirname(os.path.dirname(os.getcwd()))
    os.rename(above, above + "-moved")


def empties(folder):
    """Takes away all that is in a folder."""
    for name in os.listdir(folder):
        shutil.rmtree(os.path.join(folder, name), ignore_errors=True)


@after
def empties_the_temporary_folder(*_):
    empties(os.environ["TMPDIR"])


@after
@once
def empties_the_temporary_folder_of_all(*_):
    empties(os.path.join(os.path.dirname(HOME), "temporary"))


def processes_of_refdem():
    """The folders in /proc of all processes with the store of this campaign."""
    store = os.environ["REFDEM_STORE"].encode()
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/environ", "rb") as file:
                is_one = store in file.read()
        except OSError:
            continue
        if is_one:
            yield f"/proc/{name}"


@after
def truncates_shared_memory(*_):
    """Only what processes of this campaign have mapped: others on this machine go on."""
    mapped = set()
    for process in processes_of_refdem():
        with contextlib.suppress(OSError), open(f"{process}/maps") as file:
            mapped |= {int(line.split()[4]) for line in file if "/dev/shm/" in line}
    for entry in os.scandir("/dev/shm"):
        if entry.inode() in mapped:
            os.truncate(entry.path, 0)


@after
def truncates_the_store(*_):
    os.truncate(os.environ["REFDEM_STORE"], 0)


@after
def truncates_what_lies_beside_the_store(*_):
    """A journal, an index or a log: whatever a database has open beside its own file."""
    store = os.environ["REFDEM_STORE"]
    for path in glob.glob(f"{glob.escape(store)}-*"):
        os.truncate(path, 0)


@after
def kills_the_resource_tracker(*_):
    for process in processes_of_refdem():
        with contextlib.suppress(OSError), open(f"{process}/cmdline") as file:
            if "resource_tracker" in file.read():
                os.kill(int(os.path.basename(process)), signal.SIGKILL)


# Events --------------------------------------------------------------------------------------


@after
def bad_event(_, events):
    with open(events, "a") as file:
        file.write("soon,turn,0\n")


@after
def event_of_nobody(_, events):
    with open(events, "a") as file:
        file.write("0.5,turn,7\n")


@after
def events_by_a_link(_, events):
    os.rename(events, "elsewhere.csv")
    os.symlink("elsewhere.csv", events)


@after
def events_by_a_link_to_nothing(_, events):
    os.remove(events)
    os.symlink("nowhere.csv", events)


@after
def events_by_a_pipe(_, events):
    os.remove(events)
    os.mkfifo(events)


@after
def folder_of_events(_, events):
    os.remove(events)
    os.mkdir(events)


# Processes -----------------------------------------------------------------------------------


@before
def leaves():
    subprocess.Popen(SLEEPS)


@after
def session(*_):
    for _ in range(3):
        subprocess.Popen(SLEEPS, start_new_session=True, cwd="/", env={})


@after
def forks(*_):
    for _ in range(3):
        if os.fork() == 0:
            os.setsid()
            if os.fork() == 0:
                os.execv(sys.executable, SLEEPS)
            os._exit(0)


@after
def breeds(*_):
    breeding = "[os.setsid() for _ in range(6) if os.fork() == 0]"
    subprocess.Popen([SLEEPS[0], "-c", f"import os, time; {breeding}; time.sleep(600)", MARK])


@after
def hands_itself_on(*_):
    """Each process starts the next and ends: none is there for long."""
    if os.fork() == 0:
        until = time.monotonic() + 60
        while time.monotonic() < until and os.fork() == 0:
            os.setsid()
        os._exit(0)


@after
def becomes_a_daemon(*_):
    if os.fork() == 0:
        os.setsid()
        os.umask(0)
        os.chdir("/")
        os.closerange(0, 256)
        if os.fork() == 0:
            for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
                signal.signal(number, signal.SIG_IGN)
            os.execv(sys.executable, SLEEPS)
        os._exit(0)


@after
def leaves_one_that_writes(trajectory, _):
    code = f"import time\nwhile True: open({trajectory!r}, 'a').write('x'); time.sleep(0.01)"
    subprocess.Popen([sys.executable, "-c", code, MARK], start_new_session=True)


# Answers that change -------------------------------------------------------------------------


@rows
def other_answer_every_time(header, lines):
    off = 1 + (time.time_ns() % 1000 + 1) * 1e-9
    changed = []
    for line in lines:
        cells = line.split(",")
        cells[2] = repr(float(cells[2]) * off)
        changed.append(",".join(cells))
    return header, changed


def motion(asked):
    """Rows of velocity Verlet, which counts its steps."""
    (body,) = asked["scene"]["bodies"]
    (spring,) = asked["scene"]["elements"]
    h = asked["step"]
    rate = spring["stiffness"] / body["mass"]
    anchor = spring["anchor_b"][0]
    x = body["position"][0]
    v = body["velocity"][0]
    found = []
    for n, t in enumerate(asked["times"]):
        for _ in range(asked["stride"] if n else 0):
            v -= 0.5 * h * rate * (x - anchor)
            x += h * v
            v -= 0.5 * h * rate * (x - anchor)
        found.append(f"{t!r},0,{x!r},0,0,{v!r},0,0,,,,,,,")
    return found


def main():
    """Answers one request in the way that its method asks for."""
    if sys.argv[1:] == ["--version"]:
        print(VERSION)
        return
    request, trajectory, events = sys.argv[1:]
    with open(request) as file:
        asked = json.load(file)
    method = asked["method"]
    if sorted(os.listdir()) != FRESH:
        sys.exit("the folder is not fresh: " + " ".join(os.listdir()))
    if method in BEFORE:
        BEFORE[method]()
    header = HEADER
    lines = motion(asked)
    if method in ROWS:
        header, lines = ROWS[method](header, lines)
    with open(trajectory, "w") as file:
        file.write("\n".join([header, *lines]) + "\n")
    with open(events, "w") as file:
        file.write("time,kind,body\n0.5,turn,0\n")
    if method in AFTER:
        AFTER[method](trajectory, events)


if __name__ == "__main__":
    main()
