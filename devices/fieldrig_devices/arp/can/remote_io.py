"""The remote I/O of the card: CiA 401 modules with the card as their master, I201 to I332 and O201 to O332.

Source: manual 3.2 (I/O nodes 1 and 2), digest chapters 9 and 20: inputs 6000h:1 to 4 are the bytes of TPDO1, outputs
6200h:1 to 4 those of RPDO1.  A lost module, or a card in bus-off, is E06 (digest 10.3).  After a module was started,
its inputs are also read by SDO, since not every module sends a TPDO then.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.can.acceptance import STATE
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_bus.can.notices import BusState, CanState
from fieldrig_bus.can.shared import SharedLink
from fieldrig_devices.arp import card_errors as codes
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.canopen.abort import Abort
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.managed_slave import ManagedSlave, Write

HEARTBEAT_MS: Final = 100
TPDO1, RPDO1 = 0x180, 0x200
INPUTS: Final = 0x6000
BYTES, BITS = 4, 32
"""Input and output size of a module."""
ALL_OFF: Final = [0] * BITS


class RemoteIo:
    """Exchanges `inputs` and `outputs` with the modules: elements from 201 on (first module) and 301 on (second)."""

    def __init__(
        self,
        clock: Clock,
        can: Link[CanFrame],
        node_ids: Sequence[int | None],
        inputs: list[int],
        outputs: list[int],
        errors: CardErrors,
        heartbeat_ms: int = HEARTBEAT_MS,
        *,
        readings: Readings | None = None,
        configuration: Sequence[Write] = (),
    ) -> None:
        """`node_ids` are those of I/O node 1 and 2, None for a node that is not fitted.

        `can` is a link end for this use only.  `configuration` is written to each module before it is started.
        """
        self._errors = errors
        shared = SharedLink(can)
        is_zeroed = (readings or Readings()).lost_io == "zero"
        self._modules = [
            _Module(
                clock,
                shared,
                node_id,
                (inputs, outputs, 100 * number + 1),
                heartbeat_ms,
                configuration,
                is_zeroed,
                self.fail,
            )
            for number, node_id in enumerate(node_ids, start=2)
            if node_id is not None
        ]
        self._is_frozen = True
        self._is_off = False
        shared.share().on_receive(self._on_bus_state, [STATE])

    @property
    def is_lost(self) -> bool:
        """True if a module is missing or the card is bus-off."""
        return self._is_off or any(module.is_lost for module in self._modules)

    @property
    def nodes(self) -> list[ManagedSlave]:
        return [module.node for module in self._modules]

    def start(self) -> None:
        """Configure and start the modules at power-on.  Their outputs are at 0 until `release`."""
        for module in self._modules:
            module.node.start()

    def refresh(self) -> None:
        """Update inputs with received data and send changed outputs; call it in each pass of the scheduler."""
        for module in self._modules:
            module.refresh(self._is_frozen)

    def freeze(self) -> None:
        """Set all outputs to 0 at once, because the card is disabled.  E06 does not replace the card's own error."""
        self._is_frozen = True
        self.refresh()

    def release(self) -> None:
        """Let outputs follow again, because the card is enabled and its errors are cleared.

        Missing modules cause E06 again.
        """
        self._is_frozen = False
        if self.is_lost:
            self.fail()

    def fail(self) -> None:
        if not self._is_frozen:
            self._errors.fail(codes.CAN)

    def _on_bus_state(self, notice: Any) -> None:
        was_off = self._is_off
        self._is_off = isinstance(notice, BusState) and notice.state is CanState.BUS_OFF
        if self._is_off == was_off:
            return
        if self._is_off:
            self.fail()
        for module in self._modules:
            module.on_bus_off(self._is_off)


class _Module:
    """One I/O node; `place` gives its tables of inputs and outputs, and the number of its first element."""

    def __init__(
        self,
        clock: Clock,
        shared: SharedLink,
        node_id: int,
        place: tuple[list[int], list[int], int],
        heartbeat_ms: int,
        configuration: Sequence[Write],
        is_zeroed: bool,
        fail: Callable[[], None],
    ) -> None:
        self._inputs, self._outputs, first = place
        self._range = slice(first, first + BITS)
        self._is_zeroed, self._fail = is_zeroed, fail
        self._can = shared.share()
        self.node = ManagedSlave(
            clock,
            shared.share(),
            node_id,
            heartbeat_ms,
            self._on_lost,
            self._on_back,
            configuration=configuration,
        )
        self._image = bytearray(BYTES)
        self._is_fresh = False
        self._sent: list[int] | None = None
        """Outputs that the module has received, or None if that is unknown."""
        self.is_lost = False
        self._can.on_receive(self._on_tpdo, [[TPDO1 + node_id, EXTENDED_KEY | STANDARD_MASK]])

    def refresh(self, is_frozen: bool) -> None:
        if self._is_fresh:
            self._is_fresh = False
            word = int.from_bytes(self._image, "little")
            self._inputs[self._range] = [word >> bit & 1 for bit in range(BITS)]
        if self.node.is_running:
            levels = ALL_OFF if is_frozen else self._outputs[self._range]
            if levels != self._sent:
                self._send(levels)

    def on_bus_off(self, is_off: bool) -> None:
        if is_off:
            self._clear_inputs()
        elif self.node.is_running:
            self._renew()

    def _send(self, levels: list[int]) -> None:
        self._sent = levels
        word = sum(level << bit for bit, level in enumerate(levels))
        self._can.send(CanFrame(RPDO1 + self.node.node_id, word.to_bytes(BYTES, "little")))

    def _on_lost(self) -> None:
        self.is_lost = True
        self._clear_inputs()
        self._fail()

    def _on_back(self) -> None:
        self.is_lost = False
        self._renew()

    def _clear_inputs(self) -> None:
        if self._is_zeroed:
            self._image[:] = bytes(BYTES)
            self._is_fresh = True

    def _renew(self) -> None:
        """Send the outputs in the next pass, and request the inputs."""
        self._sent = None
        for number in range(BYTES):
            self.node.sdo.upload(INPUTS, number + 1, partial(self._on_input, number))

    def _on_tpdo(self, frame: CanFrame) -> None:
        if self.node.is_running and not frame.is_remote:
            self._take(0, frame.data[:BYTES])

    def _on_input(self, number: int, answer: bytes | Abort) -> None:
        if isinstance(answer, bytes):
            self._take(number, answer[:1])

    def _take(self, first: int, data: bytes) -> None:
        self._image[first : first + len(data)] = data
        self._is_fresh = True
