"""The system's Chromium, and reports for it to open from disk."""

import shutil

import pytest

from refdem.report import write_report
from tests.report import synthetic

ARGUMENTS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--no-first-run",
)


@pytest.fixture(scope="session")
def browser():
    from playwright.sync_api import sync_playwright

    path = (
        shutil.which("chromium")
        or shutil.which("chromium-browser")
        or shutil.which("google-chrome")
    )
    assert path, "no Chromium here: run ci/packaging/system-packages"
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        yield chromium
        chromium.close()


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """A report of synthetic sheets, hostile names among them."""
    path = tmp_path_factory.mktemp("a report") / "100% #1"
    write_report(path, synthetic.sheets())
    return path
