"""The configuration of a session: definitions, keys and initial values, as on the VME DualPort (section 13.1)."""

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import Final

from fieldrig_devices.pam.language.ports import ALL_ITEMS, PortPlan, PortVariable
from fieldrig_devices.pam.ports.rs422.messages import CLASS_NUMBERS, CLASS_OF, Code, Message, Result
from fieldrig_devices.pam.runtime.item import Kernel, Value

NO_KEY: Final = 0xFFFF_FFFF


class Phase(Enum):
    INPUTS = "inputs"
    OUTPUTS = "outputs"
    VALUES = "initial values"
    READY = "ready to start"


class Session:
    """Answers the commands of one configuration.  The PAM key of an input is its place, from 1."""

    def __init__(self, plan: PortPlan, kernel: Kernel, on_value: Callable[[PortVariable, int, Value], None]) -> None:
        """`on_value` takes the initial value of an item, or of all with the index -1."""
        self._kernel, self._on_value = kernel, on_value
        self._inputs = list(plan.inputs)
        self._outputs = {variable.crc: variable for variable in plan.outputs}
        self.keys: dict[str, int] = {}
        """The master's keys of outputs, by name."""
        self.phase = Phase.INPUTS
        self.has_mistakes = False
        self._sent = 0

    def answer(self, message: Message) -> Message | None:
        """Return the answer to a command; None if it does not belong to this phase."""
        handler = _HANDLERS.get((self.phase, message.code))
        return None if handler is None else handler(self, message)

    def value(self, message: Message) -> Result:
        """Take a value over; one with a wrong key, class or index is reported."""
        key, index, value = (int(message.values[0]), int(message.values[1]), message.values[2])
        if not 1 <= key <= len(self._inputs):
            return self._wrong(Result.BAD_KEY, "07..E03C", key, NO_KEY)
        variable = self._inputs[key - 1]
        var_class = CLASS_OF[message.code]
        if var_class != variable.kind:
            return self._wrong(Result.BAD_CLASS, "07..E03E", CLASS_NUMBERS[var_class], CLASS_NUMBERS[variable.kind])
        if index >= variable.number and not (index == ALL_ITEMS and variable.is_multiple):
            return self._wrong(Result.BAD_KEY, "07..E03C", key, key)
        self._on_value(variable, index, value)
        return Result.OK

    def _wrong(self, result: Result, code: str, given: int, known: int) -> Result:
        self.has_mistakes = True
        self._kernel.report(code, (given, known, 0))
        return result

    def _ask_def_in(self, message: Message) -> Message:
        if self._sent == len(self._inputs):
            return acknowledge(message, Result.END_DEF_IN)
        variable = self._inputs[self._sent]
        self._sent += 1
        number, period_ms = variable.number, min(variable.period_ms, 0xFFFF)
        return Message(Code.DEF_IN, (variable.crc, self._sent, CLASS_NUMBERS[variable.kind], number, period_ms))

    def _first_output(self, message: Message) -> Message | None:
        """Begin with the outputs; None while the master has not asked for all inputs."""
        if self._sent < len(self._inputs):
            return None
        self.phase = Phase.OUTPUTS
        return self.answer(message)

    def _def_out(self, message: Message) -> Message:
        crc, key = (int(value) for value in message.values)
        variable = self._outputs.get(crc)
        if variable is None:
            return acknowledge(message, self._wrong(Result.BAD_CRC, "07..E03B", crc, key))
        self.keys[variable.name] = key
        return acknowledge(message, Result.OK, CLASS_NUMBERS[variable.kind], variable.number)

    def _end_def_out(self, message: Message) -> Message:
        self.phase = Phase.VALUES
        return acknowledge(message, Result.OK)

    def _init_in(self, message: Message) -> Message:
        return acknowledge(message, Result.OK)

    def _initial(self, message: Message) -> Message:
        return acknowledge(message, self.value(message))

    def _end_init_in(self, message: Message) -> Message:
        self.phase = Phase.READY
        return acknowledge(message, Result.OK)


def acknowledge(message: Message, result: Result, class_code: int = 0, number: int = 0) -> Message:
    return Message(Code.ACK, (message.code, result, class_code, number))


_HANDLERS: Final[Mapping[tuple[Phase, int], Callable[[Session, Message], Message | None]]] = {
    (Phase.INPUTS, Code.ASK_DEF_IN): Session._ask_def_in,
    (Phase.INPUTS, Code.DEF_OUT): Session._first_output,
    (Phase.INPUTS, Code.END_DEF_OUT): Session._first_output,
    (Phase.OUTPUTS, Code.DEF_OUT): Session._def_out,
    (Phase.OUTPUTS, Code.END_DEF_OUT): Session._end_def_out,
    (Phase.VALUES, Code.INIT_IN): Session._init_in,
    **{(Phase.VALUES, code): Session._initial for code in CLASS_OF},
    (Phase.VALUES, Code.END_INIT_IN): Session._end_init_in,
}
COMMANDS: Final[Sequence[Code]] = tuple(code for code in Code if code not in (Code.ACK, Code.DEF_IN))
"""Everything that a master may send."""
