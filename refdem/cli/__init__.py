"""The command line: one command a file; errors are one clear sentence and an exit status."""

import errno
import io
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from refdem.errors import RefdemError

INTERRUPTED = 130
"""128 + SIGINT; typer turns an interrupt into this status without a message."""
UNREAD = 141
"""128 + SIGPIPE, the status that a shell reports for a program whose output pipe was closed. It
means neither "all held" nor "a check failed".
"""
BAD_INPUT = 2
"""Exit status where the input is wrong, as of argparse."""
BROKEN = 70
"""Internal error of refdem (EX_SOFTWARE of sysexits.h): no verdict on anything."""
ENDING = ("SIGTERM", "SIGHUP")
"""Signals by which batch systems, `timeout` and a closed terminal end a program; they end refdem as
Ctrl-C does.
"""
SYSTEM_ERRORS = {
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EROFS,
    errno.EACCES,
    errno.EPERM,
    errno.ELOOP,
    errno.ENAMETOOLONG,
    errno.ENOTDIR,
    errno.EISDIR,
    errno.EIO,
    errno.EMFILE,
    errno.ENFILE,
    errno.EBADF,
}
"""Errors of the operating system for files that are not caused by refdem."""


def main() -> None:
    """Runs the command and exits with its status.

    Exit status: 0 all held, 1 a check failed, 2 bad input, 3 an engine broke, 70 refdem itself
    broke, 130 interrupted (143 and 129 by SIGTERM and SIGHUP), 141 unread.
    """
    _open_streams()
    # A closed stream is replaced by one that discards its output.
    sys.stdout = sys.stdout or open(os.devnull, "w")  # noqa: SIM115
    sys.stderr = sys.stderr or open(os.devnull, "w")  # noqa: SIM115
    _write_messages_at_once()
    signals: list[int] = []
    try:
        try:
            with _interrupted_by_signals(signals):
                _run()
        except SystemExit as end:
            if (
                type(sys.stdout).__name__ == "PacifyFlushWrapper"
            ):  # what typer puts there, with status 1, when the reader has closed
                sys.exit(UNREAD)
            if end.code == INTERRUPTED:
                _print_error("interrupted; finished runs are stored and will not be repeated")
                status = INTERRUPTED
                if signals:
                    status = 128 + signals[0]
                sys.exit(status)
            # Buffered output is flushed here, where a failure can be reported in a sentence.
            sys.stdout.flush()
            raise
    except RefdemError as error:
        _print_error(str(error))
        sys.exit(error.exit_status)
    except OSError as error:
        _exit_with_system_error(error)
    except Exception as error:
        _exit_with_internal_error(error)


def _open_streams() -> None:
    """Opens /dev/null as standard input, output or error if one of these is closed.

    Otherwise the next file that is opened, here or in a child process, would get its descriptor.
    """
    for stream in (0, 1, 2):
        try:
            os.fstat(stream)
        except OSError:
            # The system assigns the lowest free descriptor, which is this one.
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)


def _write_messages_at_once() -> None:
    """Makes standard error unbuffered.

    Output that a full disk refuses would otherwise stay in the buffer. Every later flush would fail
    on it, including the one before a process is started, and Python's flush at exit would change
    the exit status.
    """
    buffered = sys.__stderr__
    if buffered is None or sys.stderr is not buffered:
        # The stream was replaced, for example by the tests or a notebook.
        return
    unbuffered = open(buffered.fileno(), "wb", buffering=0, closefd=False)  # noqa: SIM115
    sys.stderr = io.TextIOWrapper(
        unbuffered, encoding=buffered.encoding, errors=buffered.errors, write_through=True
    )


def _exit_with_system_error(error: OSError) -> None:
    """Ends with one sentence for a file that the operating system does not let refdem access."""
    if _is_folder_deleted():
        _print_error("the current folder no longer exists; change to an existing folder")
        sys.exit(BAD_INPUT)
    if error.errno not in SYSTEM_ERRORS:
        _exit_with_internal_error(error)
    if error.filename:
        place = f"{error.filename}: "
    else:
        place = "standard output or a file: "
    _print_error(f"{place}{error.strerror}; nothing can be written or read there")
    _discard_output()
    sys.exit(BAD_INPUT)


def _is_folder_deleted() -> bool:
    """Whether the current folder has been deleted, so that relative paths are invalid."""
    try:
        os.getcwd()
    except OSError:
        return True
    return False


def _run() -> None:
    """Runs the command; an interrupt while it is being imported ends like one during its work."""
    try:
        from refdem.cli.app import app
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    app()


@contextmanager
def _interrupted_by_signals(signals: list[int]) -> Iterator[None]:
    """Turns signals that end a program into an interrupt, and records which one it was."""

    def interrupt(number: int, _: FrameType | None) -> None:
        signals.append(number)
        raise KeyboardInterrupt

    # Under `nohup` the signal is to stay ignored. Only the main thread can set signal handlers.
    is_first = threading.current_thread() is threading.main_thread()
    numbers = [getattr(signal, name) for name in ENDING if is_first]
    ending = [number for number in numbers if signal.getsignal(number) is signal.SIG_DFL]
    for number in ending:
        signal.signal(number, interrupt)
    try:
        yield
    finally:
        for number in ending:
            signal.signal(number, signal.SIG_DFL)


def _exit_with_internal_error(error: Exception) -> None:
    """Ends with the status of an internal error and a sentence on where the details are."""
    import traceback

    from refdem.core.store import default_path

    text = "".join(traceback.format_exception(error))
    place = default_path().parent / "refdem-broke.txt"
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8", errors="replace")
        where = f"the details are in {place}"
    except OSError:
        with suppress(OSError, ValueError):
            print(text, file=sys.stderr)
        where = "the details are above"
    what = f"{type(error).__name__}: {error}"
    _print_error(
        f"internal error of refdem ({what}); no verdict was reached. Please report it: {where}"
    )
    sys.exit(BROKEN)


def _print_error(text: str) -> None:
    """One line on standard error, if there is one."""
    from refdem.core.outside import one_line

    with suppress(OSError, ValueError, AttributeError):
        print(f"refdem: {one_line(text)}", file=sys.stderr)


def _discard_output() -> None:
    """Prevents an error message from Python's flush of standard output at exit."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
