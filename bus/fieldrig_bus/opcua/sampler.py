"""Samples the values that clients have subscribed to, each at its interval, and nothing else.

Monitored items of one device with the same interval are read in one request; a device that is late delays only its own.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterable, Sequence
from typing import Final, NamedTuple

from asyncua import ua

log = logging.getLogger(__name__)

DEFAULT_MS: Final = 100.0
"""Interval for clients that leave it to the server with 0 (OPC 10000-4, 5.13.1.2: "the fastest practical rate")."""
SLOWEST_MS: Final = 3_600_000.0

Item = tuple[int, int]
"""Subscription and monitored item."""
Group = tuple[float, int]
"""Interval in milliseconds, and the namespace of a device."""
Take = Callable[[ua.DataValue], Awaitable[None]]


class Sampled(NamedTuple):
    node_id: ua.NodeId
    interval_ms: float
    take: Take

    @property
    def group(self) -> Group:
        """The group of items that are sampled together."""
        return self.interval_ms, self.node_id.NamespaceIndex


def revised_ms(requested_ms: float, publishing_ms: float, fastest_ms: float) -> float:
    """Return the interval that the server uses; -1 asks for that of the subscription (OPC 10000-4, 5.13.1.2)."""
    wanted = publishing_ms if requested_ms < 0 else DEFAULT_MS if requested_ms == 0 else requested_ms
    return min(max(fastest_ms, wanted), SLOWEST_MS)  # in this order NaN becomes the fastest


class Sampler:
    """`values` returns the present values of nodes; an item gets its own by `take`."""

    def __init__(self, values: Callable[[list[ua.NodeId]], Awaitable[Sequence[ua.DataValue]]]) -> None:
        self._values = values
        self._items: dict[Item, Sampled] = {}
        self._tasks: dict[Group, asyncio.Task[None]] = {}

    @property
    def intervals_ms(self) -> list[float]:
        """The intervals at which devices are asked at present."""
        return sorted({interval_ms for interval_ms, _ in self._tasks})

    def __contains__(self, item: Item) -> bool:
        return item in self._items

    async def add(self, item: Item, node_id: ua.NodeId, interval_ms: float, take: Take) -> None:
        """Take the first sample now, and the others at the interval (OPC 10000-4, 5.13.1.2)."""
        [value] = await self._values([node_id])
        await take(value)
        self._keep(item, Sampled(node_id, interval_ms, take))

    def _keep(self, item: Item, sampled: Sampled) -> None:
        self._items[item] = sampled
        if sampled.group not in self._tasks:
            self._tasks[sampled.group] = asyncio.get_running_loop().create_task(self._run(sampled.group))

    def change(self, item: Item, interval_ms: float) -> None:
        if item in self._items:
            self._keep(item, self._items.pop(item)._replace(interval_ms=interval_ms))
            self._end_unused()

    def remove(self, items: Iterable[Item]) -> None:
        for item in items:
            self._items.pop(item, None)
        self._end_unused()

    def remove_subscription(self, number: int) -> None:
        self.remove([item for item in self._items if item[0] == number])

    async def close(self) -> None:
        self._items.clear()
        tasks = list(self._tasks.values())
        self._end_unused()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _end_unused(self) -> None:
        used = {sampled.group for sampled in self._items.values()}
        for group in [group for group in self._tasks if group not in used]:
            self._tasks.pop(group).cancel()

    async def _run(self, group: Group) -> None:
        loop, (interval_ms, _) = asyncio.get_running_loop(), group
        due_s = loop.time()
        while True:
            due_s = max(due_s + interval_ms / 1e3, loop.time())  # a busy host leaves samples out
            await asyncio.sleep(due_s - loop.time())
            due = [sampled for sampled in self._items.values() if sampled.group == group]
            nodes = list(dict.fromkeys(sampled.node_id for sampled in due))
            values = dict(zip(nodes, await self._values(nodes), strict=True))
            for sampled in due:
                await sampled.take(values[sampled.node_id])
