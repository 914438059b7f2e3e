"""A kind whose supervisor gets a SIGTERM within a hook of its first fork, where Python drops what a handler raises."""

import os
import signal

from fieldrig.device import Device
from fieldrig.link import Link
from fieldrig_bus.wires import Signal


class Idle(Device):
    """Does nothing."""

    def __init__(self, wires: Link[Signal]) -> None:
        self._wires = wires


os.register_at_fork(after_in_parent=lambda: os.kill(os.getpid(), signal.SIGTERM))
