"""TIME, CiA 301 7.2.6: 1012h as consumer and producer."""

import pytest
from canopen_bench import CanopenBench

# 10:00:00.000 is 02255100h ms; 2026-11-21 is day 3D2Fh (15663) since 1984-01-01.
STAMP = "00 51 25 02 2f 3d"


def test_time_stamp_sets_the_clock_which_goes_on(bench: CanopenBench) -> None:
    assert bench.point("time") == "1984-01-01T00:00:00.000"
    bench.send(f"100#{STAMP}")
    assert bench.point("time") == "2026-11-19T10:00:00.000"
    bench.after(1500)
    assert bench.point("time") == "2026-11-19T10:00:01.500"


def test_reserved_bits_don_t_count(bench: CanopenBench) -> None:
    bench.send("100#00 51 25 f2 2f 3d")
    assert bench.point("time") == "2026-11-19T10:00:00.000"


@pytest.mark.parametrize("frame", ["100#", "100#R", "100#00 51 25 02 2f", f"100#{STAMP} 00", f"101#{STAMP}"])
def test_what_is_no_time_stamp_changes_nothing(bench: CanopenBench, frame: str) -> None:
    bench.send(frame)
    assert bench.point("time") == "1984-01-01T00:00:00.000"


def test_producer_tells_the_time(bench: CanopenBench) -> None:
    bench.set("time", "2026-11-19T09:59:59")
    bench.write("23 12 10 00 00 01 00 00", "23 12 10 00 00 01 00 40")
    assert bench.after(2000) == [f"100#{STAMP}", "100#e8 54 25 02 2f 3d"]
    bench.send("000#02 05")
    assert bench.after(2000) == []
    bench.send("000#80 05")
    assert len(bench.after(2000)) == 2


def test_consumer_hears_its_own_cob_id_only_while_it_consumes(bench: CanopenBench) -> None:
    bench.play(
        [
            ("23 12 10 00 01 01 00 80", "80 12 10 00 22 00 00 08"),
            ("23 12 10 00 00 01 00 00", "60 12 10 00 00 00 00 00"),
            ("23 12 10 00 01 01 00 80", "80 12 10 00 30 00 09 06"),  # 101h is restricted
            ("23 12 10 00 80 00 00 00", "60 12 10 00 00 00 00 00"),
        ]
    )
    assert 0x100 not in bench.interest


@pytest.mark.parametrize("value", ["noon", "1983-12-31T00:00:00", "2200-01-01T00:00:00", 5])
def test_what_is_no_time_is_refused(bench: CanopenBench, value: str | int) -> None:
    with pytest.raises(ValueError, match="expected"):
        bench.set("time", value)
