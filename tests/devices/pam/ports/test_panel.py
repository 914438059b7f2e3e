"""The fatal error panel at its three places (chapter 12.3; T23)."""

from datetime import UTC, datetime

import pytest
from pam_ports import GROUP, VME, PortBench

from fieldrig_devices.pam.ports.panel import panel_cells

WHEN = datetime(1995, 10, 15, 14, 30, 45, tzinfo=UTC)
CELLS = [0x07, 0x020, 0x169F, 0x27AD, 0, 0, 0]


@pytest.mark.manual("PAMS-056")
def test_date_and_time_are_packed() -> None:
    assert list(panel_cells(7, 0x20, WHEN)) == CELLS
    assert panel_cells(6, 0x16, datetime(1990, 1, 1, tzinfo=UTC), tag=2, info=17) == (6, 0x16, 0x0042, 0, 2, 17, 0)
    noon = datetime(2026, 12, 31, 12, 0, 1, tzinfo=UTC)
    assert panel_cells(2, 0xFF0, noon)[2:4] == (36 << 10 | 12 << 6 | 31 << 1 | 1, 0xC001)
    hours = [panel_cells(2, 0xFF0, noon.replace(hour=hour))[3] >> 12 for hour in (0, 11, 12, 13, 23)]
    assert hours == [0, 11, 12, 1, 11]


@pytest.mark.manual("PAMS-058")
def test_the_panel_of_vme() -> None:
    bench = PortBench(GROUP + VME)
    bench.begin()
    bench.cycles(1001)
    assert bench.kernel.codes[-1] == "07..F020"
    bench.ports.fail(7, 0x020, WHEN)
    assert bench.memory.read(44 // 2, 7) == CELLS


@pytest.mark.manual("PAMS-059")
def test_the_panel_without_a_dual_port() -> None:
    bench = PortBench(GROUP)
    bench.begin()
    bench.ports.fail(7, 0x020, WHEN)
    assert bench.memory.read(0xFF0 // 2, 7) == CELLS
