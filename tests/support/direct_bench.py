"""Members of a direct bus on a loop of its own, for suites that drive links by hand."""

import asyncio
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hub_bench import LoopBench
from patience import PATIENCE_S

from fieldrig.bus import DirectBus
from fieldrig.control.subject import WaitingSubject
from fieldrig.link import Link
from fieldrig.loop.real_clock import RealClock
from fieldrig_bus.can.frame import CanFrame


class At:
    """An Attachment that keeps what goes into the trace."""

    rig = "lab"
    seed = 7
    late_ns = 0
    """The largest lateness of another process."""

    def __init__(self, member: str, clock: RealClock) -> None:
        self.member, self.clock = member, clock
        self.process, self.members = "lab", dict[str, str]()
        self.traced: list[tuple[str, Any]] = []
        self.served: list[WaitingSubject] = []

    def path(self, name: str) -> Path:
        raise NotImplementedError

    def session(self) -> Any:
        raise NotImplementedError

    def note_late(self, late_ns: int) -> None:
        self.late_ns = max(self.late_ns, late_ns)

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        self.clock.handle_at(time.monotonic_ns() if instant_ns is None else instant_ns, handler, message)

    def heard(self, sender: str, message: Any) -> None:
        self.traced.append((sender, message))

    def serve(self, subject: WaitingSubject) -> None:
        self.served.append(subject)


class DirectBench(LoopBench):
    def __init__(self, bus: DirectBus[Any]) -> None:
        super().__init__()
        self.bus = bus
        self.at: dict[str, At] = {}

    def join(self, member: str) -> Link[Any]:
        self.at[member] = At(member, self.clock)
        return self.loop.run_until_complete(self.bus.open(self.at[member]))

    def settle(self) -> None:
        """An interest is in force when `on_receive` returns."""

    def do(self, action: Any, *arguments: Any) -> Any:
        """Run something that blocks, such as a foreign client, while the loop goes on."""

        async def done() -> Any:
            async with asyncio.timeout(PATIENCE_S):
                return await asyncio.to_thread(action, *arguments)

        return self.loop.run_until_complete(done())

    def close(self) -> None:
        for member in self.at:
            self.loop.run_until_complete(self.bus.close(member))
        self.loop.run_until_complete(self.loop.shutdown_default_executor())
        super().close()


class DirectWire:
    """Three members, as suites of link laws want them."""

    carries_fd = True

    def __init__(self, bench: DirectBench) -> None:
        self.settle, self.pump = bench.settle, bench.pump
        self.a, self.b, self.c = bench.join("a"), bench.join("b"), bench.join("c")


@contextmanager
def direct_bench(bus: DirectBus[Any]) -> Iterator[DirectBench]:
    bench = DirectBench(bus)
    try:
        yield bench
    finally:
        bench.close()


def check_that_own_frames_come_back(bench: DirectBench) -> None:
    """A CAN link that asks for its own frames receives all of them, beside those that pass its filters."""
    a, b = bench.join("a"), bench.join("b")
    heard: list[CanFrame] = []
    a.on_receive(heard.append, ["own", [0x200, 0x7FF]])
    for sender, identifier in ((b, 0x100), (a, 0x100), (b, 0x200)):
        sender.send(CanFrame(identifier))
    bench.pump(lambda: len(heard) == 2)
    assert heard == [CanFrame(0x100), CanFrame(0x200)]
