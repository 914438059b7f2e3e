"""An operator terminal on a bench, and one on a CAN bus with the card's side of it."""

from collections.abc import Callable
from typing import Any, Self

from arp_card import RecordedCard
from canopen_bench import parse, show

from fieldrig.clock import MS, VirtualClock
from fieldrig.config.rig_file import from_dict
from fieldrig.device import Value
from fieldrig.points.access import read_point, write_point
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.card import Shown
from fieldrig_devices.arp.runtime.program import ArpProgram
from fieldrig_devices.arp.terminal.device import Terminal
from fieldrig_devices.arp.terminal.link import TerminalLink
from fieldrig_devices.arp.terminal.settings import TerminalSettings

NODE_ID = 20  # 14h
PRE_OPERATIONAL, START = "000#80 14", "000#01 14"
PASS_NS = 20 * MS  # the scheduler's default


class TerminalBench:
    """Node 20, booted and started, with frames as text.  Another bench on the same `store` is a power cycle."""

    def __init__(self, store: Store | None = None, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.can, self.printer = RecordedLink[CanFrame](), RecordedLink[bytes]()
        self.store = store or MemoryStore()
        made = TerminalSettings.model_validate({"node_id": NODE_ID, **settings})
        self.terminal = Terminal(self.clock, "tr", self.can, made, self.store, self.printer)
        self.terminal.start()
        self.boot = self.send(START)

    def send(self, *frames: str) -> list[str]:
        """Frames that were sent at this instant."""
        for frame in frames:
            self.can.deliver(parse(frame))
        return self.after(0)

    def after(self, ms: int) -> list[str]:
        self.clock.advance_to(self.clock.now_ns() + ms * MS)
        return [show(frame) for frame in self.can.take()]

    def store_message(self, number: int, text: str) -> None:
        self.set(f"message.{number}", text)

    def get(self, key: str) -> Value:
        return read_point("terminal", self.terminal.points(), key)

    def set(self, key: str, value: Value) -> None:
        write_point("terminal", self.terminal.points(), key, value)

    def press(self, keys: str) -> list[str]:
        """Press keys one after the other, and return the frames that were sent meanwhile."""
        self.set("press", keys)
        return self.after(150 * len(keys.split()))

    @property
    def screen(self) -> list[str]:
        """Lines of the screen without trailing blanks."""
        return [line.rstrip() for line in str(self.get("screen")).split("\n")]


class CardAtTerminal(RecordedCard):
    """A recorded card whose TERM, MSG and PRINT go to a terminal."""

    link: TerminalLink

    def store_message(self, number: int, text: str) -> None:
        self.link.store_message(number, text)

    def clear_screen(self) -> None:
        self.link.clear_screen()

    def erase_text(self, line: int, column: int) -> None:
        self.link.erase_text(line, column)

    def show_text(self, shown: Shown) -> None:
        self.link.show_text(shown)

    def print_text(self, message: int, variable: int | None) -> None:
        self.link.print_text(message, variable)


class CellBench:
    """Terminal `tr` and a card on one bus; the card's scheduler runs every 20 ms."""

    def __init__(
        self, readings: Readings | None = None, *, card_node_id: int | None = NODE_ID, **settings: Any
    ) -> None:
        self.rig = Rig(from_dict(_rig(settings)))
        self._node = self.rig.attach("card")
        self.frames: list[str] = []
        """All frames on the bus."""
        self._other = self.rig.attach("other").link("can0")
        self._other.on_receive(lambda frame: self.frames.append(show(frame)))
        self.card = CardAtTerminal()
        self.on_edit: Callable[[int, int], None] = self.card.V.__setitem__
        self.errors = CardErrors(lambda code: None)
        self.link = self.card.link = TerminalLink(
            self._node.clock,
            self._node.link("can0"),
            self.card.V,
            self.card.F,
            self.errors,
            lambda number, raw: self.on_edit(number, raw),
            readings,
        )
        self.link.start(card_node_id)
        self._refresh()

    def program(self, source: str, ms: int = 400) -> "CellBench":
        """Run the instructions of a program to their end, then let this time pass."""
        program = ArpProgram(compile_text(f"BEG MAIN\n{source}\nEND"), self.card)
        program.start()
        program.run(10_000)
        return self.after(ms)

    def after(self, ms: int) -> "CellBench":
        self.rig.run_until(self.rig.now_ns + ms * MS)
        return self

    def take(self) -> list[str]:
        """Frames since the last call, without heartbeats."""
        frames, self.frames = self.frames, []
        return [frame for frame in frames if not frame.startswith("714#")]

    def press(self, keys: str) -> None:
        self.rig.set("tr", "press", keys)
        self.after(150 * len(keys.split()) + 40)

    @property
    def screen(self) -> list[str]:
        return [line.rstrip() for line in str(self.rig.get("tr", "screen")).split("\n")]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.rig.close()

    def send(self, frame: str) -> None:
        """Send a frame from another node."""
        self._other.send(parse(frame))
        self.after(1)

    def _refresh(self) -> None:
        self.link.refresh()
        clock = self._node.clock
        clock.call_at(clock.now_ns() + PASS_NS, self._refresh)


def _rig(settings: dict[str, Any]) -> dict[str, Any]:
    return {
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": 500_000}},
        "devices": {"tr": {"kind": "terminal.tr", "node_id": NODE_ID, "links": {"can": "can0"}, **settings}},
    }
