"""The program of a Smart-IO node: it takes its items from the PAM, works with them, and reports what changes.

Source: chapters 2.4 to 2.6, 11 and 12 of the manual, appendices B.6, E and F.  At rest a cycle of the ring costs
nothing: every report comes from an edge, a timer or an order.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final

from fieldrig.clock import Clock
from fieldrig_devices.pamring.ends import NodePort, RingFault
from fieldrig_devices.pamring.frames import (
    AnalogItem,
    Answer,
    AxisItem,
    Blink,
    Configuration,
    CounterItem,
    Display,
    InputItem,
    KeyItem,
    LedItem,
    MotorItem,
    MotorOrder,
    Order,
    OutputItem,
    Read,
    Report,
    SetOutput,
    SevenSegmentItem,
    Trouble,
)
from fieldrig_devices.smart_io import display as shown
from fieldrig_devices.smart_io.addresses import POSITIONS, exists, place_of
from fieldrig_devices.smart_io.backlog import RECEPTION, Backlog
from fieldrig_devices.smart_io.board import Board
from fieldrig_devices.smart_io.heap import size_of
from fieldrig_devices.smart_io.items import (
    Analog,
    Inputs,
    KeyInput,
    Led,
    MotorDrive,
    MotorParts,
    NodeItem,
    Outputs,
    PulseCounter,
    SevenSegment,
)
from fieldrig_devices.smart_io.settings import SmartIoSettings
from fieldrig_devices.smart_io.troubles import NODE, NODE_BITS, FaultCode

_ORDERS: Final[Mapping[type[Any], Callable[[NodeItem, Any], bool]]] = {
    SetOutput: lambda item, order: item.set(order.value, order.number),
    Blink: lambda item, order: item.blink(order.on),
    Display: lambda item, order: item.display(order.character),
    MotorOrder: lambda item, order: item.move(order.order, order.values, order.number),
}
Scanned = InputItem | CounterItem | KeyItem
_BEFORE_RUN: Final = (FaultCode.HEAP, FaultCode.UNKNOWN_TYPE)


class SmartIoProgram:
    """Implements `NodeProgram` of the ring."""

    def __init__(self, clock: Clock, board: Board, settings: SmartIoSettings, on_owner: Callable[[], None]) -> None:
        """`on_owner` is called when a PAM takes the node over, before anything else of it is carried out."""
        self._clock, self._board, self._on_owner = clock, board, on_owner
        self._settings, self._heap_bytes = settings, settings.heap_bytes
        self._holds = settings.outputs_without_ring == "hold"
        self._used = 0
        """Bytes of the heap that items occupy."""
        self._items: dict[int, NodeItem] = {}
        self._sizes: dict[int, int] = {}
        self._backlog = Backlog()
        self._port: NodePort | None = None
        self.is_working = False
        self.is_owned = False
        """True once a PAM has taken the node over."""

    def attach(self, port: NodePort) -> None:
        """Take the node's end of the ring, to which reports go."""
        self._port = port
        self._board.display.phase = shown.Phase.NOT_CONFIGURED

    def send(self, report: Report) -> None:
        """Report something to the PAM while the node works."""
        if self.is_working and self._port is not None:
            self._port.send(report)

    def _answer(self, answer: Answer) -> None:
        """Answer an inquiry, which may come before the node works."""
        if self._port is not None:
            self._port.send(answer)

    def tell(self, trouble: Trouble) -> None:
        """Report a fault; those of the configuration are reported before the node works."""
        is_early = trouble.code == NODE and trouble.details[0] in _BEFORE_RUN
        if is_early and self.is_owned and self._port is not None:
            self._port.send(trouble)
        else:
            self.send(trouble)

    # ---- what the ring's end calls (`NodeProgram`)

    def forget(self) -> None:
        if not self.is_owned:
            self.is_owned = True
            self._on_owner()
        self._drop_items()
        self._board.troubles.forget()
        self._board.display.phase = shown.Phase.CONFIGURING

    def accept(self, item: Configuration) -> bool:
        if isinstance(item, AxisItem):
            self._board.troubles.event(FaultCode.UNKNOWN_TYPE)
            return False
        size, before = size_of(item), self._sizes.get(item.item, 0)
        if self._used + size - before > self._heap_bytes:
            self._board.display.is_heap_full = True
            self._board.troubles.begin(NODE, (FaultCode.HEAP, 0), NODE_BITS[FaultCode.HEAP])
            return False
        replaced = self._items.pop(item.item, None)
        if replaced is not None:
            replaced.close()
        made = self._made(item)
        if made is None:
            self._used -= self._sizes.pop(item.item, 0)
            return False
        self._items[item.item], self._sizes[item.item] = made, size
        self._used += size - before
        self._board.display.phase = shown.Phase.CONFIGURING
        return True

    def run(self) -> None:
        self.is_working = True
        self._board.display.phase = shown.Phase.WORKING
        self._board.troubles.repeat()
        for item in self._items.values():
            item.run()

    def order(self, order: Order) -> None:
        if not self._backlog.takes(self._clock.now_ns()):
            self._board.display.show_full_fifo(RECEPTION)
            self._board.troubles.event(FaultCode.FIFO, RECEPTION)
            return
        if isinstance(order, Read):
            item = self._items.get(order.register)
            self._answer(Answer(order.request, None if item is None else item.read()))
            return
        act = _ORDERS.get(type(order))
        if act is None:
            self._board.troubles.event(FaultCode.UNKNOWN_COMMAND)
            return
        item = self._items.get(order.item)  # type: ignore[union-attr]  # every order of the table has one
        if item is None:
            self._board.troubles.event(FaultCode.UNDECLARED_ITEM)
        elif not act(item, order):
            self._board.troubles.event(FaultCode.COMMAND_NOT_ALLOWED)

    def cycle(self) -> None:
        """Do nothing: what is due comes by timers and edges."""

    def ring(self, fault: RingFault) -> None:
        self._board.display.ring = fault
        self._board.look()
        if fault in (RingFault.INACTIVE, RingFault.CARRIER):
            for item in self._items.values():
                item.lose_ring(self._holds)

    # ---- items

    def lose(self) -> None:
        """Lose the configuration, as with a low battery: F 4."""
        self._drop_items()
        self.is_owned = False
        if self._port is not None:
            self._board.display.phase = shown.Phase.NOT_CONFIGURED

    def _drop_items(self) -> None:
        self.is_working = False
        for item in reversed(self._items.values()):  # a motor before its outputs
            item.close()
        self._items.clear()
        self._sizes.clear()
        self._used = 0
        self._board.display.is_heap_full = False

    def _made(self, item: Configuration) -> NodeItem | None:
        """Return the item at work; None if this node cannot have it (04..E01A)."""
        clock, board = self._clock, self._board
        terminals, readings = board.terminals, self._settings.readings
        match item:
            case InputItem(address=address, bits=bits) if self._are_there(address, bits) and _is_scan(item):
                names = [f"in{address + bit}" for bit in range(bits)]
                return Inputs(clock, terminals, item, names, self.send, is_stamped=readings.time_stamps)
            case CounterItem(address=address) if self._are_there(address, 1) and _is_scan(item):
                return PulseCounter(clock, terminals, item, f"in{address}", self.send)
            case KeyItem(address=address) if _is_scan(item) and item.delay_ms >= 0 and item.repeat_ms >= 0:
                name = f"in{address}" if item.is_on_binary_input else f"key{address}"
                is_there = self._are_there(address, 1) if item.is_on_binary_input else board.has_key(address)
                is_pulsed = readings.autorepeat == "pulses"
                return KeyInput(clock, terminals, item, name, self.send, is_pulsed=is_pulsed) if is_there else None
            case OutputItem(address=address, bits=bits) if self._are_there(address, bits):
                return Outputs(terminals, item, [f"out{address + bit}" for bit in range(bits)])
            case AnalogItem(address=1) if not self._has(Analog):
                return Analog(board.put_analog)
            case LedItem(address=address) if address in board.lamps:
                return Led(board.lamps[address])
            case SevenSegmentItem(address=1, digits=1) if board.has_display and not self._has(SevenSegment):
                return SevenSegment(board.display)
            case MotorItem():
                return self._made_motor(item)
        return None

    def _made_motor(self, item: MotorItem) -> NodeItem | None:
        parts = [self._items.get(number) for number in (item.increase, item.decrease, item.zero, item.counter)]
        match parts:
            case [
                Outputs(is_single=True, is_of_motor=False) as increase,
                Outputs(is_single=True, is_of_motor=False) as decrease,
                Inputs(is_single=True) as zero,
                PulseCounter() as counter,
            ] if increase is not decrease and item.timeout_ms > 0 and item.braking >= 0:
                together = MotorParts(increase, decrease, zero, counter)
                return MotorDrive(self._clock, item, together, self._settings, self._board.troubles, self.send)
        return None

    def _are_there(self, address: int, bits: int) -> bool:
        """True for consecutive channels of one module; a number of bits does not cross its end (G-07)."""
        module, position = place_of(address)
        return exists(address) and module in self._board.modules and 1 <= bits <= POSITIONS - position + 1

    def _has(self, item_class: type[NodeItem]) -> bool:
        return any(isinstance(item, item_class) for item in self._items.values())


def _is_scan(item: Scanned) -> bool:
    return item.period_ms >= 1 and item.debounce >= 1
