"""A plugin for pytest: a test with the mark `in_fork` runs in a fork of its process, and changes nothing for others.

So several tests share a fixture that takes long, such as a rig that has booted, and each begins with it as it was made.
Where the system has no fork, such a fixture is made for each test: its scope is `SHARED`.

Left out on purpose: a test that decides within the fork to skip itself.
"""

import os
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection, Pipe
from typing import Final, Literal, NoReturn

import pytest

HAS_FORK: Final = hasattr(os, "fork")
SHARED: Final[Literal["module", "function"]] = "module" if HAS_FORK else "function"


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "in_fork: runs in a fork, so that it leaves its fixtures as they were")


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    if pyfuncitem.get_closest_marker("in_fork") is None or not HAS_FORK:
        return None
    ours, theirs = Pipe(duplex=False)
    pid = os.fork()
    if pid == 0:
        _run(pyfuncitem, theirs)
    theirs.close()
    try:
        with ours:
            said = ours.recv()
    except EOFError:
        said = "the fork of this test ended before the test"
    finally:
        os.kill(pid, signal.SIGKILL)  # at a failure of the wait, such as a time-out; else it has ended
        os.waitpid(pid, 0)
    if said:
        pytest.fail(said, pytrace=False)
    return True


def _run(item: pytest.Function, connection: Connection) -> NoReturn:
    """Run the test, and say how it failed."""
    said = ""
    function: Callable[..., None] = item.obj
    try:
        function(**{name: item.funcargs[name] for name in item._fixtureinfo.argnames})
    except BaseException as fault:  # noqa: BLE001 - whatever it is, the test has failed
        said = str(item.repr_failure(pytest.ExceptionInfo.from_exception(fault)))
    connection.send(said)
    os._exit(0)
