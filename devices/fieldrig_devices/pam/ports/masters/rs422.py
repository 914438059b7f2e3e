"""A master at the RS422 line: session, and values by name (section 13.1).

It is passive: `receive` takes bytes from the line, `poll` the instant, and `send` gets the bytes for the line.
"""

from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from typing import Final

from fieldrig_devices.pam.language.ports import PortVariable
from fieldrig_devices.pam.ports.masters.definitions import UNKNOWN, Definitions
from fieldrig_devices.pam.ports.rs422.codec import Codec, FramedCodec, LineFault
from fieldrig_devices.pam.ports.rs422.messages import CLASS_NUMBERS, CLASS_OF, Code, Message, Result, exchange
from fieldrig_devices.pam.runtime.item import Value

REPEAT_NS: Final = 1_000_000_000
"""Time after which an unanswered request begins again."""
WATCHDOG_NS: Final = 2_000_000_000
"""RS422_WATCH_DOG_TIMEOUT: time without a message after which the PAM is dead."""
ALIVE_NS: Final = 500_000_000

_Conversation = Generator[Message, Message, None]
"""Yields commands, and gets their answers."""


class Rs422Master:
    """The master at the RS422 line of a PAM: it reads and writes the variables of the port."""

    def __init__(
        self,
        variables: Iterable[PortVariable],
        send: Callable[[bytes], None],
        initial: Mapping[str, Value | Sequence[Value]] | None = None,
        codec: Codec | None = None,
    ) -> None:
        """`initial` has the values of inputs at the start; others begin with 0."""
        self._send, self._codec, self._initial = send, codec or FramedCodec(), initial or {}
        self._known = Definitions(variables, CLASS_NUMBERS)
        self._conversation: _Conversation | None = None
        self._now_ns = self._sent_ns = self._heard_ns = 0
        self.is_running = False
        self.changes: list[tuple[str, int, Value]] = []
        """Changes of outputs in their order; the caller removes them."""

    @property
    def values(self) -> Mapping[str, Sequence[Value]]:
        """The last values of all variables, by name and item."""
        return self._known.values

    @property
    def mistakes(self) -> Sequence[str]:
        """Definitions of the PAM that differ, and faults of the line."""
        return self._known.mistakes

    def begin(self, now_ns: int) -> None:
        """Ask for a session."""
        self._now_ns = self._heard_ns = now_ns
        self.is_running = False
        self._known.forget_keys()
        self._conversation = self._configure()
        self._say(next(self._conversation))

    def poll(self, now_ns: int) -> None:
        """Repeat a request that was not answered, and stay alive; call it every few milliseconds."""
        self._now_ns = now_ns
        limit_ns = WATCHDOG_NS if self.is_running else REPEAT_NS
        if now_ns - self._heard_ns >= limit_ns:
            self.begin(now_ns)
        elif self.is_running and now_ns - self._sent_ns >= ALIVE_NS:
            self._say(Message(Code.ALIVE))

    def receive(self, data: bytes) -> None:
        for message in self._codec.decode(data):
            if isinstance(message, LineFault):
                self._known.mistakes.append(f"line fault: {message.name}")
                continue
            self._heard_ns = self._now_ns
            if message.code in CLASS_OF:
                self._on_value(message)
            elif message.code in (Code.ACK, Code.DEF_IN) and self._conversation is not None:
                self._go_on(message)

    def put(self, name: str, value: Value, index: int = 0) -> None:
        """Send a value of an input, -1 as index for all items."""
        key, variable = self._known.key(name), self._known.input(name)
        if self.is_running and key != UNKNOWN:
            self._say(exchange(variable.kind, key, index, value))
            self._known.keep(variable, index, value)

    def _say(self, message: Message) -> None:
        self._sent_ns = self._now_ns
        self._send(self._codec.encode(message))

    # ---- configuration

    def _go_on(self, answer: Message) -> None:
        assert self._conversation is not None
        try:
            self._say(self._conversation.send(answer))
        except StopIteration:
            self._conversation = None
            self.is_running = True

    def _configure(self) -> _Conversation:
        yield Message(Code.REQUEST)
        while (definition := (yield Message(Code.ASK_DEF_IN))).code == Code.DEF_IN:
            self._known.take_input(*(int(value) for value in definition.values[:4]))
        for key, variable in enumerate(self._known.outputs, 1):
            _, result, class_code, number = (yield Message(Code.DEF_OUT, (variable.crc, key))).values
            if result == Result.OK:
                self._known.take_output(key, int(class_code), int(number))
            else:
                self._known.mistakes.append(f"the PAM does not know the output {variable.name}")
        yield Message(Code.END_DEF_OUT)
        yield Message(Code.INIT_IN)
        for variable, index, value in self._known.initial(self._initial):
            key = self._known.key(variable.name)
            if key != UNKNOWN:
                yield exchange(variable.kind, key, index, value)
                self._known.keep(variable, index, value)
        yield Message(Code.END_INIT_IN)
        yield Message(Code.START)

    # ---- execution

    def _on_value(self, message: Message) -> None:
        key, index, value = int(message.values[0]), int(message.values[1]), message.values[2]
        variable = self._known.output(key)
        if variable is None or variable.kind != CLASS_OF[message.code]:
            return
        typed = bool(value) if variable.kind == "FLAG_VAR" else value
        if self._known.keep(variable, index, typed):
            self.changes.append((variable.name, index, typed))
