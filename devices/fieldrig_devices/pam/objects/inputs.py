"""Inputs: the logical half of what the nodes scan (section 2.4 of the language's digest)."""

from collections.abc import Callable
from functools import partial

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.object_item import ObjectItem, Switched
from fieldrig_devices.pam.objects.site import ApplicationNode, Site, number_after
from fieldrig_devices.pamring.frames import CounterItem, InputChanged, InputItem, KeyItem, KeyMode, SetOutput

Watcher = Callable[[bool, int], None]
"""Takes a new value of an input, and the age of the change in microseconds."""


class BinaryInput(ObjectItem):
    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self.node, self._site = node, site
        self._is_active_high = declared.word("ACTIVE") == "HIGH"
        self._is_true = False
        self.watchers: list[Watcher] = []
        """They are called after each change, at the beginning of a basic cycle."""
        self.item = node.add(lambda item: input_item(declared, item, 1), self._on_change)

    def value(self) -> bool:
        return self._is_true

    def _on_change(self, report: InputChanged) -> None:
        is_true = bool(report.value) is self._is_active_high
        if is_true is self._is_true:
            return
        self._is_true = is_true
        self._site.kernel.touched(self.name)
        for watcher in self.watchers:
            self._site.events.append(partial(watcher, is_true, report.age_us))


class DigitalInput(ObjectItem):
    """Consecutive inputs as a number; the lowest address is the lowest bit, or by a setting the highest (G-07)."""

    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._site = site
        self._number = 0
        bits = declared.integer("BITS")
        self._ordered = order_of_bits(bits, site)
        self._mask = (1 << bits) - 1
        self._inverted = 0 if declared.word("ACTIVE") == "HIGH" else self._mask
        node.add(lambda item: input_item(declared, item, bits), self._on_change)

    def value(self) -> int:
        return self._number

    def _on_change(self, report: InputChanged) -> None:
        self._number = self._ordered((report.value & self._mask) ^ self._inverted)
        self._site.kernel.touched(self.name)


class CounterInput(ObjectItem):
    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._site = site
        self._count = 0
        self.item = node.add(
            lambda item: CounterItem(
                item,
                declared.integer("ADDRESS"),
                declared.word("ACTIVE") == "HIGH",
                declared.integer("PERIOD"),
                declared.integer("DEBOUNCE"),
            ),
            self._on_change,
        )

    def value(self) -> int:
        return self._count

    def _on_change(self, report: InputChanged) -> None:
        self._count = report.value
        self._site.kernel.touched(self.name)


class KeyInput(Switched):
    """A key; the node applies its mode.  A program may write its state until the key changes it (PAML-092)."""

    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._site, self._node = site, node
        self._written = self._written_in = 0
        """The number and the basic cycle of the last order."""
        self._item = node.add(
            lambda item: KeyItem(
                item,
                declared.integer("ADDRESS"),
                declared.word("ON") == "BINARY_INPUT",
                KeyMode[declared.word("MODE")],
                declared.integer("PERIOD"),
                declared.integer("DELAY"),
                declared.integer("REPEAT"),
                declared.word("ACTIVE") == "HIGH",
                declared.integer("DEBOUNCE", 1),
            ),
            self._on_change,
        )

    def set_value(self, value: float) -> None:
        self.is_on = bool(value)
        self._written, self._written_in = number_after(self._written), self._site.cycle
        self._node.send(SetOutput(self._item, int(self.is_on), self._written))
        self._site.kernel.touched(self.name)

    def _on_change(self, report: InputChanged) -> None:
        """Take a change, unless it is from before the last order; an order that is lost counts for a while only."""
        waits = self._site.cycle - self._written_in < self._site.readings.read_timeout_cycles
        if waits and report.number != self._written:
            return
        self.is_on = bool(report.value)
        self._site.kernel.touched(self.name)


def order_of_bits(bits: int, site: Site) -> Callable[[int], int]:
    """Return what makes a number of the program from the bits of a frame, or the other way round."""
    if not site.readings.lowest_address_is_highest_bit:
        return int
    return lambda number: int(f"{number:0{bits}b}"[::-1], 2)


def input_item(declared: Declared, item: int, bits: int) -> InputItem:
    return InputItem(
        item,
        declared.integer("ADDRESS"),
        bits,
        declared.word("ACTIVE") == "HIGH",
        declared.integer("PERIOD"),
        declared.integer("DEBOUNCE"),
    )
