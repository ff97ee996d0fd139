"""The share of the kernels' lines that campaign `main` runs, and the lines that it does not:
ci/mutants/kernel_lines.py [--kept].

CI runs this campaign on every change. Exit status 1 if it runs less than GOAL of the lines.
"""

import argparse
import sys

import executed_lines
from executed_lines import ROWS, UNKNOWN, countable, executed
from tree_copy import ROOT, TreeCopy

GOAL = 0.98
"""Least part of the lines of the kernels that campaign main shall run; the rest are refusals and
limits, which tests of single kernels run.
"""


def spans(lines: set[int]) -> str:
    """Numbers of lines, in order, neighbours drawn together."""
    found: list[list[int]] = []
    for line in sorted(lines):
        if found and line == found[-1][1] + 1:
            found[-1][1] = line
        else:
            found.append([line, line])
    return ", ".join(str(begin) if begin == end else f"{begin}-{end}" for begin, end in found)


def is_kernel(name: str) -> bool:
    """True for a source of a kernel."""
    return name.endswith((".c", ".h"))


def run_by_rows() -> dict[str, set[int]]:
    """Lines of C that some row runs, by file."""
    found: dict[str, set[int]] = {}
    for test in executed():
        if test.file == ROWS:
            for name in filter(is_kernel, test.lines):
                lines = test.lines[name]
                if UNKNOWN in lines:
                    raise SystemExit(
                        f"{name} changed since the campaign ran: measure it again, without --kept"
                    )
                found.setdefault(name, set()).update(lines)
    return found


def main() -> int:
    """Prints a line a file that is not run whole, and the share of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--kept", action="store_true", help="take what was measured last, and run nothing"
    )
    if not parser.parse_args().kept:
        executed_lines.main([ROWS, "--again"])
    can_run = countable(TreeCopy(ROOT / "build/counting"))
    did_run = run_by_rows()
    total = missed = 0
    for name, lines in sorted(can_run.items()):
        left = lines - did_run.get(name, set())
        total += len(lines)
        missed += len(left)
        if left:
            print(f"{name}: {len(left)} of {len(lines)} lines do not run: {spans(left)}")
    share = 1 - missed / total
    print(f"campaign main runs {share:.1%} of {total} lines of the kernels; goal {GOAL:.0%}")
    return int(share < GOAL)


if __name__ == "__main__":
    sys.exit(main())
