"""Two values of each device for its card, read while a page looks, with the last ones for a spark line.

The devices are asked one after the other, evenly over a round.  A question to all at once, or twice a second, took
drives of a ring a tenth of their cycles.
"""

import asyncio
from collections import deque
from collections.abc import Mapping
from typing import Any, Final

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig_page.changes import Changes
from fieldrig_page.chosen_points import chosen, label_of
from fieldrig_page.graph import wired_keys
from fieldrig_page.rig_link import RigLink

KEPT: Final = 60
"""Samples that a spark line shows."""
ROUND_S: Final = 1.0
"""Time of a round, for a rig with few devices."""
SHORTEST_S: Final = 0.05
"""Least time between the questions to two devices; it makes the round of a large rig longer."""
SEARCH_ROUNDS: Final = 10
"""Rounds after which the points of a device are asked for again: a controller has more once it has started."""
AWAY_ROUNDS: Final = 4
"""Rounds without a look after which the spark lines begin again."""
ANSWER_S: Final = 1.0

Row = dict[str, list[Value]]


class CardValues:
    def __init__(self, link: RigLink) -> None:
        self.shown: Changes[list[dict[str, str]]] = Changes()
        """The key, the label and the unit of each value on a card, by device."""
        self.sample = 0
        """The number of the last sample."""
        self._link = link
        self._named = {name: set(wired_keys(entry.settings)) for name, entry in link.config.devices.items()}
        self._keys: dict[str, list[str]] = {}
        self._trouble_keys: dict[str, list[str]] = {}
        self._troubles: dict[str, Mapping[str, Value]] = {}
        self._rows: deque[tuple[int, Row]] = deque(maxlen=KEPT)

    def troubles(self, name: str) -> Mapping[str, Value]:
        """Return what a device reports as wrong, by key."""
        return self._troubles.get(name, {})

    def samples_since(self, number: int) -> list[Row]:
        """Return the samples after a number; of a device without a change only the first one has values."""
        rows: list[Row] = []
        before: Row = {}
        for at, row in self._rows:
            if at > number:
                rows.append({name: values for name, values in row.items() if not rows or before.get(name) != values})
            before = row
        return rows

    async def run(self, is_wanted: asyncio.Event) -> None:
        """Ask the devices, round after round, while a page looks."""
        names = list(self._link.config.devices)
        pause_s = max(ROUND_S / max(len(names), 1), SHORTEST_S)
        rounds = 0
        loop, looked_s = asyncio.get_running_loop(), 0.0
        while True:
            await is_wanted.wait()
            if loop.time() - looked_s > AWAY_ROUNDS * pause_s * max(len(names), 1):
                self._rows.clear()  # a line over the time without a page would show a jump that never was
            row: Row = {}
            for name in names:
                await self._look(name, row, rounds % SEARCH_ROUNDS == 0)
                await asyncio.sleep(0 if rounds == 0 else pause_s)  # the first values come at once
            if not names:
                await asyncio.sleep(ROUND_S)
            rounds += 1
            looked_s = loop.time()
            self.sample += 1
            self._rows.append((self.sample, row))

    async def _look(self, name: str, row: Row, is_search: bool) -> None:
        """Read one device; one that does not answer keeps its points, and has no values."""
        try:
            if is_search or not self._keys.get(name):
                await self._search(name)
            answer = await self._read(name)
        except ControlError:
            return
        self._troubles[name] = {key: answer[key] for key in self._trouble_keys[name] if answer.get(key)}
        if answer:
            row[name] = [answer[key] for key in self._keys[name]]

    async def _search(self, name: str) -> None:
        facts: Mapping[str, Mapping[str, Any]] = await self._link.ask(f"device/{name}/keys", None, ANSWER_S)
        keys = self._keys[name] = chosen(facts, self._named[name])
        self._trouble_keys[name] = [key for key in self._link.config.devices[name].cls.trouble_keys if key in facts]
        self.shown.put(name, [_about(key, facts[key]) for key in keys])

    async def _read(self, name: str) -> Mapping[str, Value]:
        keys = list(dict.fromkeys([*self._keys[name], *self._trouble_keys[name]]))
        answer: Mapping[str, Value] = (
            await self._link.ask(f"device/{name}/get", {"keys": keys}, ANSWER_S) if keys else {}
        )
        return answer


def _about(key: str, facts: Mapping[str, Any]) -> dict[str, str]:
    return {"key": key, "label": label_of(key, str(facts.get("about", ""))), "unit": str(facts.get("unit", ""))}
