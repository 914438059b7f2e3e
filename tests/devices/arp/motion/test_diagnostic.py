"""Values of an axis that the diagnostic outputs show: manual 3.1, @Par[10]; digest 6.1."""

import pytest
from arp_axes import AxesBench


@pytest.mark.manual("ARP-014")
def test_codes_1_to_9_of_an_axis_in_motion() -> None:
    bench = AxesBench((1, 4, 2.0), (1, 1, 2.0), (1, 7, 1000.0), (1, 8, 5000.0), (1, 11, 0.5))
    bench.counts[1] = 100
    bench.loop()
    bench.axes.move_by(1, 100_000)
    bench.loop(9)
    bench.counts[1] = 103
    bench.loop()
    shown = [bench.axes.diagnostic(1, code) for code in range(1, 10)]
    # found at 50 units; 10 ms at 5000 unit/s2: 0.25 unit, 50 unit/s; 3 counts are 1.5 units
    assert shown == pytest.approx([103, 51.5, 1500, 50.25, 50, 5000, 0.5 * -1.25, -1.25, 3])
    assert bench.axes.diagnostic(1, 0) == bench.axes.diagnostic(1, 10) == 0
    assert bench.axes.tracking_error(1) == -1_250
    assert bench.axes.diagnostic(2, 4) == 0
