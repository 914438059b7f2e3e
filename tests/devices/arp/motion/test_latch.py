"""Latched positions: manual 4.2.1 and 4.6."""

import pytest
from arp_axes import AxesBench

from fieldrig_devices.arp.motion.flags import AxisFlag


@pytest.fixture(params=[1, 2])
def axis(request: pytest.FixtureRequest) -> int:
    return int(request.param)


def edge(bench: AxesBench, axis: int, level: int, at: int) -> None:
    bench.latches[axis] = level
    bench.counts[axis] = at
    bench.loop()


@pytest.mark.manual("ARP-057", "ARP-072")
def test_armed_edge_takes_the_position_and_clears_its_flag(axis: int) -> None:
    bench = AxesBench()
    bench.raise_flag(axis, AxisFlag.ARM_RISING)
    edge(bench, axis, 0, 10)
    assert bench.flag(axis, AxisFlag.ARM_RISING) == 1
    edge(bench, axis, 1, 20)
    assert bench.axes.latched_rising(axis) == 20_000
    assert bench.flag(axis, AxisFlag.ARM_RISING) == 0
    edge(bench, axis, 0, 30)
    edge(bench, axis, 1, 40)
    assert bench.axes.latched_rising(axis) == 20_000  # not armed again
    bench.raise_flag(axis, AxisFlag.ARM_FALLING)
    edge(bench, axis, 1, 50)
    assert bench.axes.latched_falling(axis) == 0
    edge(bench, axis, 0, 60)
    assert bench.axes.latched_falling(axis) == 60_000
    assert bench.flag(axis, AxisFlag.ARM_FALLING) == 0
    assert bench.axes.latched_rising(axis) == 20_000


@pytest.mark.manual("ARP-072")
def test_level_that_was_there_before_is_no_edge(axis: int) -> None:
    bench = AxesBench()
    edge(bench, axis, 1, 10)
    bench.raise_flag(axis, AxisFlag.ARM_RISING)
    edge(bench, axis, 1, 20)
    assert bench.flag(axis, AxisFlag.ARM_RISING) == 1
