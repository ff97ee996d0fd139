"""The command line: one command a file; errors are one clear sentence and an exit status."""

import sys

from refdem.errors import RefdemError


def main() -> None:
    """Runs the command; exit 0 all held, 1 a check failed, 2 bad input, 3 an engine broke."""
    from refdem.cli.app import app

    try:
        app()
    except RefdemError as error:
        print(f"refdem: {error}", file=sys.stderr)
        sys.exit(error.exit_status)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(0)
    except KeyboardInterrupt:
        print("refdem: interrupted; what was finished is kept and will not be run again", file=sys.stderr)
        sys.exit(130)
