"""How each misbehaviour of program.py must end: the sentence of its one error, or that it hurts
nobody.
"""

LINK = r"(is a link, a pipe, a device or a folder|cannot be read: .*); expected a plain file"
MEMORY = r"took .* GB of memory and was ended; expected at most 0\.5 GB"

ERRORS = {
    "fails": r"ended with exit status 1: segment 3: no convergence \?\[31m",
    "fails-in-silence": "exit status 1: stderr is empty",
    "says-that-it-failed-by-255": "exit status 255",
    "silent": "wrote no trajectory.csv",
    "aborts": r"signal 6 \(SIGABRT\)",
    "has-a-fault-of-segments": r"signal 11 \(SIGSEGV\)",
    "kills-itself": r"signal 9 \(SIGKILL",
    "kills-its-parent": "was terminated externally",
    "leaves-a-session-and-kills-its-parent": "was terminated externally",
    "kills-the-parent-of-its-parent": "exit status 1: it is done",
    "kills-its-group": r"signal 9 \(SIGKILL",
    "floods": "SIGXFSZ: a file grew too large",
    "floods-its-output": "SIGXFSZ: a file grew too large",
    "floods-its-errors": "SIGXFSZ: a file grew too large",
    "devours": MEMORY,
    "devours-among-orphans": MEMORY,
    "devours-shared-memory": MEMORY,
    "devours-the-shared-memory-of-an-orphan": MEMORY,
    "escapes": r"exit status 1: \?\[2J",
    "commands-a-workflow": "exit status 1: ",
    "writes-formulas": "exit status 1: =HYPERLINK",
    "mentions-people": "exit status 1: @everyone",
    "says-nul": r"exit status 1: a\?b\? failed",
    "says-it-in-utf16": "exit status 1: ",
    "says-no-text": "exit status 1: ",
    "says-one-long-line": "exit status 1: x+",
    "says-it-from-right-to-left": r"exit status 1: \?egassem / +a line / +another",
    "imitates-refdem": "exit status 1: refdem: all held / +/ pass",
    "short": "rows; expected",
    "long": "has more rows; expected",
    "nan": "x is 'nan'; expected a finite number|y is 'nan'; expected a finite number",
    "infinite": "y is '-inf'; expected a finite number",
    "too-large": "y is '1e400'; expected a finite number",
    "long-number": "y is '9+ ...'; expected a finite number",
    "words": "has 1 columns; expected 15",
    "partial-row": "columns; expected 15",
    "other-body": r"is body 1 at t = .*; expected body 0",
    "no-header": "line 1 is '0.0,0,1.0",
    "nothing-but-a-header": "has 0 rows; expected",
    "nothing-at-all": "line 1 is ''",
    "unknown-column": "line 1 is .*colour",
    "swapped-columns": "line 1 is 't,body,y,x",
    "decimal-commas": "columns; expected 15",
    "semicolons": "line 1 is 't;body",
    "quoted-line-end": "columns; expected 15|line 1|rows; expected",
    "formula": r"y is '=1\+1'; expected a finite number",
    "digits-of-another-script": "y is '.'; expected a finite number",
    "underscores": "y is '1_0'; expected a finite number",
    "hexadecimal": "y is '0x1p0'; expected a finite number",
    "empty-places": "y is ''; expected a finite number",
    "names-in-capitals": "line 1 is 'T,BODY",
    "gigantic-line": "cannot be read as CSV|columns; expected 15",
    "many-columns": "cannot be read as CSV: a row of more than",
    "with-nul": r"y is '\?'; expected a finite number|cannot be read as CSV",
    "binary": "trajectory.csv",
    "in-utf16": "line 1 is ",
    "symbolic-link": LINK,
    "link-to-itself": LINK,
    "link-to-a-device": LINK,
    "hard-link": LINK,
    "pipe": LINK,
    "folder": LINK,
    "door": LINK,
    "sparse": "cannot be read as CSV|columns; expected 15|more rows",
    "silent-pipe": "exit status 1: a pipe in the place of stderr.txt",
    "takes-its-folder-away": "wrote no trajectory.csv",
    "puts-a-link-in-place-of-its-folder": "wrote no trajectory.csv",
    "bad-event": "events.csv line 3 is 'soon,turn,0'",
    "event-of-nobody": "events.csv line 3 is '0.5,turn,7'",
    "events-by-a-link": LINK,
    "events-by-a-link-to-nothing": LINK,
    "events-by-a-pipe": LINK,
    "folder-of-events": LINK,
    "leaves": "left 1 of its processes running",
    "session": "left 3 of its processes running",
    "forks": "left 3 of its processes running",
    "breeds": r"left \d+ of its processes running",
    "becomes-a-daemon": "left 1 of its processes running",
    "hands-itself-on": r"left \d+ of its processes running",
    "leaves-one-that-writes": "left 1 of its processes running",
}
"""One error each."""

SLOW = {
    "hangs": "still running after",
    "turns-in-a-circle": "still running after",
    "stops-itself": "still running after",
    "hears-no-signal": "still running after",
    "waits-for-a-pipe": "still running after",
}
"""One error each, when their time is up."""

TIMES = {
    "late": r"trajectory\.t\[\d+\] is .* s; expected",
    "backwards": r"trajectory\.t\[\d+\] is .* s; expected",
    "clock-that-stands": r"trajectory\.t\[\d+\] is .* s; expected",
    "same-row-twice": r"trajectory\.t\[\d+\] is .* s; expected",
}
"""One error each, when the trajectory is laid beside the samples that were asked for."""

REFUSALS = {
    "refuses": "no springs on Saturdays",
    "refuses-in-silence": "the program reports that the scene is not supported",
}
"""Not an error: the program cannot say the scene."""

HARMLESS = [
    "quoted-numbers",
    "reserves",
    "opens-all-files",
    "makes-many-files",
    "interrupts-its-parent",
    "waits-for-input",
    "deep",
    "locked",
    "odd-names",
    "writes-beside-its-folder",
    "edits-its-request",
    "closes-all",
]
"""Judged as the good program is."""

WRONG = ["other-answer-every-time", "far-away"]
"""Judged, and fails."""

MODES = [*ERRORS, *SLOW, *TIMES, *REFUSALS, *HARMLESS, *WRONG]

LOSSES = {
    "deletes-itself": "ended with exit status [12]: .*No such file",
    "deletes-an-input": "ended with exit status 1: .*No such file",
    "deletes-its-description": "ended with exit status 1: .*No such file|refdem.toml",
    "renames-the-home-of-its-engine": "wrote no trajectory.csv|cannot be made",
    "empties-the-temporary-folder": "wrote no trajectory.csv|cannot be made",
}
"""What a program takes away costs itself one error, and no other program anything."""

NOT_LOST = [
    "truncates-shared-memory",
    "truncates-the-store",
    "truncates-what-lies-beside-the-store",
    "kills-the-resource-tracker",
    "renames-the-folder-of-all-runs",
    "empties-the-temporary-folder-of-all",
]
"""Judged as the good program is: nothing of refdem depends on what they damage, or the runs that
they hit are made again.
"""
