# SPDX-License-Identifier: GPL-2.0-or-later
import pytest


def pytest_addoption(parser):
    parser.addoption("--slow", action="store_true", help="also run the tests marked slow (minutes to hours)")


@pytest.fixture(autouse=True)
def inAFolderOfItsOwn(tmp_path, monkeypatch):
    """A run that fails leaves a checkpoint in the working folder, which should not be the repository."""
    monkeypatch.chdir(tmp_path)


def pytest_collection_modifyitems(config, items):
    if config.getoption("--slow"):
        return
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="slow: switch on with --slow"))
