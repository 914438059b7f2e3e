"""The topic `wires`: the present values of the wires of one device, for its card that was chosen in the picture."""

import asyncio
from collections.abc import Mapping
from typing import Any, ClassVar, Final

from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError
from fieldrig_page.graph import Graph, graph_of
from fieldrig_page.live import Page
from fieldrig_page.rig_link import RigLink

PERIOD_S: Final = 0.5

Values = dict[str, list[Any]]
"""Value and unit by BUS/WIRE."""


class Wires:
    name: ClassVar[str] = "wires"

    def __init__(self, link: RigLink) -> None:
        self._link = link
        self._graph = graph_of(link.config)
        self._wanted: dict[Page, str] = {}
        self._sent: dict[Page, Values | None] = {}
        self._signals: dict[str, Mapping[str, Any]] = {}
        self._is_wanted = asyncio.Event()

    def want(self, page: Page, wish: Any) -> None:
        """Show the wires of the device of this name."""
        if not isinstance(wish, str) or wish not in self._graph.devices:
            raise MalformedError("expected the name of a device")
        self._wanted[page], self._sent[page] = wish, None
        self._is_wanted.set()

    def forget(self, page: Page) -> None:
        self._wanted.pop(page, None)
        self._sent.pop(page, None)
        if not self._wanted:
            self._is_wanted.clear()
            self._signals.clear()

    def frame(self, page: Page) -> dict[str, Any] | None:
        if not self._signals:
            return None
        before = self._sent[page]
        now = self._values_of(self._wanted[page])
        self._sent[page] = now
        if before is None:
            return {"whole": True, "values": now}
        news = {name: value for name, value in now.items() if before.get(name) != value}
        return {"values": news} if news else None

    async def run(self) -> None:
        while True:
            await self._is_wanted.wait()
            for bus in {wire.bus for name in self._wanted.values() for wire in wires_of(self._graph, name)}:
                try:
                    self._signals[bus] = await self._link.recent(f"bus/{bus}/keys")
                except ControlError:
                    self._signals[bus] = {}  # its process does not answer, so nothing is known
            await asyncio.sleep(PERIOD_S)

    def _values_of(self, device: str) -> Values:
        values: Values = {}
        for wire in wires_of(self._graph, device):
            facts = self._signals.get(wire.bus, {}).get(wire.name)
            if facts is not None and facts.get("value") is not None:
                values[f"{wire.bus}/{wire.name}"] = [facts["value"], facts.get("unit", "")]
        return values


def wires_of(graph: Graph, device: str) -> list[Any]:
    """Return the wires that a device publishes or reads."""
    return [wire for wire in graph.wires if device == wire.publisher or device in wire.readers]
