"""A hub on a loop of its own, with links of every kind to it: for conformance suites that drive links by hand."""

import asyncio
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from patience import PATIENCE_S

from fieldrig.bus import ModelBus
from fieldrig.hub.attach import RemoteLink, attach
from fieldrig.hub.hub import LocalHub
from fieldrig.link import Link
from fieldrig.loop.real_clock import RealClock

Where = Literal["here", "unix", "tcp"]


class LoopBench:
    """An event loop that runs only while the test pumps it, and the real clock on it."""

    def __init__(self, new_loop: Callable[[], asyncio.AbstractEventLoop] = asyncio.new_event_loop) -> None:
        self.loop = new_loop()
        self.clock = RealClock(self.loop)

    def pump(self, until: Callable[[], bool]) -> None:
        async def pumping() -> None:
            async with asyncio.timeout(PATIENCE_S):
                while not until():
                    await asyncio.sleep(0.0005)

        self.loop.run_until_complete(pumping())

    def close(self) -> None:
        self.clock.close()
        self.loop.run_until_complete(asyncio.sleep(0))  # transports say good-bye
        self.loop.close()


class HubBench(LoopBench):
    """Members that live in the hub's process ("here"), or attach to it over a Unix socket or TCP."""

    def __init__(self, bus: ModelBus[Any], where: Where, run: Path) -> None:
        super().__init__()
        self.bus, self.where, self._run = bus, where, run
        self.hub = LocalHub(bus, self.clock, run)
        self._remote: list[RemoteLink] = []
        self._asked = self._in_force = 0
        self._count_listens()
        self.loop.run_until_complete(self.hub.open(serve=where != "here"))

    def join(self, member: str) -> Link[Any]:
        if self.where == "here":
            return CountedLink(self.hub.join(member), self)
        run = self._run if self.where == "unix" else self._run / "no sockets here"
        attaching = attach(self.bus, member, self.clock, run, lambda why: None)
        link = self.loop.run_until_complete(attaching)
        self._remote.append(link)
        return CountedLink(link, self)

    def settle(self) -> None:
        """Return when every interest that was named is in force at the hub."""
        self.pump(lambda: self._in_force == self._asked)

    def asked(self) -> None:
        self._asked += 1

    def _count_listens(self) -> None:
        listen = self.hub.listen

        def counted(member: str, interest: Sequence[Any] | None) -> None:
            listen(member, interest)
            self._in_force += 1

        self.hub.listen = counted  # type: ignore[method-assign]  # the only way to know from outside

    def close(self) -> None:
        for link in self._remote:
            self.loop.run_until_complete(link.close())
        self.loop.run_until_complete(self.hub.close())
        super().close()


class CountedLink:
    """A link whose interests are counted, so that `settle` knows what to wait for."""

    def __init__(self, link: Link[Any], bench: HubBench) -> None:
        self._link, self._bench = link, bench
        self.send = link.send

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        self._bench.asked()
        self._link.on_receive(handler, interest)


@contextmanager
def hub_bench(make_bus: Callable[[str | None], ModelBus[Any]], where: Where, port: int) -> Iterator[HubBench]:
    """`make_bus` gets the address to attach at, or None."""
    with tempfile.TemporaryDirectory(prefix="fieldrig-") as folder:
        bus = make_bus(f"tcp://127.0.0.1:{port}" if where == "tcp" else None)
        bench = HubBench(bus, where, Path(folder))
        try:
            yield bench
        finally:
            bench.close()
