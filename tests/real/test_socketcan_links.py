"""The kernel's CAN keeps what every link that carries CAN frames promises."""

from collections.abc import Iterator

import pytest
from can_link_laws import CanLinkLaws, Wire
from direct_bench import DirectWire, direct_bench

from fieldrig_bus.can.socketcan import CanSocketcan, CanSocketcanSettings

pytestmark = [pytest.mark.real, pytest.mark.vcan]


class SocketcanWire(DirectWire):
    def garble(self, data: bytes) -> None:
        """The kernel lets nothing in that is no frame."""


@pytest.fixture
def wire() -> Iterator[Wire]:
    with direct_bench(CanSocketcan("can0", CanSocketcanSettings(channel="vcan0", fd=True))) as bench:
        yield SocketcanWire(bench)


class TestSocketcanLinks(CanLinkLaws):
    pass
