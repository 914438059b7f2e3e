"""Outputs of the nodes and of the PAM, and displays (section 2.5 of the language's digest)."""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.inputs import order_of_bits
from fieldrig_devices.pam.objects.object_item import ObjectItem, Switched
from fieldrig_devices.pam.objects.site import ApplicationNode, Site
from fieldrig_devices.pam.pipes.converter import Input, Mode
from fieldrig_devices.pamring.frames import (
    AnalogItem,
    Blink,
    Display,
    LedItem,
    OutputItem,
    SetOutput,
    SevenSegmentItem,
)

HIGHEST_MV: Final = 10_000
"""The range of an analog output of a Smart-IO, in both directions (PAML-103)."""
HIGHEST_V: Final = 2.5
LARGEST_STEP: Final = 255
"""Voltage and largest code of an analog output of the PAM (PAML-106)."""

Volts = Callable[[int, float], None]
"""Takes the address of an analog output of the PAM, and its voltage."""


class BinaryOutput(Switched):
    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._site, self._node = site, node
        self._is_active_high = is_active_high = declared.word("ACTIVE") == "HIGH"
        self.item = node.add(lambda item: OutputItem(item, declared.integer("ADDRESS"), 1, is_active_high))

    def set_value(self, value: float) -> None:
        if bool(value) is not self.is_on:
            self.is_on = bool(value)
            self._node.send(SetOutput(self.item, int(self.is_on is self._is_active_high)))
            self._site.kernel.touched(self.name)


class DigitalOutput(ObjectItem):
    """A number on consecutive outputs; higher bits are dropped.  The bits are in the order of a digital input."""

    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._site, self._node = site, node
        self._number = 0
        bits = declared.integer("BITS")
        self._ordered = order_of_bits(bits, site)
        is_active_high = declared.word("ACTIVE") == "HIGH"
        self._mask = (1 << bits) - 1
        self._inverted = 0 if is_active_high else self._mask
        self._item = node.add(lambda item: OutputItem(item, declared.integer("ADDRESS"), bits, is_active_high))

    def value(self) -> int:
        return self._number

    def set_value(self, value: float) -> None:
        number = int(value) & self._mask
        if number != self._number:
            self._number = number
            self._node.send(SetOutput(self._item, self._ordered(number) ^ self._inverted))
            self._site.kernel.touched(self.name)


class AnalogOutput(ObjectItem):
    """RANGE is from -10 V to +10 V; values outside of it are limited (G-12)."""

    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._site, self._node = site, node
        self._lowest, self._highest = declared.pair("RANGE")
        self._number = 0.0
        self._sent_mv = 0
        self._item = node.add(lambda item: AnalogItem(item, declared.integer("ADDRESS")))

    def value(self) -> int:
        return int(self._number)

    def set_value(self, value: float) -> None:
        self._number = min(max(float(value), self._lowest), self._highest)
        share = (self._number - self._lowest) / (self._highest - self._lowest)
        millivolts = round((2 * share - 1) * HIGHEST_MV)
        if millivolts != self._sent_mv:
            self._sent_mv = millivolts
            self._node.send(SetOutput(self._item, millivolts))
        self._site.kernel.touched(self.name)


class LedOutput(Switched):
    """The node blinks by itself; the end of blinking leaves the state that was set (PAML-104)."""

    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._site, self._node = site, node
        self._item = node.add(lambda item: LedItem(item, declared.integer("ADDRESS")))

    def set_value(self, value: float) -> None:
        if bool(value) is not self.is_on:
            self.is_on = bool(value)
            self._node.send(SetOutput(self._item, int(self.is_on)))
            self._site.kernel.touched(self.name)

    def do_blink(self) -> None:
        self._node.send(Blink(self._item, True))

    def do_no_blink(self) -> None:
        self._node.send(Blink(self._item, False))


class SevenSegmentOutput(ObjectItem):
    def __init__(self, declared: Declared, _site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._node = node
        digits = declared.integer("DIGITS")
        self._item = node.add(lambda item: SevenSegmentItem(item, declared.integer("ADDRESS"), digits))

    def do_blink(self) -> None:
        self._node.send(Blink(self._item, True))

    def do_no_blink(self) -> None:
        self._node.send(Blink(self._item, False))

    def do_display(self, shown: str | float, digits: float = 1) -> None:
        """Show a text, or the lowest hexadecimal digits of a number; a Smart-IO has one digit (PAML-105)."""
        if not isinstance(shown, str):
            shown = f"{int(shown) & (16 ** max(int(digits), 1) - 1):X}"[-1]
        if shown:
            self._node.send(Display(self._item, ord(shown[0])))


class PamAnalogOutput(ObjectItem):
    """V = (value + OFFSET) / UNITS_PER_VOLT, from 0 V to 2.5 V in steps of 8 bits (G-12); also the end of a pipe."""

    def __init__(self, declared: Declared, site: Site, volts: Volts) -> None:
        super().__init__(declared.name)
        self._site, self._volts = site, volts
        self._units_per_volt, self._offset = declared.number("UNITS_PER_VOLT"), declared.number("OFFSET")
        self._address = declared.integer("ADDRESS")
        self._number = 0.0
        self._step = 0

    def value(self) -> int:
        return int(self._number)

    def set_value(self, value: float) -> None:
        self._site.changes += 1
        self.take(float(value))

    is_at_rest = True

    def attach(self, _mode: Mode, _period_s: float) -> Input:
        return self

    def detach(self) -> None:
        """The last voltage remains."""

    def take(self, value: float) -> None:
        before, self._number = self._number, value
        if int(before) != int(value):
            self._site.kernel.touched(self.name)
        volts = min(max((value + self._offset) / self._units_per_volt, 0.0), HIGHEST_V)
        step = round(volts / HIGHEST_V * LARGEST_STEP)
        if step != self._step:
            self._step = step
            self._volts(self._address, step * HIGHEST_V / LARGEST_STEP)
