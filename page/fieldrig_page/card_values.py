"""Two values of each device for its card, read while a page looks, with those of the last minute for a spark line."""

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
LOOKS_PER_SAMPLE: Final = 2
LOOKS_PER_SEARCH: Final = 20
"""Looks after which the points are asked for again: a controller has more of them once it has started."""
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
        self._troubles: dict[str, Mapping[str, Value]] = {}
        self._trouble_keys: dict[str, list[str]] = {}
        self._rows: deque[tuple[int, Row]] = deque(maxlen=KEPT)
        self._looks = 0

    async def look(self) -> None:
        """Look at the devices, as often as a spark line needs it."""
        if self._looks % LOOKS_PER_SEARCH == 0:
            await asyncio.gather(*(self._search(name) for name in self._link.config.devices))
        if self._looks % LOOKS_PER_SAMPLE == 0:
            await self._take_sample()
        self._looks += 1

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

    async def _search(self, name: str) -> None:
        """Choose the points of a device again; one that does not answer keeps those that it has."""
        try:
            facts: Mapping[str, Mapping[str, Any]] = await self._link.ask(f"device/{name}/keys", None, ANSWER_S)
        except ControlError:
            return
        keys = self._keys[name] = chosen(facts, self._named[name])
        self._trouble_keys[name] = [key for key in self._link.config.devices[name].cls.trouble_keys if key in facts]
        self.shown.put(name, [_about(key, facts[key]) for key in keys])

    async def _take_sample(self) -> None:
        names = [name for name, keys in self._keys.items() if keys or self._trouble_keys[name]]
        answers = await asyncio.gather(*(self._read(name) for name in names))
        row: Row = {}
        for name, answer in zip(names, answers, strict=True):
            self._troubles[name] = {key: answer[key] for key in self._trouble_keys[name] if answer.get(key)}
            if answer and all(key in answer for key in self._keys[name]):
                row[name] = [answer[key] for key in self._keys[name]]
        self.sample += 1
        self._rows.append((self.sample, row))

    async def _read(self, name: str) -> Mapping[str, Value]:
        keys = list(dict.fromkeys([*self._keys[name], *self._trouble_keys[name]]))
        try:
            answer: Mapping[str, Value] = await self._link.ask(f"device/{name}/get", {"keys": keys}, ANSWER_S)
        except ControlError:
            return {}
        return answer


def _about(key: str, facts: Mapping[str, Any]) -> dict[str, str]:
    return {"key": key, "label": label_of(key, str(facts.get("about", ""))), "unit": str(facts.get("unit", ""))}
