"""The start-up of the VME DualPort: synchronisation, configuration and initialisation (section 11.5).

The manual does not say who clears a command.  Either the PAM does, and the master clears the acknowledge before its
next command (`pam`), or the master does, and the PAM clears the acknowledge then (`master`).
"""

from collections.abc import Callable, Mapping
from typing import Final, Protocol

from fieldrig_devices.pam.language.ports import PortVariable
from fieldrig_devices.pam.ports.dual_port import DualPortState
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.vme.layout import (
    ACKNOWLEDGE,
    COMMAND,
    DEF_OUT_REPLY,
    PAM_PARAMETERS,
    SYNCHRO,
    VME_PARAMETERS,
    Answer,
    Command,
    class_codes,
)

NO_KEY: Final = 0xFFFF_FFFF
"""The key -1 of an output that the master does not know."""
_ROUNDS: Final = 2
_NOP: Final = int(Command.NOP)
"""A plain number, as it is compared in every basic cycle."""


class Owner(Protocol):
    """The port, as its start-up sees it."""

    state: DualPortState
    may_run: bool

    @property
    def inputs(self) -> list[PortVariable]:
        """The inputs; the PAM key of each is its place in this list, from 1."""

    @property
    def is_in_empty(self) -> bool:
        """True if the input FIFO is empty."""

    def enter(self, state: DualPortState) -> None: ...

    def configure(self, crc: int, key: int) -> PortVariable | None:
        """Give an output the master's key; None if no output has this CRC."""


class StartUp:
    """Answers the commands of the master; `poll` is called once per basic cycle."""

    def __init__(self, memory: Memory, owner: Owner, options: PortOptions) -> None:
        self._words, self._owner = memory.words, owner
        self._is_cleared_by_master = options.command_cleared_by == "master"
        self._class_codes = class_codes(options.class_codes)
        self._def_out_reply = DEF_OUT_REPLY[options.def_out_reply]
        self._round = self._sent = 0
        self._is_answered = self._is_reading = False

    def begin(self) -> None:
        """Pre-set the command port; SYNCHRO keeps what is in it (manual lines 9415 to 9422)."""
        self._round = self._sent = 0
        self._is_answered = self._is_reading = False
        self._words[PAM_PARAMETERS] = 0
        self._words[ACKNOWLEDGE] = Answer.ACK_OK

    @property
    def is_reading(self) -> bool:
        """True from INIT_IN on."""
        return self._is_reading

    def synchronise(self) -> bool:
        """Take a step of the synchronisation if the master allows one; return whether it did."""
        if self._words[SYNCHRO] != 0:
            return False
        if self._is_cleared_by_master:  # its first command may follow the first SYNCHRO
            self._words[ACKNOWLEDGE] = Answer.NO_ACK
        self._words[SYNCHRO] = 1
        self._round += 1
        if self._round == _ROUNDS:
            self._owner.enter(DualPortState.CONFIG_IN)
        return True

    def poll(self) -> bool:
        """Answer a command; return whether there was one."""
        code = self._words[COMMAND]
        if code == _NOP:
            if self._is_answered:
                self._words[ACKNOWLEDGE] = Answer.NO_ACK
                self._is_answered = False
            return False
        if self._is_answered:
            return False
        answer = self._answer(code)
        if answer is None:
            return False
        if self._is_cleared_by_master:
            self._is_answered = True
        else:
            self._words[COMMAND] = Command.NOP
        self._words[ACKNOWLEDGE] = answer
        return True

    def _answer(self, code: int) -> Answer | None:
        """Carry a command out; None if its acknowledge has to wait."""
        if code not in _CODES:
            return Answer.BAD_CDE
        if code == Command.START:
            return self._start()
        handler = _HANDLERS.get((self._owner.state, Command(code)))
        return Answer.CDE_REJECTED if handler is None else handler(self)

    def _ask_def_in(self) -> Answer:
        inputs = self._owner.inputs
        if self._sent == len(inputs):
            return Answer.END_DEF_IN
        variable = inputs[self._sent]
        self._sent += 1
        self._give(
            variable.crc, self._sent, self._class_codes[variable.kind], variable.number, min(variable.period_ms, 0xFFFF)
        )
        return Answer.ACK_OK

    def _first_output(self) -> Answer:
        """Leave the configuration of the inputs with the first command about outputs."""
        if self._sent < len(self._owner.inputs):
            return Answer.CDE_REJECTED
        self._owner.enter(DualPortState.CONFIG_OUT)
        answer = self._answer(self._words[COMMAND])
        assert answer is not None
        return answer

    def _def_out(self) -> Answer:
        crc, low, high = (self._words[VME_PARAMETERS + word] for word in range(3))
        variable = self._owner.configure(crc, high << 16 | low)
        if variable is None:
            return Answer.BAD_CRC
        self._words[self._def_out_reply] = self._class_codes[variable.kind]
        self._words[self._def_out_reply + 1] = variable.number
        return Answer.ACK_OK

    def _end_def_out(self) -> Answer:
        self._owner.enter(DualPortState.INIT)
        return Answer.ACK_OK

    def _init_in(self) -> Answer:
        self._is_reading = True
        return Answer.ACK_OK

    def _end_init_in(self) -> Answer | None:
        if not self._is_reading:
            return Answer.CDE_REJECTED
        if not self._owner.is_in_empty:
            return None
        self._owner.enter(DualPortState.WAIT_START)
        return Answer.ACK_OK

    def _start(self) -> Answer:
        """Start the application, even if the configuration is not complete (PAMS-076); its port is served then too."""
        if self._owner.may_run:
            return Answer.CDE_REJECTED
        is_complete = self._owner.state is DualPortState.WAIT_START
        self._owner.enter(DualPortState.RUN)
        return Answer.ACK_OK if is_complete else Answer.CDE_REJECTED

    def _give(self, *values: int) -> None:
        for cell, value in enumerate(values, PAM_PARAMETERS):
            self._words[cell] = value


_CODES: Final = frozenset(Command)
# Section 11.5, steps 6 to 15.  A command that is not listed for a state is rejected.
_HANDLERS: Final[Mapping[tuple[DualPortState, Command], Callable[[StartUp], Answer | None]]] = {
    (DualPortState.CONFIG_IN, Command.ASK_DEF_IN): StartUp._ask_def_in,
    (DualPortState.CONFIG_IN, Command.DEF_OUT): StartUp._first_output,
    (DualPortState.CONFIG_IN, Command.END_DEF_OUT): StartUp._first_output,
    (DualPortState.CONFIG_OUT, Command.DEF_OUT): StartUp._def_out,
    (DualPortState.CONFIG_OUT, Command.END_DEF_OUT): StartUp._end_def_out,
    (DualPortState.INIT, Command.INIT_IN): StartUp._init_in,
    (DualPortState.INIT, Command.END_INIT_IN): StartUp._end_init_in,
}
