"""The node's connection to the CAN bus, shared by its services: dispatches frames by identifier and NMT state."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fieldrig.link import Link
from fieldrig_bus.can.acceptance import STATE
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BusState, use_bit_rate
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.service import ALLOWED, Object, State

Handler = Callable[[CanFrame], None]

UNCONFIGURED = 255
"""The node-ID of an unconfigured node, which only LSS reaches."""

BASE_MASK = EXTENDED_KEY | 0x7FF
EXTENDED_MASK = EXTENDED_KEY | 0x1FFF_FFFF


class Port:
    """Sends frames, and passes received frames to the services that listen.

    The interest in the bus is the set of all identifiers with a listener, in every NMT state: a frame may follow an NMT
    command faster than a change of the interest could reach the bus.
    """

    def __init__(self, can: Link[CanFrame], node_id: int) -> None:
        self._can = can
        self.node_id = node_id
        """Node-ID; LSS changes it only between resets of the services."""
        self._listeners: dict[object, tuple[Object, int, Handler]] = {}
        self._routes: dict[int, Handler] = {}
        self._interest: list[int] | None = None
        self._is_batching = False
        self._silences = 0
        self.has_heard = False
        """True once a frame of another node has been received."""
        self._on_bus_state: Callable[[BusState], None] | None = None
        self.state = State.INITIALISING

    def send(self, key: int, data: bytes) -> None:
        """Send a data frame; `key` is the identifier, with bit 31 set for 29 bits."""
        if self._silences > 0:
            return
        if key < EXTENDED_KEY:
            self._can.send(CanFrame(key, data))
        else:
            self._can.send(CanFrame(key - EXTENDED_KEY, data, is_extended=True))

    def listen(self, owner: object, carried: Object, key: int | None, handler: Handler) -> None:
        """Let `owner` receive frames with `key` in `handler`, instead of its previous key; None removes it."""
        wanted = None if key is None else (carried, key, handler)
        if wanted == self._listeners.get(owner):
            return
        if wanted is None:
            del self._listeners[owner]
        else:
            self._listeners[owner] = wanted
        if not self._is_batching:
            self._connect()

    @property
    def link(self) -> Link[CanFrame]:
        """The end of the bus that it uses."""
        return self._can

    def use(self, can: Link[CanFrame]) -> None:
        """Use another end of the same bus from now on."""
        if can is not self._can:
            self._can, self._interest = can, None
            self._connect()

    def on_bus_state(self, handler: Callable[[BusState], None]) -> None:
        """Call `handler` when the CAN controller changes its state."""
        self._on_bus_state = handler

    def use_bit_rate(self, bit_per_s: int) -> None:
        """Set the bit rate of the CAN controller; this works while silent, too."""
        use_bit_rate(self._can, bit_per_s)

    def fall_silent(self) -> None:
        """Neither send nor receive until `speak` has been called as many times."""
        self._silences += 1

    def speak(self) -> None:
        self._silences -= 1

    def enter(self, state: State) -> None:
        """Receive the communication objects that `state` allows."""
        self.state = state
        self._connect_routes()

    @contextmanager
    def batch(self) -> Iterator[None]:
        """Combine all changes inside the context into one change of the interest."""
        self._is_batching = True
        try:
            yield
        finally:
            self._is_batching = False
            self._connect()

    def _connect(self) -> None:
        self._connect_routes()
        is_configured = self.node_id != UNCONFIGURED
        listeners = self._listeners.values()
        interest = sorted({key for carried, key, _ in listeners if is_configured or carried is Object.LSS})
        if interest != self._interest:
            self._interest = interest
            words = [] if self._on_bus_state is None else [STATE]
            self._can.on_receive(self._on_message, [*(_accept(key) for key in interest), *words])

    def _connect_routes(self) -> None:
        handlers: dict[int, list[Handler]] = {}
        is_booting = self.state is State.INITIALISING and self.node_id != UNCONFIGURED
        for carried, key, handler in self._listeners.values():
            if carried in ALLOWED[self.state] and not is_booting:
                handlers.setdefault(key, []).append(handler)
        self._routes = {key: several[0] if len(several) == 1 else _all(several) for key, several in handlers.items()}

    def _on_message(self, frame: CanFrame | BusState) -> None:
        if isinstance(frame, BusState):
            if self._on_bus_state is not None:
                self._on_bus_state(frame)
            return
        self.has_heard = True
        key = frame.identifier
        if frame.is_extended:
            key |= EXTENDED_KEY
        handler = self._routes.get(key)
        if handler is not None and not frame.is_fd and self._silences == 0:
            handler(frame)


def _accept(key: int) -> list[int]:
    return [key, EXTENDED_MASK if key & EXTENDED_KEY else BASE_MASK]


def _all(handlers: list[Handler]) -> Handler:
    def handle(frame: CanFrame) -> None:
        for handler in handlers:
            handler(frame)

    return handle
