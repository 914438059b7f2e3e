"""LSS slave: receives its node-ID and bit timing over the bus, addressed by its identity or as unconfigured node.

Source: CiA 305 version 3.  A new node-ID takes effect with the reset of communication, or at once if the node had none.
An activated or stored bit timing applies to the node's CAN controller; the bus keeps its own, so that a node with a
different one receives nothing and disturbs the others, as on a physical bus.  On a direct bus the rate is fixed.
"""

from collections.abc import Callable
from enum import IntEnum
from struct import Struct

from fieldrig.clock import MS, Clock
from fieldrig.storage.store import StoreError
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.bit_timing import BIT_RATES
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.nonvolatile import NonVolatile
from fieldrig_devices.canopen.port import UNCONFIGURED, Port
from fieldrig_devices.canopen.service import Object, Reset, Service

REQUEST_ID, RESPONSE_ID = 0x7E5, 0x7E4
IDENTITY = 0x1018
SIZE = 8


class Command(IntEnum):
    """Command specifiers."""

    SWITCH_GLOBAL = 0x04
    CONFIGURE_NODE_ID = 0x11
    CONFIGURE_BIT_TIMING = 0x13
    ACTIVATE_BIT_TIMING = 0x15
    STORE_CONFIGURATION = 0x17
    SELECT_VENDOR = 0x40
    SELECT_SERIAL = 0x43
    SELECTED = 0x44
    IDENTIFY_VENDOR = 0x46
    IDENTIFY_SERIAL_HIGH = 0x4B
    IDENTIFY_NON_CONFIGURED = 0x4C
    IDENTIFIED = 0x4F
    NON_CONFIGURED = 0x50
    FASTSCAN = 0x51
    INQUIRE_VENDOR = 0x5A
    INQUIRE_SERIAL = 0x5D
    INQUIRE_NODE_ID = 0x5E


class State(IntEnum):
    """States of the LSS slave, with the codes of 'switch state global'."""

    WAITING = 0
    CONFIGURATION = 1


DONE, NOT_SUPPORTED, NOT_STORED = 0, 1, 2
"""Error codes of LSS."""

RESET_SCAN = 0x80
"""Bit check value of fastscan that all unconfigured nodes answer."""
SCAN = Struct("<BLBBB")
NUMBER = Struct("<BL3x")
DELAY = Struct("<xH5x")


class LssSlave(Service):
    """The LSS slave of a node; it calls `on_configured` when an unconfigured node has received a node-ID."""

    def __init__(
        self,
        clock: Clock,
        port: Port,
        dictionary: Dictionary,
        kept: NonVolatile,
        node_id: int,
        on_configured: Callable[[], None],
    ) -> None:
        self._clock, self._port, self._dictionary, self._kept = clock, port, dictionary, kept
        self._setting, self._on_configured = node_id, on_configured
        self._bit_rates = dictionary.features.bit_rates
        self.state = State.WAITING
        self.bit_timing = self._pending_timing = kept.bit_timing
        """Index of the bit timing table; None if the node uses the rate of the bus."""
        self.pending_node_id = self._persistent
        self._steps = 0
        """Number of matching messages received in the present sequence."""
        self._scanned = 0
        """Part of the identity that fastscan compares next."""
        self._handlers: dict[int, Callable[[bytes], bytes | None]] = {
            Command.SWITCH_GLOBAL: self._switch,
            Command.IDENTIFY_NON_CONFIGURED: self._identify_non_configured,
            Command.FASTSCAN: self._scan,
        }
        self._handlers |= dict.fromkeys(range(Command.SELECT_VENDOR, Command.SELECTED), self._select)
        self._handlers |= dict.fromkeys(range(Command.IDENTIFY_VENDOR, Command.IDENTIFY_NON_CONFIGURED), self._identify)
        self._configuring: dict[int, Callable[[bytes], bytes | None]] = {
            Command.CONFIGURE_NODE_ID: self._configure_node_id,
            Command.CONFIGURE_BIT_TIMING: self._configure_bit_timing,
            Command.ACTIVATE_BIT_TIMING: self._activate,
            Command.STORE_CONFIGURATION: self._store,
            Command.INQUIRE_NODE_ID: lambda request: _answer(request[0], self._port.node_id),
        }
        self._configuring |= dict.fromkeys(range(Command.INQUIRE_VENDOR, Command.INQUIRE_NODE_ID), self._inquire)

    @property
    def _persistent(self) -> int:
        return self._setting if self._kept.node_id is None else self._kept.node_id

    def node_id_after(self, scope: Reset) -> int:
        """Return the node-ID after a reset: the pending one, or after a reset of the node the stored one."""
        if scope is Reset.NODE:
            self.pending_node_id = self._persistent
        return self.pending_node_id

    def reset(self, scope: Reset) -> None:
        self._set_bit_rate()
        self.state = State.WAITING
        self._steps = self._scanned = 0
        self._port.listen(self, Object.LSS, REQUEST_ID, self._on_frame)

    def _on_frame(self, frame: CanFrame) -> None:
        request = frame.data
        if frame.is_remote or len(request) != SIZE:
            return
        handler = self._handlers.get(request[0])
        if handler is None and self.state is State.CONFIGURATION:
            handler = self._configuring.get(request[0])
        answer = None if handler is None else handler(request)
        if answer is not None:
            self._port.send(RESPONSE_ID, answer)

    # Selection of the node.

    def _part(self, number: int) -> int:
        """Return part 0 to 3 of the identity: vendor, product code, revision, serial number."""
        return self._dictionary.number(IDENTITY, number + 1)

    def _switch(self, request: bytes) -> None:
        self._steps = 0
        if request[1] == State.CONFIGURATION:
            self.state = State.CONFIGURATION
        elif request[1] == State.WAITING:
            self.state = State.WAITING
            if self._port.node_id == UNCONFIGURED != self.pending_node_id:
                self._on_configured()

    def _select(self, request: bytes) -> bytes | None:
        specifier, number = NUMBER.unpack(request)
        if self.state is not State.WAITING:
            return None
        part = specifier - Command.SELECT_VENDOR
        self._steps = part + 1 if part in (0, self._steps) and number == self._part(part) else 0
        if specifier != Command.SELECT_SERIAL or self._steps == 0:
            return None
        self._steps = 0
        self.state = State.CONFIGURATION
        return _answer(Command.SELECTED)

    def _identify(self, request: bytes) -> bytes | None:
        """Compare vendor, product code, then lowest and highest revision and serial number."""
        specifier, number = NUMBER.unpack(request)
        step = specifier - Command.IDENTIFY_VENDOR
        part = self._part((0, 1, 2, 2, 3, 3)[step])
        is_met = (part == number, part == number, part >= number, part <= number, part >= number, part <= number)[step]
        self._steps = step + 1 if step in (0, self._steps) and is_met else 0
        if specifier != Command.IDENTIFY_SERIAL_HIGH or self._steps == 0:
            return None
        self._steps = 0
        return _answer(Command.IDENTIFIED)

    @property
    def _is_non_configured(self) -> bool:
        return self._port.node_id == UNCONFIGURED == self.pending_node_id

    def _identify_non_configured(self, request: bytes) -> bytes | None:
        return _answer(Command.NON_CONFIGURED) if self._is_non_configured else None

    def _scan(self, request: bytes) -> bytes | None:
        _, number, bit, part, following = SCAN.unpack(request)
        if not self._is_non_configured or self.state is not State.WAITING:
            return None
        if bit == RESET_SCAN:
            self._scanned = 0
            return _answer(Command.IDENTIFIED)
        is_sound = bit < 32 and part < 4 and following < 4
        if not is_sound or part != self._scanned or (number ^ self._part(part)) >> bit:
            return None
        self._scanned = following
        if bit == 0 and following < part:
            self.state = State.CONFIGURATION
        return _answer(Command.IDENTIFIED)

    # Configuration and inquiry.

    def _configure_node_id(self, request: bytes) -> bytes:
        node_id = request[1]
        if not 1 <= node_id <= 127 and node_id != UNCONFIGURED:
            return _answer(request[0], NOT_SUPPORTED)
        self.pending_node_id = node_id
        return _answer(request[0], DONE)

    def _configure_bit_timing(self, request: bytes) -> bytes:
        table, index = request[1], request[2]
        if table != 0 or BIT_RATES.get(index) not in self._bit_rates:
            return _answer(request[0], NOT_SUPPORTED)
        self._pending_timing = index
        return _answer(request[0], DONE)

    def _activate(self, request: bytes) -> None:
        (delay_ms,) = DELAY.unpack(request)
        self.bit_timing = self._pending_timing
        self._port.fall_silent()
        now_ns = self._clock.now_ns()
        self._clock.call_at(now_ns + delay_ms * MS, self._set_bit_rate)
        self._clock.call_at(now_ns + 2 * delay_ms * MS, self._port.speak)

    def _set_bit_rate(self) -> None:
        if self.bit_timing is not None:
            self._port.use_bit_rate(BIT_RATES[self.bit_timing])

    def _store(self, request: bytes) -> bytes:
        before = self._kept.node_id, self._kept.bit_timing
        self._kept.node_id, self._kept.bit_timing = self.pending_node_id, self._pending_timing
        try:
            self._kept.save()
        except StoreError:
            self._kept.node_id, self._kept.bit_timing = before
            return _answer(request[0], NOT_STORED)
        return _answer(request[0], DONE)

    def _inquire(self, request: bytes) -> bytes:
        return NUMBER.pack(request[0], self._part(request[0] - Command.INQUIRE_VENDOR))


def _answer(specifier: int, value: int = 0) -> bytes:
    return bytes((specifier, value, 0, 0, 0, 0, 0, 0))
