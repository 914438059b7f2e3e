"""Two values of each device for its card, read while a page looks, with the last ones for a spark line.

The devices are asked one after the other, evenly over a round.  A question to all at once, or twice a second, took
drives of a ring a tenth of their cycles.  A question delays at most one cycle of its process; a process is asked so
seldom that fewer than 1 % of the cycles of a ring of 1 ms can be late for it.
"""

import asyncio
from collections import Counter, deque
from collections.abc import Mapping
from itertools import zip_longest
from typing import Any, Final

from fieldrig.control.messages import NoAnswerError
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
OF_PROCESS_S: Final = 0.15
"""Least time between two questions to one process in real time, which makes the round of a rig with few longer."""
SEARCH_S: Final = (10.0, 60.0)
"""Time after which the points of a device are asked for once more, and again and again: a controller has more once it
has started, and another program has others.  It is an answer of a millisecond."""
AWAY_ROUNDS: Final = 4
"""Rounds without a look after which the spark lines begin again."""
ANSWER_S: Final = 1.0
SILENT_ROUNDS: Final = 3
"""Questions in a row without an answer after which a device is silent: a busy host may be late for one."""

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
        self._unheard: Counter[str] = Counter()
        """Questions to each device without an answer since the last one."""
        self._asked_s: dict[str, float] = {}
        """When each process was asked last."""
        self._search_s: dict[str, float] = {}
        """When the points of each device are asked for again."""

    def troubles(self, name: str) -> Mapping[str, Value]:
        """Return what a device reports as wrong, by key."""
        return self._troubles.get(name, {})

    def is_silent(self, name: str) -> bool:
        """True if a device has not answered for some questions."""
        return self._unheard[name] >= SILENT_ROUNDS

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
        names = self._in_turn()
        pause_s = max(ROUND_S / max(len(names), 1), SHORTEST_S)
        rounds = 0
        loop, looked_s = asyncio.get_running_loop(), 0.0
        while True:
            await is_wanted.wait()
            if loop.time() - looked_s > AWAY_ROUNDS * pause_s * max(len(names), 1):
                self._rows.clear()  # a line over the time without a page would show a jump that never was
            row: Row = {}
            for name in names:
                await self._give_way(name, is_first=rounds == 0)
                await self._look(name, row)
                await asyncio.sleep(0 if rounds == 0 else pause_s)  # the first values come at once
            if not names:
                await asyncio.sleep(ROUND_S)
            rounds += 1
            looked_s = loop.time()
            self.sample += 1
            self._rows.append((self.sample, row))

    def _in_turn(self) -> list[str]:
        """Return the devices so that those of one process are as far from each other as they can be."""
        of_process: dict[str, list[str]] = {}
        for name, entry in self._link.config.devices.items():
            of_process.setdefault(entry.process, []).append(name)
        return [name for turn in zip_longest(*of_process.values()) for name in turn if name is not None]

    async def _give_way(self, name: str, *, is_first: bool) -> None:
        """Wait until the process of a device may be asked again."""
        loop, config = asyncio.get_running_loop(), self._link.config
        process = config.devices[name].process
        if config.time == "real" and not is_first:
            await asyncio.sleep(max(self._asked_s.get(process, 0.0) + OF_PROCESS_S - loop.time(), 0.0))
        self._asked_s[process] = loop.time()

    async def _look(self, name: str, row: Row) -> None:
        """Read one device; one that does not answer keeps its points, and has no values."""
        now_s = asyncio.get_running_loop().time()
        try:
            if now_s >= self._search_s.get(name, 0.0) or not self._keys.get(name):
                await self._search(name)
                self._search_s[name] = now_s + SEARCH_S[name in self._search_s]
            answer = await self._read(name)
        except NoAnswerError:
            self._unheard[name] += 1
            self._search_s[name] = now_s
            return
        except ControlError:  # it is not there, or a point is not: look for its points when it answers again
            self._search_s[name] = now_s
            return
        self._unheard[name] = 0
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
