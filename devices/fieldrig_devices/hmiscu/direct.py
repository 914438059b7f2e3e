"""The blocks of a controller without a program: one instance of each block of a channel, worked by their pins.

MAST calls them in each cycle in the order of the chain of references: PTOSimple, the motion blocks, then the
administrative ones.  A pin takes any value of its type, and the block judges it.
"""

from collections.abc import Iterator
from functools import partial

from fieldrig.device import Point, Value
from fieldrig.points.checks import truth_in, whole_in
from fieldrig_devices.hmiscu.blocks.pins import WIDTHS, Block, Pin, Side
from fieldrig_devices.hmiscu.blocks.tables import BLOCK_TYPES
from fieldrig_devices.hmiscu.names import BLOCK_NAMES, SIMPLE
from fieldrig_devices.hmiscu.plc.library import MakeBlock
from fieldrig_devices.hmiscu.settings import HmiscuSettings

_REFERENCE = "PTO_REF_IN"


class DirectBlocks:
    """The instances."""

    def __init__(self, settings: HmiscuSettings, make: MakeBlock) -> None:
        self._make = make
        self._names = dict(_names(settings))
        self.blocks: dict[str, Block] = {}
        self.renew()

    def renew(self) -> None:
        """Begin again with the defaults of all pins."""
        self.blocks = {
            name: self._make(
                BLOCK_TYPES[BLOCK_NAMES[known]], name if known == SIMPLE or known.startswith("PWM") else ""
            )
            for known, name in self._names.items()
        }

    def call(self, now_ns: int) -> None:
        reference = 0
        for block in self.blocks.values():
            if _REFERENCE in block.inputs:
                block.inputs[_REFERENCE] = reference
            block.call(now_ns)
            reference = block.outputs.get("PTO_REF", reference)

    def points(self) -> Iterator[tuple[str, Point]]:
        for name, block in self.blocks.items():
            for pin in block.type.pins:
                if pin.type != "PTO_REF":
                    read = partial(self._read, name, pin)
                    write = partial(self._write, name, pin) if pin.side is Side.INPUT else None
                    yield f"{name}.{pin.name}", Point(read, write, about=pin.about)

    def _read(self, name: str, pin: Pin) -> Value:
        block = self.blocks[name]
        value = (block.inputs if pin.side is Side.INPUT else block.outputs)[pin.name]
        return bool(value) if pin.type == "BOOL" else value

    def _write(self, name: str, pin: Pin, value: Value) -> None:
        """Set an input.  ValueError for a value that its type does not have."""
        most = (1 << WIDTHS[pin.type]) - 1
        self.blocks[name].inputs[pin.name] = truth_in(value) if pin.type == "BOOL" else whole_in(value, 0, most)


def _names(settings: HmiscuSettings) -> Iterator[tuple[str, str]]:
    """Yield the known name and the present name of each block of the channels."""
    first, second = settings.variables
    for known in BLOCK_NAMES:
        if known == "PWM00" and settings.channel_0.mode == "pwm":
            yield known, first or known
        elif known == "PWM01" and settings.channel_1.mode == "pwm":
            yield known, second or known
        elif not known.startswith("PWM") and settings.channel_0.mode == "pto":
            yield known, (first or known) if known == SIMPLE else known
