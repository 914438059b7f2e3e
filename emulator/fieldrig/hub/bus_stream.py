"""The messages of one bus for its listeners, in batches: as data (`trace/<bus>`) and as text (`watch/<bus>`).

Without a listener a message costs nothing.  Batches count messages from the start of the listening, so that a listener
knows what it missed: one that is too slow loses whole batches, and never delays the bus.

    {"family": "can", "process": "can0", "first": 120, "epoch_ns": 1795000000000000000,
     "entries": [[time_ns, sender, data], ...]}

Each process that publishes on a direct bus counts for itself.  `time_ns + epoch_ns` is the time of day (Unix); under
virtual time `epoch_ns` is 0.  After a rig in virtual time has gone back, its batches have two more keys: `backs`, how
often it has gone back, and `back_ns`, the instant of the last time.  What came after that instant has never been.
"""

import asyncio
import json
from collections.abc import Callable
from typing import Any

from fieldrig.bus import Bus, Delivery
from fieldrig.control.messages import Control

FULL = 200
"""Messages in a batch.  Encoding them takes well under a millisecond of the bus's process."""
FLUSH_S = 0.02


OnDelivery = Callable[[Delivery[Any]], None]
Listen = Callable[[OnDelivery], Callable[[], None]]


class BusStream:
    def __init__(self, control: Control, bus: Bus[Any], process: str, listen: Listen) -> None:
        """`listen` is called with `add` when listening starts; it returns what ends it."""
        self._loop = asyncio.get_running_loop()
        self.epoch_ns = 0
        self._bus, self._process, self._listen_to_bus = bus, process, listen
        self._end_listening: Callable[[], None] | None = None
        self._pending: list[tuple[int, str, Any]] = []
        self._first = self._backs = self._back_ns = 0
        self._flusher: asyncio.TimerHandle | None = None
        self._wants_data = self._wants_text = False
        self._data = control.stream(f"trace/{bus.name}", self._on_data_wanted)
        self._text = control.stream(f"watch/{bus.name}", self._on_text_wanted)

    def begin(self, epoch_ns: int) -> None:
        """Publish messages from now on.

        A listener that was there before our last answer to a question receives all of them.
        """
        self.epoch_ns = epoch_ns
        self._data.look()
        self._text.look()

    def add(self, delivery: Delivery[Any]) -> None:
        self._pending.append((delivery.time_ns, delivery.sender, delivery.message))
        if len(self._pending) >= FULL:
            self.flush()
        elif self._flusher is None:
            self._flusher = self._loop.call_later(FLUSH_S, self.flush)

    def go_back(self, backs: int, back_ns: int) -> None:
        """Tell the listeners that the rig went back to an instant, for the `backs`-th time."""
        self.flush()
        self._first, self._backs, self._back_ns = 0, backs, back_ns
        if self._wants_data:
            self._data.put(self._batch([]))
        if self._wants_text:
            self._text.put(self._batch([]))

    def flush(self) -> None:
        if self._flusher is not None:
            self._flusher.cancel()
            self._flusher = None
        pending, self._pending = self._pending, []
        if pending:
            if self._wants_data:
                encode = self._bus.encode
                rows = [(time_ns, sender, encode(message).hex()) for time_ns, sender, message in pending]
                self._data.put(self._batch(rows))
            if self._wants_text:
                show = self._bus.show
                rows = [(time_ns, sender, show(message)) for time_ns, sender, message in pending]
                self._text.put(self._batch(rows))
            self._first += len(pending)

    def _batch(self, entries: list[tuple[int, str, str]]) -> str:
        batch = {
            "family": self._bus.family,
            "process": self._process,
            "first": self._first,
            "epoch_ns": self.epoch_ns,
            "entries": entries,
        }
        if self._backs:
            batch |= {"backs": self._backs, "back_ns": self._back_ns}
        return json.dumps(batch, separators=(",", ":"))

    def _on_data_wanted(self, is_wanted: bool) -> None:
        self._wants_data = is_wanted
        self._listen()

    def _on_text_wanted(self, is_wanted: bool) -> None:
        self._wants_text = is_wanted
        self._listen()

    def _listen(self) -> None:
        is_wanted = self._wants_data or self._wants_text
        if is_wanted and self._end_listening is None:
            self._end_listening = self._listen_to_bus(self.add)
        elif not is_wanted and self._end_listening is not None:
            self._end_listening()
            self._end_listening = None
