import gc
import logging
import os
import signal
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import hypothesis
import pytest

from fieldrig import testing
from fieldrig.outside.page_seat import NO_PAGE_VARIABLE
from fieldrig.system.this_process import resident_bytes

# A shell or nohup ignores these signals for background jobs, and rigs would read that as the choice of the user.
for name, handler in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    number = getattr(signal, name, None)
    if number is not None and signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, handler)

# What a test starts has no page, unless the test is about the page: the suite would pay for a process in every rig.
os.environ[NO_PAGE_VARIABLE] = "1"

# No example has to be quick, nor what makes it.  The stage `quick` names its profile, which has ten examples for each
# property, also for those that state a number.
SLOWNESS = [hypothesis.HealthCheck.too_slow]
USUAL = hypothesis.settings.get_profile(hypothesis.settings.get_current_profile_name())
hypothesis.settings.register_profile("whole", USUAL, deadline=None, suppress_health_check=SLOWNESS)
FEW = 10
hypothesis.settings.register_profile("quick", USUAL, deadline=None, suppress_health_check=SLOWNESS, max_examples=FEW)
hypothesis.settings.load_profile("whole")

pytest_plugins = ["manual_rows", "in_fork"]
TIME_LIMIT_S = 120
"""Time limit of a test that states none."""
MOST_BYTES = 1 << 30
"""Memory of a process with all tests that it has run: what tests leave behind was once 6.8 GB."""
SEARCHES = 10_000, 10, 10
"""Thresholds of Python's search for circles: new objects until it looks, and looks until it looks further."""

pytest.register_assert_rewrite("can_link_laws")  # a suite of tests that has its place in tests/support


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("timeout") is None:
        config.option.timeout = TIME_LIMIT_S


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Keep the search for circles out of what is collected, which stays to the end.

    The 19,000 tests and their modules are 690,000 objects: a full search took a second of CPU time, and came with
    every sixth bench.  Without them Python would search the little that is left all the more often.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.set_threshold(*SEARCHES)
        gc.enable()


@cache
def text_of(file: Path) -> str:
    return file.read_text(encoding="utf-8")


def pytest_itemcollected(item: pytest.Item) -> None:
    """Refuse a mark that its stage would not find, as it looks into the files (`marked` in tests/driver/stages.py)."""
    for mark in ("system", "vcan", "ppp"):
        if item.get_closest_marker(mark) is not None and f"mark.{mark}" not in text_of(item.path):
            raise pytest.UsageError(f"{item.nodeid}: expected pytest.mark.{mark} in the file itself")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if hypothesis.settings.get_current_profile_name() != "quick":
        return
    stated = "_hypothesis_internal_use_settings"  # settings of a test come before those of the profile
    for item in items:
        test = getattr(item, "obj", None)
        test = getattr(test, "__func__", test)
        settings = getattr(test, stated, None)
        if settings is not None and settings.max_examples > FEW:
            setattr(test, stated, hypothesis.settings(settings, max_examples=FEW))


@pytest.fixture
def free_port() -> int:
    """A free TCP port of 127.0.0.1."""
    return testing.free_port()


@pytest.fixture(scope="session", autouse=True)
def process_of_commands() -> Iterator[None]:
    """End the process whose forks are commands, if a test has needed it."""
    yield
    forked_cli = sys.modules.get("forked_cli")
    if forked_cli is not None:
        forked_cli.USUAL.end()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown() -> Iterator[None]:
    """Fail a test that leaves loggers turned off, or too much memory.

    Without loggers, the tests after it would find nothing in `caplog`.
    """
    result = yield
    Memory.check()
    loggers = logging.Logger.manager.loggerDict.values()
    off = [logger for logger in loggers if isinstance(logger, logging.Logger) and logger.disabled]
    for logger in off:
        logger.disabled = False
    assert not off, f"this test turned off {len(off)} loggers, such as {off[0].name}"
    assert logging.Logger.manager.disable == logging.NOTSET, "this test turned off logging"
    return result


class Memory:
    """The memory of this process, which is checked until it is too much: one failure is enough.

    A test leaves whole rigs in circles, each with few objects and many MB, and so Python rarely searches for them.
    """

    is_checked = True
    searched_at = MOST_BYTES // 4

    @classmethod
    def check(cls) -> None:
        found = resident_bytes()
        if found > cls.searched_at:
            gc.collect()
            found = resident_bytes()
            cls.searched_at = found + MOST_BYTES // 8
        if cls.is_checked and found > MOST_BYTES:
            cls.is_checked = False
            pytest.fail(f"the tests of this process have left {found >> 20} MB; expected at most {MOST_BYTES >> 20}")
