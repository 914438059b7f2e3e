"""The first run of a program under test: FB_init, and start values that are computed."""

from typing import Final

from fieldrig.errors import RigError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.testing.extension import BEGIN, BEGIN_INSTANCE

LONGEST_S: Final = 10.0
"""Time of a processor that it may take."""
_SLICE_NS: Final = 1_000_000


def begin_program(runtime: Runtime) -> None:
    """Start the variables of a program.  RigError for a fault in FB_init or in what computes a start value."""
    program = runtime.compiled.program
    thread = runtime.thread(program.pous[program.dialect.key(BEGIN)])
    thread.enter(BEGIN.lower(), program.globals[program.dialect.key(BEGIN_INSTANCE)].offset)
    thread.start()
    watch = Stopwatch()
    while thread.state is WorkState.READY and watch.busy_seconds < LONGEST_S:
        thread.run(_SLICE_NS)
    if thread.state is not WorkState.ENDED:
        fault = thread.fault or thread.fault_here("timeout", f"a loop without an end in {LONGEST_S:g} s")
        raise RigError(f"the variables of the program cannot be started: {fault}", "FB_init and start values run first")
