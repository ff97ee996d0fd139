"""Synthetic sheets, and one report written from them."""

import pytest

from refdem.core.store import Store
from refdem.report import write_report
from tests.report import synthetic


@pytest.fixture(scope="session")
def sheets():
    return synthetic.sheets()


@pytest.fixture(scope="session")
def store(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("store") / "store.sqlite")


@pytest.fixture(scope="session")
def folder(sheets, store, tmp_path_factory):
    path = tmp_path_factory.mktemp("report")
    write_report(path, sheets, store)
    return path
