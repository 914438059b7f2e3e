"""NMT slave: the state machine of the node, its commands and the boot-up message.

Source: CiA 301 chapter 7.2.8 and 7.3.2; CiA 302-2 for starting without a master (1F80h bit 2).  How long a node is in
'initialising' is up to its maker.
"""

from collections.abc import Callable
from enum import IntEnum

from fieldrig.clock import Alarm, Clock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.port import UNCONFIGURED, Port
from fieldrig_devices.canopen.service import Object, Reset, Service, State

NMT_ID = 0x000
ERROR_CONTROL_ID = 0x700
STARTUP = 0x1F80
IS_MASTER, IS_STARTED_BY_OTHERS = 0x01, 0x04
BOOT_UP = b"\x00"


class Command(IntEnum):
    START = 1
    STOP = 2
    ENTER_PRE_OPERATIONAL = 128
    RESET_NODE = 129
    RESET_COMMUNICATION = 130


# 7.3.2.1, figure 'NMT state diagram': a command leads to the same state from all three states.
NEXT_STATE = {
    Command.START: State.OPERATIONAL,
    Command.STOP: State.STOPPED,
    Command.ENTER_PRE_OPERATIONAL: State.PRE_OPERATIONAL,
}
RESETS = {Command.RESET_NODE: Reset.NODE, Command.RESET_COMMUNICATION: Reset.COMMUNICATION}
COMMANDS = {int(command): command for command in Command}


class NmtSlave(Service):
    """Executes NMT commands.  `restart` resets parameters and services; `enter` takes the services into a state."""

    def __init__(
        self,
        clock: Clock,
        port: Port,
        dictionary: Dictionary,
        restart: Callable[[Reset], None],
        enter: Callable[[State], None],
        boot_up_ns: int = 0,
    ) -> None:
        """The node stays in 'initialising' for `boot_up_ns`."""
        self._port, self._boot_up_ns = port, boot_up_ns
        self._booting = Alarm(clock)
        self._restart, self._enter = restart, enter
        self.state = State.INITIALISING
        self._startup = dictionary.get(STARTUP)
        if self._startup is not None:
            self._startup.writer = self._on_startup_written

    def reset(self, scope: Reset) -> None:
        self._port.listen(self, Object.NMT, NMT_ID, self._on_frame)

    def command(self, command: Command) -> None:
        """Execute a command of the master, or of the node itself after an error."""
        scope = RESETS.get(command)
        if scope is not None:
            self.boot(scope)
        elif self.state is not NEXT_STATE[command]:
            self._go(NEXT_STATE[command])

    def boot(self, scope: Reset) -> None:
        """Initialise the node, send the boot-up message in time, and enter 'pre-operational'."""
        self._booting.stop()
        self._go(State.INITIALISING)
        self._restart(scope)
        if self._port.node_id == UNCONFIGURED:
            return
        if self._boot_up_ns:
            self._booting.after(self._boot_up_ns, self._boot_up)
        else:
            self._boot_up()

    def _boot_up(self) -> None:
        self._port.send(ERROR_CONTROL_ID + self._port.node_id, BOOT_UP)
        self._go(State.PRE_OPERATIONAL)
        if self._startup is not None and not self._startup.number & IS_STARTED_BY_OTHERS:
            self._go(State.OPERATIONAL)

    def power_off(self) -> None:
        self._booting.stop()
        self._go(State.INITIALISING)

    def _on_startup_written(self, data: bytes) -> None:
        if data[0] & IS_MASTER:
            raise Abort(Code.INVALID_VALUE)
        assert self._startup is not None
        self._startup.set(data)

    def _go(self, state: State) -> None:
        self.state = state
        self._enter(state)

    def _on_frame(self, frame: CanFrame) -> None:
        if len(frame.data) != 2 or frame.data[1] not in (0, self._port.node_id):
            return
        command = COMMANDS.get(frame.data[0])
        if command is not None:
            self.command(command)
