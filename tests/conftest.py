# SPDX-License-Identifier: GPL-2.0-or-later
import os
import signal
from collections import Counter
from pathlib import Path

import pytest
import yade_mpm

pytest_plugins = ["verificationRecords"]


def pytest_configure(config):
    """Processes that tests start find the package, and what tests share."""
    folders = [Path(yade_mpm.__file__).parents[1], *config.getini("pythonpath")]
    os.environ["PYTHONPATH"] = os.pathsep.join(map(str, folders))


def pytest_addoption(parser):
    parser.addoption("--slow", action="store_true", help="also run the tests marked slow (minutes to hours)")


def pytest_runtest_makereport(item, call):
    """SIGTERM ends the session. A run of a scene turns it into SystemExit, which pytest would take for a
    test that failed, and go on."""
    if (
        call.excinfo
        and call.excinfo.errisinstance(SystemExit)
        and call.excinfo.value.code == 128 + signal.SIGTERM
    ):
        pytest.exit(f"SIGTERM in {item.nodeid}", returncode=128 + signal.SIGTERM)


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


def pytest_terminal_summary(terminalreporter):
    """What was skipped and why, one line a reason."""
    skipped = terminalreporter.getreports("skipped")
    reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in skipped)
    if reasons:
        terminalreporter.section(f"{len(skipped)} skipped")
    for reason, count in reasons.most_common():
        terminalreporter.line(f"{count:5} {reason}")
