"""An interrupted run waits for what it started to end in order, and starts nothing more."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from tests.driver.commands import INTERRUPTED, Commands, Ended

TIDY = """
import time
try:
    print("begins", flush=True)
    time.sleep(600)
except KeyboardInterrupt:
    time.sleep(0.3)
    print("is tidied up", flush=True)
    raise SystemExit(2)
"""
DEAF = TIDY.replace("time.sleep(0.3)", "print('hears', flush=True); time.sleep(600)")
DRIVER = """
import os, sys
from tests.driver import commands as module
module.ONE_INTERRUPTION_S = float(sys.argv[1])
commands = module.Commands()
commands.install()
for code in sys.argv[2:]:
    is_behind = "behind" in code
    print("ended", commands.run([sys.executable, "-c", code], os.environ, is_behind=is_behind).code, flush=True)
"""


@contextmanager
def driver(*codes: str, one_interruption_s: float = 60) -> Iterator["subprocess.Popen[str]"]:
    """Run these programs one after the other, in a process group of their own; the first has begun."""
    command = [sys.executable, "-c", DRIVER, str(one_interruption_s), *codes]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "begins\n"
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


def rest(process: "subprocess.Popen[str]") -> str:
    assert process.stdout is not None
    return process.stdout.read()


@pytest.mark.long
def test_ctrl_c_reaches_all_and_the_driver_waits() -> None:
    with driver(TIDY, "print('starts')") as process:
        os.killpg(process.pid, signal.SIGINT)
        process.send_signal(signal.SIGINT)  # as timeout(1) does
        assert rest(process) == f"is tidied up\nended 2\nended {INTERRUPTED}\n"


@pytest.mark.long
def test_ctrl_c_interrupts_what_is_in_a_session_behind_others() -> None:
    with driver(f"{TIDY}# behind") as process:
        os.killpg(process.pid, signal.SIGINT)
        assert rest(process) == "is tidied up\nended 2\n"


@pytest.mark.long
def test_sigterm_of_the_driver_interrupts_the_tests() -> None:
    with driver(TIDY, "print('starts')") as process:
        process.terminate()
        assert rest(process) == f"is tidied up\nended 2\nended {INTERRUPTED}\n"


@pytest.mark.long
def test_a_second_interruption_kills() -> None:
    with driver(DEAF, one_interruption_s=0) as process:
        process.terminate()
        assert process.stdout is not None
        assert process.stdout.readline() == "hears\n"
        process.terminate()
        assert rest(process) == f"ended {-signal.SIGKILL}\n"


@pytest.mark.long
def test_the_cpu_time_is_that_of_the_command_with_its_children() -> None:
    busy = "import time\nwhile time.process_time() < 0.3: pass"
    outer = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {busy!r}])"
    ended = Commands().run([sys.executable, "-c", outer], os.environ)
    assert ended == Ended(0, ended.cpu_s)
    assert ended.cpu_s >= 0.3
