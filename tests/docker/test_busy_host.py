"""The machine in containers on a host whose cores have far more to do than the rig."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from compose_stack import OUTSIDE, docker, stack_of

pytestmark = [pytest.mark.docker, pytest.mark.timeout(1200)]

LOAD = 30
SHARES_OF_A_PROCESS = 1024
BUSY_LOOPS = f"for loop in $(seq {LOAD}); do while :; do :; done & done; wait"


@contextmanager
def busy_loops() -> Iterator[None]:
    """Run thirty loops in a container that weighs as much as thirty of the machine's.

    As processes of the host they may each weigh as much as all containers together, which then get a thirtieth of
    the cores: that is no host with a load, but one that has no room for the machine.
    """
    weight = f"--cpu-shares={LOAD * SHARES_OF_A_PROCESS}"
    loops = docker("run", "--detach", "--rm", "--init", weight, "--entrypoint=sh", "fieldrig", "-c", BUSY_LOOPS)
    assert loops.returncode == 0, loops.stderr
    try:
        yield
    finally:
        docker("rm", "--force", loops.stdout.strip())


def test_the_machine_becomes_ready_beside_thirty_busy_loops_and_no_check_adds_to_them() -> None:
    with stack_of("compose.yaml", (*OUTSIDE, "page"), busy_loops) as stack:
        assert {count for name, count in stack.restarts().items() if name != "rig"} == {0}
        parts = [line for line in stack.processes() if "fieldrig up" in line]
        checks = [line for line in stack.processes() if "fieldrig status" in line]
        # Each with the init of Docker before it, and the page beside the rig.
        assert (len(parts), checks) == (2 * len(stack.containers()) + 1, [])
