"""The machine in containers on a host whose cores have far more to do than the rig."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from compose_stack import OUTSIDE, stack_of

pytestmark = [pytest.mark.docker, pytest.mark.timeout(3600)]

LOAD = 30


@contextmanager
def busy_loops() -> Iterator[None]:
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(LOAD)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def test_the_machine_becomes_ready_beside_thirty_busy_loops_and_no_check_adds_to_them() -> None:
    with stack_of("compose.yaml", OUTSIDE, busy_loops) as stack:
        stack.until_healthy()
        assert {count for name, count in stack.restarts().items() if name != "rig"} == {0}
        parts = [line for line in stack.processes() if "fieldrig up" in line]
        checks = [line for line in stack.processes() if "fieldrig status" in line]
        assert (len(parts), checks) == (2 * len(stack.containers()), [])  # each with the init of Docker before it
