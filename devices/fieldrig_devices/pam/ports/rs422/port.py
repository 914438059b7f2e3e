"""The PAM's end of the RS422 line, called once per basic cycle (chapter 15).

The application runs whether or not a master is there; without one, the variables are internal.  Where the manual is
silent: E039 is shown once until its cancel, a change that finds the send queue full waits for a second, and a request
of the master ends a session that is under way.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import Final

from fieldrig_devices.pam.language.ports import PortPlan, PortVariable
from fieldrig_devices.pam.ports.rs422.codec import Codec, FramedCodec, LineFault
from fieldrig_devices.pam.ports.rs422.messages import CLASS_OF, Code, Message, Result, exchange
from fieldrig_devices.pam.ports.rs422.sending import SendQueue
from fieldrig_devices.pam.ports.rs422.session import COMMANDS, Phase, Session, acknowledge
from fieldrig_devices.pam.ports.variables import IsActive, PortItem, PortStatus, addressed, items_of
from fieldrig_devices.pam.runtime.item import Kernel, Value

RECEIVE_BUFFER: Final = 4096
"""Bytes that may arrive in one basic cycle."""
ROOM_NS: Final = 1_000_000_000
"""How long a change waits for room in the send queue."""
_DISCONNECTED, _NO_ACTIVITY, _REFUSED = "039", "035", "036"


class Rs422State(Enum):
    WAIT_REQUEST = "waiting for a request"
    CONFIGURING = "configuring"
    RUNNING = "running"
    FATAL = "fatal error"


class Rs422Port:
    panel: int | None = None
    """The panel is in the other port, or where a PAM without DualPort has it."""

    def __init__(
        self,
        plan: PortPlan,
        kernel: Kernel,
        is_active: IsActive,
        send: Callable[[bytes], None],
        baud: int,
        codec: Codec | None = None,
    ) -> None:
        self._plan, self._kernel = plan, kernel
        self.status = PortStatus("RS422Port", plan, kernel)
        self.items: Mapping[str, Sequence[PortItem]] = items_of(plan.variables, kernel, is_active, self._changed)
        self.state = Rs422State.WAIT_REQUEST
        self._codec = codec or FramedCodec()
        self._queue = SendQueue(send, baud)
        self._period = plan.numbers("PERIOD")[0]
        self._received = bytearray()
        self._session = self._new_session()
        self._due: dict[PortItem, Value] = {}
        """Inputs that are updated at the end of the period."""
        self._waiting: deque[tuple[bytes, int]] = deque()
        """Changes of outputs that found no room in the send queue, with their instants."""
        self._is_overrun = False
        self._shown: set[str] = set()
        """Numbers of the errors that are shown and not cancelled."""
        self._fault: LineFault | None = None
        self._deadline_ns: int | None = None
        self._now_ns = self._sent_ns = 0

    # ---- for the PAM

    @property
    def may_run(self) -> bool:
        return self.state is not Rs422State.FATAL

    @property
    def state_text(self) -> str:
        return self.state.value

    def begin(self, now_ns: int) -> None:
        self._now_ns = now_ns
        self.status.set_error(False)
        self._shown.clear()
        self._received.clear()
        self._due.clear()
        self._fault = None
        for items in self.items.values():
            for item in items:
                item.preset()
        self._kernel.report("07..M020")
        self._wait_for_request("MASTER_READY_TIMEOUT")

    def receive(self, data: bytes) -> None:
        """Take bytes from the line; they are looked at in the next basic cycle."""
        room = RECEIVE_BUFFER - len(self._received)
        self._received += data[:room]
        if len(data) > room and self.state is not Rs422State.FATAL:
            self._on_fault(LineFault.BUFFER_FULL)

    def poll(self, now_ns: int) -> None:
        """Answer what has arrived, and look at the time-outs."""
        self._now_ns = now_ns
        if self.state is Rs422State.FATAL:
            return
        if self._received:
            data = bytes(self._received)
            self._received.clear()
            for event in self._codec.decode(data):
                if isinstance(event, LineFault):
                    self._on_fault(event)
                else:
                    self._on_message(event)
        if self._deadline_ns is not None and now_ns >= self._deadline_ns:
            self._on_timeout()
        if self.state is Rs422State.RUNNING:
            self._stay_alive()
        self._queue.pump(now_ns)

    def fail(self) -> None:
        """Stop for a fatal error; only `begin` leads on."""
        self.state = Rs422State.FATAL
        self._deadline_ns = None

    def take(self) -> None:
        """Update the inputs that are due."""
        if self._due and self._kernel.cycle_number % self._period == 0:
            due, self._due = self._due, {}
            for item, value in due.items():
                item.receive(value)

    def give(self) -> None:
        """Hand what was changed in this basic cycle to the line."""
        if self._waiting:
            self._flush()
        self._queue.pump(self._now_ns)

    # ---- session

    def _new_session(self) -> Session:
        return Session(self._plan, self._kernel, self._on_value)

    def _wait_for_request(self, timeout: str = "") -> None:
        self._enter(Rs422State.WAIT_REQUEST, timeout)
        self._waiting.clear()
        self._queue.clear()
        self._kernel.report("07..M024")

    def _enter(self, state: Rs422State, timeout: str) -> None:
        self.state = state
        duration_ns = self.status.duration_ns(timeout)
        self._deadline_ns = None if duration_ns is None else self._now_ns + duration_ns

    def _on_message(self, message: Message) -> None:
        self._fault = None
        if message.code not in COMMANDS:
            self._kernel.report("07..E037")
            self._answer(acknowledge(message, Result.BAD_COMMAND))
        elif message.code == Code.REQUEST:
            self._on_request(message)
        elif self.state is Rs422State.CONFIGURING:
            self._configure(message)
        elif self.state is Rs422State.RUNNING:
            self._enter(Rs422State.RUNNING, "MASTER_INACTIVITY_TIMEOUT")
            if message.code in CLASS_OF:
                self._session.value(message)
            elif message.code != Code.ALIVE:
                self._refuse(message)
        elif message.code != Code.ALIVE:
            self._refuse(message)

    def _on_request(self, message: Message) -> None:
        self._session = self._new_session()
        self._waiting.clear()
        self._queue.clear()
        self._kernel.report("07..M021")
        self._enter(Rs422State.CONFIGURING, "MASTER_CONFIGURATION_TIMEOUT")
        self._answer(acknowledge(message, Result.OK))

    def _configure(self, message: Message) -> None:
        self._enter(Rs422State.CONFIGURING, "MASTER_CONFIGURATION_TIMEOUT")
        if message.code == Code.ALIVE:
            return
        if message.code == Code.START and self._session.phase is Phase.READY:
            self._answer(acknowledge(message, Result.OK))
            self._run()
            return
        before = self._session.phase
        answer = self._session.answer(message)
        if answer is None:
            self._refuse(message)
            return
        self._answer(answer)
        if before is not self._session.phase is Phase.READY:
            self._kernel.report("07..M022")

    def _run(self) -> None:
        if self._session.has_mistakes:
            self._kernel.report("07..E03D")
        for number in (_DISCONNECTED, _NO_ACTIVITY, _REFUSED):
            if number in self._shown:
                self._shown.discard(number)
                self._kernel.report(f"07..S{number}")
        self.status.set_error(False)
        self._kernel.report("07..M023")
        self._sent_ns = self._now_ns
        self._enter(Rs422State.RUNNING, "MASTER_INACTIVITY_TIMEOUT")
        for variable in self._plan.outputs:
            for item in self.items[variable.name]:
                if item.value():  # the master begins with 0
                    self._changed(item)

    def _refuse(self, message: Message) -> None:
        self._show(_REFUSED)
        self._answer(acknowledge(message, Result.REJECTED))

    def _answer(self, message: Message) -> None:
        self._sent_ns = self._now_ns
        self._queue.put(self._codec.encode(message))

    # ---- faults and time-outs

    def _show(self, number: str) -> None:
        """Show an error that is not shown already."""
        if number not in self._shown:
            self._shown.add(number)
            self._kernel.report(f"07..E{number}")

    def _on_fault(self, fault: LineFault) -> None:
        self._fault = fault
        if self.state is not Rs422State.WAIT_REQUEST:
            self._kernel.report("07..E03A", (fault, 0, 0))

    def _on_timeout(self) -> None:
        if self._fault is not None:
            self._kernel.report("07..W03A", (self._fault, 0, 0))
        self._deadline_ns = None
        if self.state is Rs422State.RUNNING:
            self._show(_NO_ACTIVITY)
            self.status.set_error(True)
        else:
            self._show(_DISCONNECTED)
        if self.state is not Rs422State.WAIT_REQUEST:
            self._wait_for_request()

    def _stay_alive(self) -> None:
        period_ns = self.status.duration_ns("PAM_WATCHDOG_MESSAGE_PERIOD")
        if period_ns and self._now_ns - self._sent_ns >= period_ns:
            self._answer(Message(Code.ALIVE))

    # ---- variables

    def _on_value(self, variable: PortVariable, index: int, value: Value) -> None:
        for item in addressed(self.items[variable.name], index):
            self._due[item] = value

    def _changed(self, item: PortItem) -> None:
        """Send a change of an output that the master knows, as soon as there is room."""
        key = self._session.keys.get(item.variable.name)
        if self.state is not Rs422State.RUNNING or key is None or not item.is_served:
            return
        frame = self._codec.encode(exchange(item.variable.kind, key, item.index, item.value()))
        self._sent_ns = self._now_ns
        if self._waiting or not self._queue.put(frame):
            self._waiting.append((frame, self._now_ns))

    def _flush(self) -> None:
        """Move changes that wait into the send queue; one that has waited for too long is lost, which is shown once."""
        while self._waiting:
            frame, since_ns = self._waiting[0]
            is_late = self._now_ns - since_ns >= ROOM_NS
            if not is_late and not self._queue.put(frame):
                return
            if is_late and not self._is_overrun:
                self._kernel.report("07..E038")
            self._is_overrun = is_late
            self._waiting.popleft()
