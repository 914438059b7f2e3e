"""A master at the VME DualPort: start-up, and values by name (sections 11.4 to 11.7).

It knows the variables by their names and gives an output the number of its definition, from 1, as its key.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

from fieldrig_devices.pam.language.ports import PortVariable
from fieldrig_devices.pam.ports.masters.definitions import UNKNOWN, Definitions
from fieldrig_devices.pam.ports.masters.script import MasterError, Pause, Read, Script, Write, read, wait_for
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.vme.crcs import with_crcs
from fieldrig_devices.pam.ports.vme.layout import (
    ACKNOWLEDGE,
    BLOCK_SIZE,
    COMMAND,
    DEF_OUT_REPLY,
    HEAD,
    IN_HEADER,
    MAX_BLOCKS,
    OFFSET,
    OUT_HEADER,
    PAM_PARAMETERS,
    SYNCHRO,
    TAIL,
    VME_PARAMETERS,
    WATCHDOG,
    Answer,
    Command,
    class_codes,
    index_on_wire,
    input_block,
    item_on_wire,
    value_of,
)
from fieldrig_devices.pam.runtime.item import Value

WATCHDOG_NS: Final = 10_000_000
PAM_TIMEOUT_NS: Final = 500_000_000


class Header(NamedTuple):
    """The place and size of the body of a FIFO, in words."""

    body: int
    blocks: int
    size: int


class VmeMaster:
    """The master at the VME DualPort of a PAM: its scripts read and write words of the memory."""

    def __init__(
        self, variables: Iterable[PortVariable], options: PortOptions | None = None, patience_ns: int = 5_000_000_000
    ) -> None:
        """`patience_ns` limits each wait for the PAM."""
        options = options or PortOptions()
        self._patience_ns = patience_ns
        self._clears_command = options.command_cleared_by == "master"
        self._def_out_reply, self._first_item = DEF_OUT_REPLY[options.def_out_reply], options.first_item
        self._known = Definitions(with_crcs(variables, options), class_codes(options.class_codes))
        self._headers: dict[int, Header] = {}
        self._head = self._tail = self._missed = 0

    @property
    def values(self) -> Mapping[str, Sequence[Value]]:
        """The last values of all variables, by name and item."""
        return self._known.values

    @property
    def mistakes(self) -> Sequence[str]:
        """Definitions of the PAM that differ, and blocks that make no sense."""
        return self._known.mistakes

    # ---- start-up

    def start_up(self, initial: Mapping[str, Value | Sequence[Value]] | None = None) -> Script[None]:
        """Bring the PAM to its application.  Inputs without an initial value begin with 0."""
        yield from self.synchronise()
        yield from self.configure_inputs()
        yield from self.configure_outputs()
        yield from self.initialise(initial or {})
        answer = yield from self.command(Command.START)
        if answer != Answer.ACK_OK:
            self._known.mistakes.append("the PAM has started with an incomplete configuration")

    def synchronise(self) -> Script[None]:
        self._known.forget_keys()
        self._known.begin_outputs()
        self._head = self._tail = self._missed = 0
        yield Write(COMMAND, (Command.NOP,))
        yield Write(VME_PARAMETERS, (0,))
        yield from wait_for(SYNCHRO, lambda value: value != 0, "the first SYNCHRO", self._patience_ns)
        yield Write(SYNCHRO, (0,))
        yield from wait_for(SYNCHRO, lambda value: value == 1, "the second SYNCHRO", self._patience_ns)
        yield Write(SYNCHRO, (0,))
        for header in (IN_HEADER, OUT_HEADER):
            words = yield Read(header, 5)
            self._headers[header] = Header(words[OFFSET] // 2, words[MAX_BLOCKS], words[BLOCK_SIZE] // 2)

    def command(self, command: Command, *parameters: int) -> Script[int]:
        """Give a command and return its acknowledge."""
        if not self._clears_command:
            yield Write(ACKNOWLEDGE, (Answer.NO_ACK,))
        for word, value in enumerate(parameters, VME_PARAMETERS):
            yield Write(word, (value,))
        yield Write(COMMAND, (command,))
        name = f"the acknowledge of {command.name}"
        answer = yield from wait_for(ACKNOWLEDGE, lambda value: value != Answer.NO_ACK, name, self._patience_ns)
        if self._clears_command:
            yield Write(COMMAND, (Command.NOP,))
            yield from wait_for(ACKNOWLEDGE, lambda value: value == Answer.NO_ACK, "NO_ACK", self._patience_ns)
        return answer

    def configure_inputs(self) -> Script[None]:
        while True:
            answer = yield from self.command(Command.ASK_DEF_IN)
            if answer == Answer.END_DEF_IN:
                return
            if answer != Answer.ACK_OK:
                raise MasterError(f"ASK_DEF_IN was answered by {answer}")
            crc, key, code, number = yield Read(PAM_PARAMETERS, 4)
            self._known.take_input(crc, key, code, number)

    def configure_outputs(self) -> Script[None]:
        for key, variable in enumerate(self._known.outputs, 1):
            answer = yield from self.command(Command.DEF_OUT, variable.crc, key & 0xFFFF, key >> 16)
            if answer != Answer.ACK_OK:
                self._known.mistakes.append(f"the PAM does not know the output {variable.name}")
                continue
            code, number = yield Read(self._def_out_reply, 2)
            self._known.take_output(key, code, number)
        yield from self.command(Command.END_DEF_OUT)

    def initialise(self, initial: Mapping[str, Value | Sequence[Value]]) -> Script[None]:
        yield from self.command(Command.INIT_IN)
        for variable, index, value in self._known.initial(initial):
            while not (yield from self.put(variable.name, value, index)):
                yield Pause()
        yield from self.command(Command.END_INIT_IN)

    # ---- execution

    def put(self, name: str, value: Value, index: int = 0) -> Script[bool]:
        """Send a value of an input, -1 as index for all items.  Return False if there is no room now."""
        key, variable = self._known.key(name), self._known.input(name)
        if key == UNKNOWN:
            return True
        header = self._headers[IN_HEADER]
        following = (self._head + 1) % header.blocks
        tail = yield from read(IN_HEADER + TAIL)
        if following == tail:
            return False
        block = input_block(key, index_on_wire(variable, index, self._first_item), variable.kind, value)
        for cell, word in enumerate(block, header.body + self._head * header.size):
            yield Write(cell, (word,))
        yield Write(IN_HEADER + HEAD, (following,))
        self._head = following
        self._known.keep(variable, index, value)
        return True

    def take(self) -> Script[list[tuple[str, int, Value]]]:
        """Read everything in the output FIFO; return the changes as name, item and value."""
        header = self._headers[OUT_HEADER]
        changes: list[tuple[str, int, Value]] = []
        head = yield from read(OUT_HEADER + HEAD)
        while head != self._tail:
            block = yield Read(header.body + self._tail * header.size, header.size)
            self._tail = (self._tail + 1) % header.blocks
            yield Write(OUT_HEADER + TAIL, (self._tail,))
            variable = self._known.output(block[1] << 16 | block[0])
            if variable is None:
                continue
            index = item_on_wire(variable, block[2], self._first_item)
            value = value_of(variable.kind, tuple(block[3:]))
            if self._known.keep(variable, index, value):
                changes.append((variable.name, index, value))
        return changes

    def watch(self) -> Script[bool]:
        """Serve the watchdog; call it every 10 ms.  Return False if the PAM is dead."""
        value = yield from read(WATCHDOG)
        if value == 0:
            self._missed = 0
            yield Write(WATCHDOG, (1,))
        else:
            self._missed += 1
        return self._missed * WATCHDOG_NS <= PAM_TIMEOUT_NS
