"""The command refdem, as `python -m refdem`."""

from refdem.cli import main

# Worker processes import this file again: only the first of them runs the command.
if __name__ == "__main__":
    main()
