"""Every link that carries CAN frames keeps the laws of `can_link_laws`, regardless of its kind.

Another link needs a backend, which is a context manager that yields a `Wire`, and a line in `BACKENDS`.
The kernel's CAN is in tests/real.
"""

import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager

import pytest
from can_link_laws import CanLinkLaws, Wire
from direct_bench import DirectBench, DirectWire, direct_bench
from hub_bench import HubBench, Where, hub_bench

from fieldrig.link import Link
from fieldrig.testing import free_port
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.hub import CanHub, CanHubSettings
from fieldrig_bus.can.outsiders import OutsidersSettings
from fieldrig_bus.can.shared import SharedLink
from fieldrig_bus.can.udp import CanUdp, CanUdpSettings
from fieldrig_bus.can.virtual import CanVirtual


class VirtualLink:
    def __init__(self, wire: "VirtualWire", member: str) -> None:
        self._wire, self._member = wire, member
        self.handler: Callable[[CanFrame], None] | None = None

    def send(self, message: CanFrame) -> None:
        self._wire.model.submit(self._wire.now_ns, self._member, message)

    def on_receive(self, handler: Callable[[CanFrame], None], interest: Sequence[object] | None = None) -> None:
        self.handler = handler
        self._wire.model.listen(self._wire.now_ns, self._member, interest)


class VirtualWire:
    """The bus model, driven by hand."""

    carries_fd = True

    def __init__(self) -> None:
        self.bus = CanVirtual("can0", OutsidersSettings(bitrate=500_000, data_bitrate=2_000_000))
        self.model, self.now_ns = self.bus.model(), 0
        self._links: dict[str, VirtualLink] = {}
        self.a, self.b, self.c = self._join("a"), self._join("b"), self._join("c")

    def settle(self) -> None:
        pass

    def pump(self, until: Callable[[], bool]) -> None:
        while not until():
            next_ns = self.model.next_ns()
            assert next_ns is not None, "nothing is under way any more"
            self.now_ns = next_ns
            for delivery in self.model.collect(next_ns):
                for receiver in delivery.receivers:
                    handler = self._links[receiver].handler
                    if handler is not None:
                        message = self.bus.decode(self.bus.encode(delivery.message))
                        assert isinstance(message, CanFrame)
                        handler(message)

    def garble(self, data: bytes) -> None:
        with pytest.raises(ValueError, match=r"."):
            self.bus.decode(data)

    def _join(self, member: str) -> VirtualLink:
        self.model.join(member)
        self._links[member] = VirtualLink(self, member)
        return self._links[member]


@contextmanager
def virtual() -> Iterator[Wire]:
    yield VirtualWire()


class WireOfEnds:
    def __init__(self, wire: VirtualWire, ends: Sequence[Link[CanFrame]]) -> None:
        self.carries_fd = wire.carries_fd
        self.settle, self.pump, self.garble = wire.settle, wire.pump, wire.garble
        self.a, self.b, self.c = ends


@contextmanager
def ends_of_one_link() -> Iterator[Wire]:
    wire = VirtualWire()
    shared = SharedLink(wire.a)
    yield WireOfEnds(wire, [shared.share(hears_others=True) for _ in range(3)])


@contextmanager
def ends_of_three_links() -> Iterator[Wire]:
    """Each link is shared, and its ends are shared again."""
    wire = VirtualWire()
    yield WireOfEnds(wire, [SharedLink(SharedLink(link).share()).share() for link in (wire.a, wire.b, wire.c)])


class HubWire:
    """The hub, with its members in its process or attached to it."""

    carries_fd = True

    def __init__(self, bench: HubBench) -> None:
        self._bench = bench
        self.settle, self.pump = bench.settle, bench.pump
        self.a, self.b, self.c = bench.join("a"), bench.join("b"), bench.join("c")

    def garble(self, data: bytes) -> None:
        with pytest.raises(ValueError, match=r"."):
            self._bench.bus.decode(data)


@contextmanager
def hub(where: Where) -> Iterator[Wire]:
    def can_hub(attach_at: str | None) -> CanHub:
        return CanHub("can0", CanHubSettings(bitrate=1_000_000, data_bitrate=8_000_000, attach=attach_at))

    with hub_bench(can_hub, where, free_port()) as bench:
        yield HubWire(bench)


class UdpWire(DirectWire):
    def __init__(self, bench: DirectBench, settings: CanUdpSettings) -> None:
        super().__init__(bench)
        self._group = (settings.group, settings.port)

    def garble(self, data: bytes) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as outsider:
            outsider.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
            outsider.sendto(data, self._group)


@contextmanager
def udp() -> Iterator[Wire]:
    settings = CanUdpSettings(port=free_port())  # a free TCP port separates simultaneous test runs
    with direct_bench(CanUdp("can0", settings)) as bench:
        yield UdpWire(bench, settings)


BACKENDS: dict[str, Callable[[], AbstractContextManager[Wire]]] = {
    "virtual": virtual,
    "ends of one shared link": ends_of_one_link,
    "ends of three shared links": ends_of_three_links,
    "hub, in its process": lambda: hub("here"),
    "hub, over a Unix socket": lambda: hub("unix"),
    "hub, over TCP": lambda: hub("tcp"),
    "udp": udp,
}
MARKS = {"udp": [pytest.mark.system]}


@pytest.fixture(params=[pytest.param(name, marks=MARKS.get(name, ())) for name in BACKENDS])
def wire(request: pytest.FixtureRequest) -> Iterator[Wire]:
    with BACKENDS[request.param]() as wire:
        yield wire


class TestCanLinks(CanLinkLaws):
    pass
