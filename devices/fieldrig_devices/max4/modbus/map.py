"""The registers of the controller itself, and a window to any parameter of its object tree.

The map is ours (docs/devices/pacdrive/max4-modbus.md; digest PD-306).  A parameter is selected by its logical address,
as in IEC code (PD-025).  Parameters behind SERCOS are slow here too (PD-028): a read returns the value that was last
received.
"""

from collections.abc import Callable, Iterator
from enum import IntEnum, IntFlag
from typing import Final

from fieldrig.device import Value
from fieldrig_devices.max4.configuration.tree import Access, Object, Parameter
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.modbus.axis import up_to
from fieldrig_devices.registers.live import BitEntry, Entry, whole

MAP_NUMBER: Final = 0x4D34
"""The letters M4, which identify this map."""
MAP_VERSION: Final = 1
CONTROLLER_SIZE: Final = 100
WINDOW: Final = 200
WINDOW_SIZE: Final = 100
MEASURING: Final = 500
"""Address of the first measuring input among the discrete inputs."""
_U32: Final = 0xFFFF_FFFF


class Status(IntFlag):
    """Bits of the status register."""

    BOOTED = 0x01
    DIAGNOSIS = 0x02
    ERROR = 0x04
    """A diagnosis of class 1 to 5 is pending at the controller or an axis."""
    CONTROLLED = 0x08
    """At least one axis is under control."""
    ALL_CONTROLLED = 0x10


class Order(IntEnum):
    """Values of the register `order`."""

    NOTHING = 0
    QUIT = 1


def status_of(controller: Controller) -> int:
    """The bits of `Status`; function 7 returns the lowest eight."""
    axes = controller.axes.values()
    bits = {
        Status.BOOTED: controller.is_booted,
        Status.DIAGNOSIS: controller.diagnosis.code != 0,
        Status.ERROR: controller.diagnosis.is_error or any(axis.is_in_error for axis in axes),
        Status.CONTROLLED: any(axis.is_controlled for axis in axes),
        Status.ALL_CONTROLLED: bool(axes) and all(axis.is_controlled for axis in axes),
    }
    return sum(bit for bit, is_on in bits.items() if is_on)


def controller_entries(controller: Controller) -> Iterator[Entry]:
    own = controller.tree.root
    last = [int(Order.NOTHING)]

    def order(value: Value) -> None:
        last[0] = int(value)
        if last[0] == Order.QUIT:
            controller.quit_all()

    def shown(address: int, name: str, type: str, unit: str = "", about: str = "") -> Entry:
        parameter = own[name]
        return Entry(address, name, type, lambda: parameter.value, unit=unit, about=about)

    entries = [
        Entry(0, "map", "u16", lambda: MAP_NUMBER, about="4D34h identifies this map"),
        Entry(1, "map_version", "u16", lambda: MAP_VERSION),
        Entry(2, "axes", "u16", lambda: len(controller.axes), about="number of axes"),
        shown(3, "CycleTime", "u16", "ms"),
        Entry(4, "status", "u16", lambda: status_of(controller), about="bits"),
        shown(5, "DiagCode", "u16", about="0: no diagnosis is pending"),
        shown(6, "Timer1", "u32", "ms"),
        shown(8, "Timer10", "u32", "10 ms"),
        shown(10, "CycleLoad", "u16", "%"),
        shown(11, "MsgEntries", "u16", about="entries in the message logger"),
        shown(12, "RTBReadRes", "s32", "us"),
        shown(14, "RTBWriteRes", "s32", "us"),
        shown(16, "Diskfree", "u32", "Byte"),
        shown(18, "Memoryfree", "u32", "Byte"),
        Entry(
            20, "order", "u16", lambda: last[0], order, up_to(Order.QUIT), about="1: acknowledge (quit) all diagnoses"
        ),
        shown(30, "DiagExtCode", "string[20]", about="Latin-1"),
        shown(40, "DiagMsg", "string[80]", about="Latin-1"),
        shown(80, "SoftwareVersion", "string[20]"),
    ]
    return whole(entries, CONTROLLER_SIZE)


class Found(IntEnum):
    """Kinds of what a window shows at its logical address."""

    READABLE = 0
    WRITABLE = 1
    OBJECT = 2
    NOTHING = 3


ACCESS: Final = {Access.OUTPUT: 0, Access.INPUT: 1, Access.INPUT_INIT: 2, Access.SLOW: 3}


class Window:
    """A window that shows one parameter at a time; each bus has a window of its own."""

    def __init__(self, controller: Controller) -> None:
        self._tree = controller.tree
        self._address = 0

    def entries(self) -> Iterator[Entry]:
        write = self._write
        entries = [
            Entry(WINDOW, "address", "u32", lambda: self._address, self._select, about="logical address"),
            Entry(WINDOW + 2, "found", "u16", self._found, about="kind of what is at this address"),
            Entry(WINDOW + 3, "type", "u16", self._type, about="IEC type"),
            Entry(WINDOW + 4, "kind", "u16", self._access, about="kind of access"),
            Entry(
                WINDOW + 10, "number", "u32", self._number, self._write_number, self._check_number,
                about="whole number; s32 for INT, DINT",
            ),
            Entry(WINDOW + 12, "real", "f64", self._real, write, self._check, about="any number"),
            Entry(WINDOW + 16, "text", "string[80]", self._text, write, self._check, about="STRING, Latin-1"),
            Entry(WINDOW + 60, "name", "string[40]", self._name, about="name of the parameter or object"),
            Entry(WINDOW + 80, "unit", "string[16]", self._unit),
        ]  # fmt: skip
        return whole(entries, WINDOW_SIZE)

    def _select(self, value: Value) -> None:
        self._address = int(value)

    def _parameter(self) -> Parameter | None:
        return self._tree.parameter_at(self._address)

    def _found(self) -> int:
        node = self._tree.at(self._address)
        if isinstance(node, Parameter):
            return Found.WRITABLE if node.is_writable else Found.READABLE
        return Found.NOTHING if node is None else Found.OBJECT

    def _type(self) -> int:
        parameter = self._parameter()
        return 0 if parameter is None else parameter.type.number

    def _access(self) -> int:
        parameter = self._parameter()
        return 0 if parameter is None else ACCESS[parameter.access]

    def _unit(self) -> str:
        parameter = self._parameter()
        return "" if parameter is None else parameter.unit

    def _name(self) -> str:
        node = self._tree.at(self._address)
        if node is None:
            return ""
        return node.name if isinstance(node, Parameter) else node.symbol or node.name

    def _number(self) -> int:
        """The lowest 32 bits of the value."""
        value = self._value()
        return 0 if isinstance(value, str) else int(value) & _U32

    def _real(self) -> float:
        value = self._value()
        return 0.0 if isinstance(value, str) else float(value)

    def _text(self) -> str:
        value = self._value()
        return value if isinstance(value, str) else ""

    def _value(self) -> Value:
        parameter = self._parameter()
        return 0 if parameter is None else parameter.value

    def _signed(self, value: Value) -> Value:
        """The value of 32 bits in the type of the parameter."""
        parameter = self._parameter()
        is_signed = parameter is not None and parameter.low < 0
        return int(value) - (1 << 32) if is_signed and int(value) > _U32 >> 1 else value

    def _check(self, value: Value) -> None:
        parameter = self._parameter()
        if parameter is None or not parameter.is_writable:
            raise ValueError(f"expected the address of a writable parameter, got {self._address:#x}")
        parameter.checked(value)

    def _check_number(self, value: Value) -> None:
        self._check(self._signed(value))

    def _write(self, value: Value) -> None:
        parameter = self._parameter()
        assert parameter is not None, "`_check` has accepted it"
        parameter.set(value)

    def _write_number(self, value: Value) -> None:
        self._write(self._signed(value))


def outputs(controller: Controller) -> list[BitEntry]:
    """The coils: digital outputs in the order of the configuration."""
    return [
        BitEntry(address, output.symbol, _bit_reader(output["Value"]), output["Value"].set)
        for address, output in enumerate(_of_type(controller, "D_OUT"))
    ]


def inputs(controller: Controller) -> list[BitEntry]:
    """The discrete inputs: digital inputs, and measuring inputs starting at MEASURING."""
    return [
        BitEntry(first + number, terminal.symbol, _bit_reader(terminal["Value"]))
        for first, type_name in ((0, "D_IN"), (MEASURING, "M_IN"))
        for number, terminal in enumerate(_of_type(controller, type_name))
    ]


def _of_type(controller: Controller, type_name: str) -> Iterator[Object]:
    return (node for node in controller.tree.objects() if node.type_name == type_name)


def _bit_reader(parameter: Parameter) -> Callable[[], bool]:
    return lambda: bool(parameter.value)
