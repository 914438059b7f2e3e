"""What the node does when communication with others fails (1029h sub-index 1).

Source: CiA 301 7.5.2.32; without the object the node leaves 'operational' for 'pre-operational'.
"""

from collections.abc import Callable

from fieldrig_devices.canopen import emcy
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.nmt import Command, NmtSlave
from fieldrig_devices.canopen.service import State
from fieldrig_devices.canopen.variable import Variable

ERROR_BEHAVIOUR = 0x1029

REACTIONS = {0: Command.ENTER_PRE_OPERATIONAL, 1: None, 2: Command.STOP}
"""To values of 1029h; the first holds in 'operational' only."""


class ErrorBehaviour:
    def __init__(
        self, dictionary: Dictionary, errors: "emcy.Emcy", nmt: NmtSlave, on_change: Callable[[bool], None]
    ) -> None:
        self._dictionary, self._errors, self._nmt, self._on_change = dictionary, errors, nmt, on_change
        for entry in dictionary.members(ERROR_BEHAVIOUR):
            entry.writer = _writer(entry)

    def on_heartbeat_lost(self, is_lost: bool) -> None:
        """A heartbeat that was watched is gone, or all are back."""
        if is_lost:
            self._errors.raise_error(emcy.Error.HEARTBEAT, emcy.COMMUNICATION)
            self._react()
        else:
            self._errors.clear_error(emcy.Error.HEARTBEAT)
        self._on_change(is_lost)

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
