"""The messages of buses for the page, by name, as they are published while a page looks (`hub/bus_stream.py`).

A bus that no page looks at publishes nothing and costs nothing.  What a page does not get is counted and said: messages
that were lost on the way here, and those that were too many to show.
"""

import asyncio
import io
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, ClassVar, Final

from starlette.responses import Response

from fieldrig.errors import ControlError, UsageError
from fieldrig.outside.untrusted import MalformedError, field, items, typed
from fieldrig.traces.formats import format_of, formats
from fieldrig.traces.names import Learning, namer_of
from fieldrig.traces.trace import is_batch
from fieldrig_page.api import Call, Operation, known
from fieldrig_page.bus_load import Reading, load_words
from fieldrig_page.bus_record import MOST_MESSAGES, BusRecord, Row
from fieldrig_page.guard import DeniedError
from fieldrig_page.live import Page
from fieldrig_page.rig_link import End, RigLink

FIRST_ROWS: Final = 500
"""Messages that a page gets when it begins to look."""
MOST_ROWS: Final = 200
"""Messages of a bus in a further frame."""
MOST_LOOKED_AT: Final = 2_000
"""Messages that are compared with the filter of a page for one frame."""
MOST_FOLDED: Final = 5_000
"""The same for a page that folds repeats, which also begins that number of messages back: few rows stand for them."""
MOST_BUSES: Final = 64
LOADS_S: Final = 1.0
KEPT_S: Final = 30.0
"""The messages of a bus are kept for so long after the last page has looked away."""


class _Filter:
    """The messages that one page wants to see, by texts that all have to be in them."""

    def __init__(self, wish: dict[str, Any]) -> None:
        self._words = typed(wish.get("text", ""), str, "text").lower().split()
        self._node = typed(wish.get("node", ""), str, "node").lower()
        self._kind = typed(wish.get("kind", ""), str, "kind").lower()

    def takes(self, row: Row) -> bool:
        named, sender = row.named, row.message.sender
        if self._kind and self._kind not in named.kind.lower():
            return False
        if self._node and not named.concerns(self._node) and self._node not in sender.lower():
            return False
        if not self._words:
            return True
        text = row.searched
        return all(word in text for word in self._words)


class _View:
    """The buses that one page looks at, and how far it is on each of them."""

    def __init__(self, wish: dict[str, Any], buses: dict[str, BusRecord]) -> None:
        self.filter = _Filter(wish)
        self.folds = typed(wish.get("folds", False), bool, "folds")
        """True if messages that say the same as the last one of their sort are one row."""
        back = MOST_FOLDED if self.folds else FIRST_ROWS
        self.at = {name: max(record.first, record.next - back) for name, record in buses.items()}
        self.lost = {name: record.lost for name, record in buses.items()}
        self.left_out = dict.fromkeys(buses, 0)
        self.is_whole = True
        self.loads: dict[str, str] = {}


class Traffic:
    """The topic `traffic`, and the operations on what was recorded."""

    name: ClassVar[str] = "traffic"

    def __init__(self, link: RigLink) -> None:
        self._link = link
        self._views: dict[Page, _View] = {}
        self._records: dict[str, BusRecord] = {}
        self._listening: dict[str, End] = {}
        self._unwanted_s: dict[str, float] = {}
        """When the last page looked away from a bus, by the clock of the loop."""
        self._lessons: set[asyncio.Task[None]] = set()
        self._loads: dict[str, str] = {}
        """How busy each bus is, in words."""
        self._readings: dict[str, Reading] = {}

    # ---- the topic

    def want(self, page: Page, wish: Any) -> None:
        """Show the messages of buses: `{"buses": ["can0"], "text": "statusword", "node": "belt", "kind": "SDO"}`.

        With `"folds": true`, messages that say the same as the last one of their sort are counted in its row.
        """
        names = items(field(wish, "buses", list), str, MOST_BUSES, "buses")
        for name in names:
            if name not in self._link.config.buses:
                raise MalformedError(f"there is no bus {name!r:.60}")
            self._listen(name)
        self._views[page] = _View(wish, {name: self._records[name] for name in names})

    def forget(self, page: Page) -> None:
        self._views.pop(page, None)

    def frame(self, page: Page) -> dict[str, Any] | None:
        """Return the messages that the page does not have: `rows`, and for each bus what was left out or lost."""
        view = self._views[page]
        rows = [row for name in view.at for row in self._next(view, name)]
        rows.sort(key=lambda row: row[1])
        frame: dict[str, Any] = {"rows": rows} if rows else {}
        gaps = {name: gap for name in view.at if (gap := self._gap(view, name))}
        if gaps:
            frame["gaps"] = gaps
        if view.loads != self._loads:
            view.loads = self._loads
            frame["loads"] = {name: self._loads[name] for name in view.at if name in self._loads}
        if view.is_whole:
            view.is_whole = False
            frame["whole"] = True
        return frame or None

    def _next(self, view: _View, name: str) -> list[list[Any]]:
        record, at = self._records[name], view.at[name]
        looked_at = MOST_FOLDED if view.folds else MOST_LOOKED_AT
        if record.next - at > looked_at:
            newest = record.next - looked_at
            view.left_out[name] += newest - at
            at = newest
        taken = (row for row in record.rows(at, looked_at) if view.filter.takes(row))
        found = _folded(name, taken) if view.folds else [_shown(name, row) for row in taken]
        view.at[name] = record.next
        most = FIRST_ROWS if view.is_whole else MOST_ROWS
        view.left_out[name] += sum(row[COUNT] for row in found[:-most])
        return found[-most:]

    def _gap(self, view: _View, name: str) -> dict[str, int]:
        lost, left_out = self._records[name].lost - view.lost[name], view.left_out[name]
        view.lost[name], view.left_out[name] = self._records[name].lost, 0
        return {key: count for key, count in (("lost", lost), ("left_out", left_out)) if count}

    async def run(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            await self._ask_loads()
            wanted = {name for view in self._views.values() for name in view.at}
            for name in tuple(self._listening):
                if name in wanted:
                    self._unwanted_s.pop(name, None)
                elif loop.time() - self._unwanted_s.setdefault(name, loop.time()) > KEPT_S:
                    self._listening.pop(name)()
                    del self._records[name], self._unwanted_s[name]
            await asyncio.sleep(LOADS_S)

    async def _ask_loads(self) -> None:
        """Ask how busy the buses are that pages look at."""
        wanted = {name for view in self._views.values() for name in view.at}
        if not wanted:
            return
        try:
            status = await self._link.recent("rig/status")
            figures = await self._link.recent("bus/*/status")
        except ControlError:  # the rig is being stopped or restarted
            return
        now_ns = status.get("now_ns", time.monotonic_ns())
        readings = {name: Reading(now_ns, figures[name]) for name in wanted if name in figures}
        self._loads = {name: load_words(self._readings.get(name), now) for name, now in readings.items()}
        self._readings = readings

    def _listen(self, name: str) -> None:
        if name in self._listening:
            return
        config = self._link.config
        namer = namer_of(config, name)
        record = BusRecord(config.buses[name].bus, namer)
        learner: object = namer
        if isinstance(learner, Learning):
            task = asyncio.get_running_loop().create_task(self._teach(learner))
            self._lessons.add(task)
            task.add_done_callback(self._lessons.discard)

        def on_batch(_name: str, batch: Any) -> None:
            if is_batch(batch):
                record.take(batch)

        self._records[name] = record
        self._listening[name] = self._link.listen_to(f"trace/{name}", on_batch)

    async def _teach(self, namer: Learning) -> None:
        """Tell a namer what was configured before a page looked, as far as the devices answer."""
        for device, keys in namer.wants().items():
            try:
                namer.learn(device, await self._link.ask(f"device/{device}/get", {"keys": list(keys)}))
            except ControlError:  # it is off, or its points have other keys, as those of a node within another device
                continue

    # ---- the HTTP API

    def operations(self) -> Iterator[Operation]:
        """Yield the operations on recorded messages."""
        buses = {"name": "name of a bus"}
        about = "Return the messages of a bus that were recorded while a page looked at it, oldest first."
        yield Operation(
            "GET", "buses/{name}/messages", about, self._messages, gives=list[dict[str, Any]], parameters=buses,
            queries={"text": "words that all are in a message", "node": "a node", "kind": "a service"},
        )  # fmt: skip
        about = (
            "Return the formats of downloads, each with the families of buses that it can hold; none stands for all."
        )
        yield Operation("GET", "traces/formats", about, self._formats, gives=list[dict[str, Any]])
        files = {"name": "name of a bus", "ending": "ending of a format, such as pcapng"}
        yield Operation(
            "GET", "traces/{name}.{ending}", "Download these messages as a trace file.", self._download,
            gives="application/octet-stream", parameters=files,
        )  # fmt: skip

    async def _messages(self, call: Call) -> list[dict[str, Any]]:
        record = self._record(call.path["name"])
        wanted = _Filter(dict(call.query))
        rows = (row for row in record.rows(record.first, MOST_MESSAGES) if wanted.takes(row))
        return [
            {
                "number": row.message.number,
                "time_ns": row.message.time_ns,
                "sender": row.message.sender,
                "node": row.named.node,
                "kind": row.named.kind,
                "text": row.named.text,
                "raw": row.raw,
                "since_ns": row.since_ns,
            }
            for row in rows
        ]

    async def _formats(self, _call: Call) -> list[dict[str, Any]]:
        return [{"ending": form.SUFFIXES[0].removeprefix("."), "families": sorted(form.FAMILIES)} for form in formats()]

    async def _download(self, call: Call) -> Response:
        name = call.path["name"]
        record = self._record(name)
        try:
            form = format_of(Path(f"{name}.{call.path['ending']}"))
        except UsageError as wrong:
            raise DeniedError(404, wrong.what, wrong.remedy) from wrong
        file = io.BytesIO()
        try:
            written = form.write(record.entries(), file, 0)
        except UsageError as wrong:  # such as a library that is not installed
            raise DeniedError(409, wrong.what, wrong.remedy) from wrong
        if not written:
            raise DeniedError(409, f"{name}: there is no message that this format can hold", "choose jsonl, or wait")
        headers = {"Content-Disposition": f'attachment; filename="{name}.{call.path["ending"]}"'}
        return Response(file.getvalue(), media_type="application/octet-stream", headers=headers)

    def _record(self, name: str) -> BusRecord:
        known(name, self._link.config.buses, "bus")
        if name not in self._records:
            raise DeniedError(409, f"nothing of {name} is recorded", "open its traffic on the page first")
        return self._records[name]


COUNT: Final = 9
"""The place of the count in a row for the page."""


def _shown(bus: str, row: Row) -> list[Any]:
    """Return a row for the page: number, time, bus, sender, node, kind, text, usual text, time since the last one,
    messages that it stands for, and the time of the last of them.
    """
    message, named = row.message, row.named
    return [
        message.number, message.time_ns, bus, message.sender, named.node, named.kind, named.text, row.raw, row.since_ns,
        1, message.time_ns,
    ]  # fmt: skip


def _folded(bus: str, rows: Iterable[Row]) -> list[list[Any]]:
    """Return rows of which each stands for all messages that say the same in a row; its number is that of the first.

    The page counts on in a row that it has, so a row is the same one in all frames.
    """
    folded: dict[int, list[Any]] = {}
    for row in rows:
        shown = folded.get(row.first)
        if shown is None:
            folded[row.first] = [row.first, *_shown(bus, row)[1:]]
        else:
            shown[COUNT - 1 :] = [row.since_ns, shown[COUNT] + 1, row.message.time_ns]
    return list(folded.values())
