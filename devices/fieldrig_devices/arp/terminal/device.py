"""The operator terminal TR4 or TR5: a screen, keys, LEDs and a serial printer, with a CANopen node.

Source: manual 4.5 and 5.12; digest chapters 8.1 and 16. docs/devices/arp/arp-terminal.md describes what the manual
leaves open: the objects on the bus, and how a value is edited.  Left out: characters beyond ISO 8859-1, contrast,
buzzer, and the terminal's own set-up pages.
"""

from collections.abc import Collection, Mapping
from functools import partial
from typing import Any, ClassVar, Final

from fieldrig.bus import Bus
from fieldrig.clock import Clock
from fieldrig.device import Device, Point, Tool, Value
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.points.checks import truth_in
from fieldrig.storage.store import Store, StoreError
from fieldrig.text.nearest import closest
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.terminal import panel
from fieldrig_devices.arp.terminal.application import Application
from fieldrig_devices.arp.terminal.faults import MODELS, StuckKey
from fieldrig_devices.arp.terminal.front import front_of
from fieldrig_devices.arp.terminal.messages import COUNT
from fieldrig_devices.arp.terminal.presses import Presses
from fieldrig_devices.arp.terminal.screen import LINES
from fieldrig_devices.arp.terminal.settings import TerminalSettings
from fieldrig_devices.canopen.node import CanopenNode

_NODE_POINTS: Final = ("nmt.state", "node_id", "emcy.code", "error_register", "time")


class Terminal(Device):
    about = "the operator terminal of an ARP card: screen, keys, LEDs, printer"
    trouble_keys: ClassVar[Collection[str]] = ("emcy.code",)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        can: Link[CanFrame],
        settings: TerminalSettings,
        store: Store,
        printer: Link[bytes] | None = None,
    ) -> None:
        self._time, self._model = settings.time, settings.model
        self._node = CanopenNode(clock, name, can, settings.canopen, store)
        self._application = Application(self._node, settings, store, printer)
        self._keys = panel.keys(settings.model)
        self._presses = Presses(clock, frozenset(self._keys), self._on_key)
        self._shown: set[str] = set()
        """The keys that are down for the node."""
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults, check=self._check
        )
        self._node.take_faults(self.injected)
        self._points = {
            **self._screen_points(),
            **self._panel_points(panel.leds(settings.model)),
            **{f"message.{number}": self._message_point(number) for number in range(1, COUNT + 1)},
            **{key: self._node.points()[key] for key in _NODE_POINTS},
        }

    def start(self) -> None:
        set_time = self._points["time"].write
        assert set_time is not None
        set_time(self._time)
        self._node.start()

    def front(self) -> Front:
        return front_of(self._model)

    def points(self) -> Mapping[str, Point]:
        return self._points

    @classmethod
    def tools(cls, name: str, settings: TerminalSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
        return CanopenNode.tools(name, settings.canopen, links)

    def _screen_points(self) -> dict[str, Point]:
        application = self._application
        return {
            "screen": Point(lambda: "\n".join(application.screen.lines()), about="all eight lines of the screen"),
            **{
                f"screen.{line}": Point(partial(self._line, line), about=f"line {line}") for line in range(1, LINES + 1)
            },
            "texts": Point(
                lambda: "\n".join(application.screen.described()), about="line, column, height and text of each message"
            ),
            "cursor": Point(self._cursor, about="line and column of the cursor; empty if no value can be edited"),
            "printer": Point(lambda: "\n".join(application.printer.lines), about="the last printed lines"),
        }

    def _panel_points(self, leds: Mapping[str, int]) -> dict[str, Point]:
        return {
            "press": Point(
                lambda: self._presses.last, self._press, about="keys to press by name, one after the other: 1 2 CR"
            ),
            **{f"key.{name}": self._key_point(name) for name in self._keys},
            **{f"led.{name}": Point(partial(self._application.is_lit, bit)) for name, bit in leds.items()},
        }

    def _key_point(self, name: str) -> Point:
        return Point(lambda: name in self._presses.down, partial(self._set_key, name))

    def _message_point(self, number: int) -> Point:
        messages = self._application.messages

        def write(value: Value) -> None:
            try:
                messages[number] = str(value)
            except StoreError as cause:
                raise ValueError(f"message {number} cannot be stored: {cause.strerror}") from cause

        return Point(lambda: messages[number], write)

    def _line(self, number: int) -> str:
        return self._application.screen.lines()[number - 1]

    def _cursor(self) -> str:
        cursor = self._application.editor.cursor
        return "" if cursor is None else f"{cursor.line} {cursor.column}"

    def _press(self, value: Value) -> None:
        self._presses.press(str(value))

    def _set_key(self, name: str, value: Value) -> None:
        self._presses.set(name, truth_in(value))

    def _on_key(self, name: str, is_down: bool) -> None:
        if all(fault.key.upper() != name for fault in self._faults.active(StuckKey)):
            self._show_key(name, is_down)

    def _on_faults(self) -> None:
        stuck = {fault.key.upper(): fault.pressed for fault in self._faults.active(StuckKey)}
        for name in self._keys:
            self._show_key(name, stuck.get(name, name in self._presses.down))

    def _show_key(self, name: str, is_down: bool) -> None:
        if is_down == (name in self._shown):
            return
        (self._shown.add if is_down else self._shown.remove)(name)
        self._application.set_key(self._keys[name], is_down)
        if is_down:
            self._application.editor.press(name)

    def _check(self, fault: Any) -> None:
        """ValueError for a fault of a key that this model does not have."""
        if isinstance(fault, StuckKey) and fault.key.upper() not in self._keys:
            raise ValueError(f"key: there is no key {fault.key!r}\n{closest(fault.key.upper(), list(self._keys))}")
