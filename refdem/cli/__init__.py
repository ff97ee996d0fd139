"""The command line: one command a file; errors are one clear sentence and an exit status."""

import sys

from refdem.errors import RefdemError

INTERRUPTED = 130
"""128 + SIGINT; typer turns an interrupt into this status and says nothing."""
UNREAD = 141
"""128 + SIGPIPE, as a shell says of any program whose reader went away: neither "all held" nor "a check failed"."""


def main() -> None:
    """Runs the command; exit 0 all held, 1 a check failed, 2 bad input, 3 an engine broke, 130 interrupted, 141 unread."""
    from refdem.cli.app import app

    try:
        app()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            print("refdem: interrupted; what was finished is kept and will not be run again", file=sys.stderr)
        if type(sys.stdout).__name__ == "PacifyFlushWrapper":  # what typer puts there, with status 1, when nobody reads any more
            sys.exit(UNREAD)
        raise
    except RefdemError as error:
        print(f"refdem: {error}", file=sys.stderr)
        sys.exit(error.exit_status)
