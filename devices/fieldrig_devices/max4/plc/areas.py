"""The areas %I and %Q: digital inputs and outputs as bits, in the order of the configuration.

Source: PacDrive manual 3048-3050, 6028-6030 (digest PD-070, PD-314): there is no process image; a read gives the
present level, and a write has its effect at once.  The manual assigns no addresses to the terminals.  Ours: input
number n (from 0) is bit n of the area, so that the first sixteen are %IX0.0 to %IX0.15, or %IW0; outputs likewise.
"""

from collections.abc import Callable, Sequence
from functools import partial

from fieldrig_devices.iec.layout import AREA_SIZE
from fieldrig_devices.max4.terminals import DigitalInput, DigitalOutput, Terminals


class Areas:
    """The areas %I and %Q of a program, one byte for eight terminals; each boot begins with zeros."""

    def __init__(self, terminals: Terminals, on_input: Callable[[], None]) -> None:
        """`on_input` is called after each change of an input."""
        self.inputs, self.outputs = bytearray(AREA_SIZE), bytearray(AREA_SIZE)
        self._inputs: Sequence[DigitalInput] = tuple(terminals.inputs.values())
        self._outputs: Sequence[DigitalOutput] = tuple(terminals.outputs.values())
        self._on_input = on_input

    def connect(self) -> None:
        """Follow the terminals from now on, instead of the program before."""
        for number, terminal in enumerate(self._inputs):
            self._connect(self.inputs, number, terminal, self._on_input)
        for number, output in enumerate(self._outputs):
            self._connect(self.outputs, number, output, _nothing)

    def _connect(
        self, area: bytearray, number: int, terminal: DigitalInput | DigitalOutput, then: Callable[[], None]
    ) -> None:
        terminal.watcher = partial(self._show, area, number, then)
        self._show(area, number, _nothing, terminal.value)

    @staticmethod
    def _show(area: bytearray, number: int, then: Callable[[], None], is_on: bool) -> None:
        byte, bit = divmod(number, 8)
        area[byte] = area[byte] & ~(1 << bit) | is_on << bit
        then()

    def on_output(self, byte: int) -> None:
        """Switch the outputs of a byte that the program has written."""
        value = self.outputs[byte]
        for bit, output in enumerate(self._outputs[8 * byte : 8 * byte + 8]):
            output.put(bool(value >> bit & 1))


def _nothing() -> None:
    """There is nothing to do."""
