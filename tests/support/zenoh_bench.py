"""Members of `wires.zenoh` on a loop of its own."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from direct_bench import At
from hub_bench import LoopBench

from fieldrig.control import endpoint
from fieldrig.loop.real_clock import RealClock
from fieldrig.testing import free_port
from fieldrig_bus.wires_zenoh import WiresEnd, WiresZenoh, WiresZenohSettings


class ZenohAt(At):
    def __init__(self, member: str, clock: RealClock, session: Any) -> None:
        super().__init__(member, clock)
        self._session = session

    def session(self) -> Any:
        return self._session


class ZenohBench(LoopBench):
    """Each member is a process of its own as far as Zenoh can tell, or all members are in one."""

    def __init__(self, is_one: bool, settings: WiresZenohSettings | None = None) -> None:
        super().__init__()
        self._is_one, self._settings = is_one, settings or WiresZenohSettings()
        self._place = f"tcp/127.0.0.1:{free_port()}"
        self.sessions = [endpoint.listen(self._place)]
        self._ends: list[tuple[WiresZenoh, str]] = []
        self._bus = WiresZenoh("w", self._settings)

    def join(self, member: str) -> WiresEnd:
        if self._is_one:
            session, bus = self.sessions[0], self._bus
        else:
            session, bus = endpoint.connect(self._place), WiresZenoh("w", self._settings)
            self.sessions.append(session)
        self._ends.append((bus, member))
        return self.loop.run_until_complete(bus.open(ZenohAt(member, self.clock, session)))

    def close(self) -> None:
        for bus, member in self._ends:
            self.loop.run_until_complete(bus.close(member))
        while self.sessions:
            endpoint.close(self.sessions.pop())
        super().close()


@contextmanager
def zenoh_bench(is_one: bool, settings: WiresZenohSettings | None = None) -> Iterator[ZenohBench]:
    bench = ZenohBench(is_one, settings)
    try:
        yield bench
    finally:
        bench.close()
