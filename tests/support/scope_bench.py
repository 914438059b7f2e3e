"""A scope on readers that a test feeds by hand, and its frames as a page would keep them."""

import asyncio
from collections.abc import Callable, Sequence
from math import inf, nan
from struct import unpack
from types import SimpleNamespace
from typing import Any

from scope_rows import rows

from fieldrig.errors import ControlError
from fieldrig.recording.reader import Rows
from fieldrig_page.scope.captures import Captures
from fieldrig_page.scope.recordings import Recordings
from fieldrig_page.scope.session import Session, read_wish
from fieldrig_page.scope.store import Track


class FakeReader:
    """A reader of `io/...` and `wires/...`; any other name does not exist."""

    def __init__(
        self, signals: Sequence[str], rhythm: Any, take: Callable[[Rows], None], reach: Callable[[int], None]
    ) -> None:
        self.signals, self.rhythm, self.take, self.reach = list(signals), rhythm, take, reach
        self.is_ended = False

    async def begin(self) -> list[Any]:
        for name in self.signals:
            if not name.startswith(("io/", "wires/")):
                raise ControlError(f"the rig has no {name}", "did you mean io/a?")
        return [self._column(name) for name in self.signals]

    async def end(self) -> None:
        self.is_ended = True

    @staticmethod
    def _column(name: str) -> Any:
        is_open = name.endswith("message")
        states = ["off", "ready", "on"] if name.endswith("state") else ["ready"] if is_open else []
        kind = "text" if states else "truth" if name.endswith("lamp") else "number"
        is_held = name.startswith("wires/")
        return SimpleNamespace(name=name, kind=kind, unit="V", states=states, is_held=is_held, is_open=is_open)


class ScopeBench:
    """Several pages on one set of recordings."""

    def __init__(self) -> None:
        self.readers: list[FakeReader] = []
        self.now_s = 0.0
        self.captures = Captures()
        self.recordings = Recordings(self._reader)
        self.sessions: list[Session] = []
        self.recordings.on_rows.append(self._on_rows)
        self.recordings.on_progress.append(self._on_progress)

    def _on_rows(self, track: Track, first: int) -> None:
        for session in self.sessions:
            session.on_rows(track, first)

    def _on_progress(self) -> None:
        for session in self.sessions:
            session.tick()

    def _reader(self, signals: Sequence[str], rhythm: Any, take: Any, reach: Any) -> FakeReader:
        reader = FakeReader(signals, rhythm, take, reach)
        self.readers.append(reader)
        return reader

    async def page(self, **setup: Any) -> "FakePage":
        session = Session(self.recordings, self.captures, 0, lambda: self.now_s, object())
        self.sessions.append(session)
        page = FakePage(session)
        await page.want(setup)
        return page

    def feed(
        self,
        times_ns: Sequence[int],
        *values: Sequence[float],
        lost: int = 0,
        reader: int = 0,
        columns: tuple[int, ...] | None = None,
    ) -> None:
        """Give rows of all signals of a reader, or of some, whose process then says that it knows nothing of others."""
        given = rows(times_ns, *values, lost=lost)
        self.readers[reader].take(given if columns is None else given._replace(columns=columns))
        if times_ns and columns is None:
            self.readers[reader].reach(times_ns[-1])


class FakePage:
    """The frames as a browser keeps them: buckets by row and number, and the newest status."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.wish: dict[str, Any] = {}
        self.low: list[dict[int, float]] = []
        self.high: list[dict[int, float]] = []
        self.status: dict[str, Any] = {}
        self.columns: list[dict[str, Any]] = []
        self.gaps: list[dict[str, Any]] = []
        self.frame: dict[str, Any] = {}

    async def want(self, setup: dict[str, Any] | None = None, **wish: Any) -> None:
        self.wish = {"pixels": 100, **self.wish, **wish}
        if setup is not None:
            self.wish["setup"] = setup
        self.session.want(read_wish(self.wish))
        for _ in range(10):  # readers begin in tasks of their own
            await asyncio.sleep(0)

    def look(self) -> bool:
        """Take a frame; False if there is nothing new."""
        frame = self.session.frame()
        if frame is None:
            return False
        self.status = frame["status"]
        self.frame = frame
        if frame.get("whole"):
            self.columns = frame["columns"]
            self.low = [{} for _ in self.columns]
            self.high = [{} for _ in self.columns]
        self.gaps = frame.get("gaps", self.gaps)
        for part in frame.get("parts", ()):
            for place, row in enumerate(part["rows"]):
                for kept, data in ((self.low, part["low"]), (self.high, part["high"])):
                    values = unpack(f"{part['n']}d", data[place * 8 * part["n"] : (place + 1) * 8 * part["n"]])
                    kept[row].update(enumerate(values, part["first"]))
        return True

    def drawn(self, row: int) -> list[float]:
        """The highest values of the buckets on the screen; NaN for a gap, None of them for no news."""
        first, count = self.frame["first"], self.frame["count"]
        high = [self.high[row].get(number, nan) for number in range(first, first + count)]
        return [value for value in high if value != -inf]
