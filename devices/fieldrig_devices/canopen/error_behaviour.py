"""The node's reaction to communication errors (1029h sub-index 1).

Source: CiA 301 7.5.2.32.  Without the object, the node changes from 'operational' to 'pre-operational'.
"""

from collections.abc import Callable

from fieldrig_devices.canopen import emcy
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.nmt import Command, NmtSlave
from fieldrig_devices.canopen.service import Reset, Service, State
from fieldrig_devices.canopen.variable import Variable

ERROR_BEHAVIOUR = 0x1029

REACTIONS = {0: Command.ENTER_PRE_OPERATIONAL, 1: None, 2: Command.STOP}
"""NMT commands by value of 1029h; value 0 applies in 'operational' only."""


class ErrorBehaviour(Service):
    def __init__(
        self, dictionary: Dictionary, errors: "emcy.Emcy", nmt: NmtSlave, on_change: Callable[[bool], None]
    ) -> None:
        self._dictionary, self._errors, self._nmt, self._on_change = dictionary, errors, nmt, on_change
        self._lost: list[str] = []
        self._is_off = False
        for entry in dictionary.members(ERROR_BEHAVIOUR):
            entry.writer = _writer(entry)

    def reset(self, scope: Reset) -> None:
        self._lost.clear()

    def on_lost(self, what: str, is_lost: bool) -> None:
        """Handle the loss of a monitored node, or its return; `what` is the service that monitors it."""
        if is_lost:
            self._lost.append(what)
            self._errors.raise_error(emcy.Error.HEARTBEAT, emcy.COMMUNICATION)
            self._react()
        elif what in self._lost:
            self._lost.remove(what)
        if not self._lost:
            self._errors.clear_error(emcy.Error.HEARTBEAT)
        self._report()

    def on_bus_off(self, is_off: bool) -> None:
        """Handle bus-off of the CAN controller, or its recovery."""
        self._is_off = is_off
        if is_off:
            self._react()
        self._report()

    def _report(self) -> None:
        self._on_change(bool(self._lost) or self._is_off)

    def _react(self) -> None:
        reaction = REACTIONS.get(self._dictionary.number(ERROR_BEHAVIOUR, 1))
        if reaction is None or (reaction is not Command.STOP and self._nmt.state is not State.OPERATIONAL):
            return
        self._nmt.command(reaction)


def _writer(entry: Variable) -> Callable[[bytes], None]:
    def write(data: bytes) -> None:
        if data[0] not in REACTIONS:
            raise Abort(Code.INVALID_VALUE)
        entry.set(data)

    return write
