"""The command line in this process: what it prints and its exit status, without the cost of another
interpreter.
"""

import contextlib
import io
import os
import subprocess
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from unittest import mock

import pytest
from file_times import FileTimes
from hypothesis import HealthCheck, settings
from shared_truths import SharedTruths

from refdem.cli import main
from refdem.planning import in_process

# Examples depend on no clock (a busy machine is slow) and are the same in every run;
# `ci/testing/test_machines.py` asks for others.
settings.register_profile(
    "refdem", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("another-seed", settings.get_profile("refdem"), derandomize=False)
settings.load_profile("refdem")


def pytest_configure(config: pytest.Config) -> None:
    """Tells at the end in which files processors worked longest."""
    config.pluginmanager.register(FileTimes(), "file-times")


@pytest.fixture(scope="session", autouse=True)
def _truths_shared(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[None]:
    """`in_process.truth_of` proves each truth once, for all workers of the session."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        # That of all workers is around that of one.
        folder = folder.parent
    shared = SharedTruths(folder / "truths")
    request.config.pluginmanager.register(shared, "shared-truths")
    with mock.patch.object(in_process, "kept_truth", shared.available):
        yield
    request.config.pluginmanager.unregister(shared)


@pytest.fixture(scope="session")
def command_line() -> "Callable[..., subprocess.CompletedProcess[str]]":
    """`command_line(*arguments, cwd=None, env=None)` as subprocess.run of `refdem` with captured
    text; tests of signals, pipes and of the code itself being replaced start a process."""

    def called(
        *arguments: str, cwd: Path | None = None, env: dict[str, str] | None = None
    ) -> "subprocess.CompletedProcess[str]":
        out = io.StringIO()
        err = io.StringIO()
        with contextlib.ExitStack() as stack:
            stack.enter_context(mock.patch.object(sys, "argv", ["refdem", *arguments]))
            stack.enter_context(
                mock.patch.dict(os.environ, {} if env is None else env, clear=env is not None)
            )
            stack.enter_context(contextlib.chdir(cwd or Path.cwd()))
            stack.enter_context(contextlib.redirect_stdout(out))
            stack.enter_context(contextlib.redirect_stderr(err))
            stack.enter_context(warnings.catch_warnings())
            warnings.simplefilter("ignore", ResourceWarning)  # as in a process of its own
            return subprocess.CompletedProcess(
                ["refdem", *arguments], _status(), out.getvalue(), err.getvalue()
            )

    return called


def _status() -> int:
    """The exit status of the command in sys.argv; of a traceback, 1."""
    try:
        main()
    except SystemExit as end:
        if isinstance(end.code, int):
            return end.code
        return int(end.code is not None)
    except BaseException:
        traceback.print_exc()
        return 1
    return 0
