"""The faults of a CANopen node: what it does wrong on its own, on a bus that works.

Source of the frames: CiA 301 version 4.2, 7.2.4 (SDO), 7.2.2 (PDO), 7.2.8 (NMT, boot-up, heartbeat).  SDO faults
concern the default server of the node.  Block transfers have no segments here: only their initiation matches.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import Field

from fieldrig.clock import MS, Clock
from fieldrig.faults.faults import LONGEST_MS, Fault, Repeated, Timed, models_of
from fieldrig.faults.hex_bytes import Hex
from fieldrig.faults.injected import InjectedFaults
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.abort import Code
from fieldrig_devices.canopen.cob_id import can_key
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.nmt import BOOT_UP, ERROR_CONTROL_ID
from fieldrig_devices.canopen.pdo import tpdo
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.sdo.server import ABORTED, REQUEST_ID, RESPONSE_ID

MOST_SEGMENTS: Final = 1 << 30
TOGGLE: Final = 0x10


class OfTransfer(Repeated):
    """The SDO transfers, and the request in them, that a fault concerns."""

    index: int | None = Field(default=None, ge=0, le=0xFFFF, description="index of the object; left out: any")
    subindex: int | None = Field(default=None, ge=0, le=0xFF, description="its sub-index; left out: any")
    transfer: Literal["upload", "download"] | None = Field(default=None, description="direction; left out: both")
    segment: int | None = Field(
        default=None, ge=1, le=MOST_SEGMENTS, description="segment of the transfer, from 1; left out: its first request"
    )


class SdoAbort(OfTransfer):
    """The node aborts a transfer, and does not do what was asked."""

    what: Literal["sdo_abort"]
    code: int = Field(default=Code.GENERAL, ge=0, le=0xFFFF_FFFF, description="abort code")


class SdoSilence(OfTransfer):
    """The node does what an SDO request asks, and does not answer."""

    what: Literal["sdo_silence"]


class SdoDelay(OfTransfer):
    """The node answers an SDO request late."""

    what: Literal["sdo_delay"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")


class SdoToggle(OfTransfer):
    """The toggle bit of a segment is wrong; without `segment`, that of every segment."""

    what: Literal["sdo_toggle"]


class LateBootUp(Repeated):
    """The boot-up message comes late, and until then the node neither sends nor hears anything."""

    what: Literal["late_boot_up"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")


class HeartbeatLost(Repeated):
    """The heartbeat is missing; everything else works."""

    what: Literal["heartbeat_lost"]


class PdoLength(Repeated):
    """A TPDO has another length than its mapping."""

    what: Literal["pdo_length"]
    pdo: int = Field(default=1, ge=1, le=512, description="number of the TPDO")
    length: int = Field(ge=0, le=8, description="its bytes; missing ones are 0")


class Silent(Timed):
    """The node neither sends nor hears anything."""

    counts_uses: ClassVar[bool] = True
    what: Literal["silent"]


class Emergency(Timed):
    """The node has an error of its own, and reports it by EMCY; a reset of the node forgets the error."""

    what: Literal["emergency"]
    code: int = Field(ge=1, le=0xFFFF, description="error code")
    error_register: int = Field(default=1, ge=0, le=0xFF, description="its bits of the error register (1001h)")
    info: Hex = Field(default="", max_length=14, description="up to 5 bytes of the maker, as hex digits")


NodeFault = Annotated[
    SdoAbort | SdoSilence | SdoDelay | SdoToggle | LateBootUp | HeartbeatLost | PdoLength | Silent | Emergency,
    Field(discriminator="what"),
]
MODELS: Final[Mapping[str, type[Any]]] = models_of(NodeFault)
NodeFaults = InjectedFaults[Fault[Any]]


class _Request:
    """The last SDO request, and the transfer that it belongs to."""

    __slots__ = ("index", "multiplexer", "segment", "subindex", "transfer")

    def __init__(self) -> None:
        self.multiplexer, self.index, self.subindex = bytes(3), -1, -1
        self.transfer = ""
        self.segment: int | None = None

    def take(self, data: bytes) -> None:
        """Note a request.  Client command specifiers 1 and 2 initiate a transfer, 0 and 3 ask for its segments."""
        specifier = data[0] >> 5
        if specifier in (0, 3):
            self.segment = 1 + (self.segment or 0)
            return
        self.transfer = {1: "download", 2: "upload", 5: "upload", 6: "download"}.get(specifier, "")
        self.multiplexer, self.segment = data[1:4], None
        self.index, self.subindex = int.from_bytes(data[1:3], "little"), data[3]

    def fits(self, fault: OfTransfer) -> bool:
        return (
            bool(self.transfer)
            and fault.index in (None, self.index)
            and fault.subindex in (None, self.subindex)
            and fault.transfer in (None, self.transfer)
        )


class FaultyEnd:
    """The end of the bus of a node with faults, between the node's port and its link."""

    def __init__(self, clock: Clock, link: Link[Any], port: Port, dictionary: Dictionary, faults: NodeFaults) -> None:
        self._clock, self._link, self._port, self._dictionary, self._faults = clock, link, port, dictionary, faults
        self._request = _Request()
        self._handled = 0
        self._absent_until_ns = 0

    def use(self) -> None:
        """Be the end of the bus that the port uses while the node has such faults."""
        now_ns = self._clock.now_ns()
        live = any(not fault.is_over(now_ns) for fault in self._faults.records.of(*MODELS.values()))
        self._port.use(self if live else self._link)

    def send(self, message: Any) -> None:
        if not isinstance(message, CanFrame):
            self._link.send(message)
            return
        now_ns, node_id, key = self._clock.now_ns(), self._port.node_id, message.identifier
        if key == ERROR_CONTROL_ID + node_id and message.data == BOOT_UP:
            late = self._strike(LateBootUp, lambda _: True)
            if late is not None:
                self._absent_until_ns = now_ns + round(late.delay_ms * MS)
                self._clock.call_at(self._absent_until_ns, partial(self._link.send, message))
                return
        if now_ns < self._absent_until_ns or self._is_silent():
            return
        if key == RESPONSE_ID + node_id:
            self._answer(message)
        elif key == ERROR_CONTROL_ID + node_id:
            if message.data == BOOT_UP or self._strike(HeartbeatLost, lambda _: True) is None:
                self._link.send(message)
        else:
            wrong = self._strike(PdoLength, partial(self._is_of_pdo, message))
            data = message.data if wrong is None else message.data[: wrong.length].ljust(wrong.length, b"\0")
            self._link.send(message if wrong is None else CanFrame(key, data, message.is_extended))

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        self._link.on_receive(partial(self._hear, handler), interest)

    # ---- parts

    def _hear(self, handler: Callable[[Any], None], message: Any) -> None:
        if not isinstance(message, CanFrame):
            handler(message)
        elif self._clock.now_ns() >= self._absent_until_ns and not self._is_silent():
            if message.identifier == REQUEST_ID + self._port.node_id and len(message.data) == 8:
                self._ask(handler, message)
            else:
                handler(message)

    def _ask(self, handler: Callable[[Any], None], message: CanFrame) -> None:
        request = self._request
        request.take(message.data)
        refused = self._strike(SdoAbort, lambda fault: request.fits(fault) and fault.segment == request.segment)
        if refused is None:
            handler(message)
            return
        frame = ABORTED.pack(0x80, request.multiplexer, refused.code)
        if request.segment is not None:  # the server ends its transfer as if the client had aborted it
            handler(CanFrame(message.identifier, frame))
        self._link.send(CanFrame(RESPONSE_ID + self._port.node_id, frame))

    def _answer(self, message: CanFrame) -> None:
        request = self._request

        def fits(fault: OfTransfer) -> bool:
            return request.fits(fault) and fault.segment == request.segment

        if self._strike(SdoSilence, fits) is not None:
            return
        if request.segment is not None and message.data[0] >> 5 in (0, 1):
            toggled = self._strike(
                SdoToggle, lambda fault: request.fits(fault) and fault.segment in (None, request.segment)
            )
            if toggled is not None:
                message = CanFrame(message.identifier, bytes((message.data[0] ^ TOGGLE,)) + message.data[1:])
        late = self._strike(SdoDelay, fits)
        if late is None:
            self._link.send(message)
        else:
            self._clock.call_at(self._clock.now_ns() + round(late.delay_ms * MS), partial(self._link.send, message))

    def _strike(self, kind: type[Any], fits: Callable[[Any], bool]) -> Any:
        """Return the settings of the first fault of this kind that applies now, and count it; None if none does."""
        now_ns = self._clock.now_ns()
        self._handled += 1
        for fault in self._faults.records.of(kind):
            if fault.is_on(now_ns) and fits(fault.settings) and fault.happens(self._handled):
                self._faults.records.use(fault)
                return fault.settings
        return None

    def _is_silent(self) -> bool:
        return self._strike(Silent, lambda _: True) is not None

    def _is_of_pdo(self, message: CanFrame, fault: PdoLength) -> bool:
        cob_id = self._dictionary.get(tpdo.COMMUNICATION + fault.pdo - 1, 1)
        return cob_id is not None and can_key(cob_id.number) == message.identifier
