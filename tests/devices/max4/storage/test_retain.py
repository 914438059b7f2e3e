"""Retain data over power-off: where they are kept, how much, how long; and what outranks what at a boot."""

from collections.abc import Callable
from typing import Any

import pytest
from full_store import FullStore
from max4_bench import Bench

from fieldrig.errors import ConfigError, ControlError
from fieldrig.storage.store import MemoryStore
from fieldrig_devices.max4.storage.disk import WRITE_CYCLES

KB = 1024


def off_for(bench: Bench, days: float) -> Bench:
    number = bench.fault("max4", what="power_off", days=days)
    return bench.run(50).heal("max4", number).run(100)


def marked(**settings: Any) -> tuple[Bench, int]:
    """A controller whose first and last byte of retain data are written, and how many bytes it has."""
    bench = Bench(**settings).run(100)
    size = len(bench.max4.firmware.memory.ram.nvram)
    bench.set("nvram", "0:a1").set("nvram", f"{size - 1}:b9")
    with pytest.raises(ControlError, match=f"expected an offset and data within {size} bytes"):
        bench.set("nvram", f"{size}:00")
    return bench, size


def is_kept(bench: Bench) -> bool:
    data = bench.max4.firmware.memory.ram.nvram
    assert (data[0], data[-1]) in ((0xA1, 0xB9), (0, 0))
    return data[0] == 0xA1


@pytest.mark.manual("PD-048", "PD-049", "PD-050", "PD-315")
@pytest.mark.parametrize(
    ("settings", "size", "kept_days", "lost_days"),
    [
        ({}, 1 * KB, 7, 7.1),
        ({"retain": "ups"}, 64 * KB, 40_000, None),  # more than 100 years
        ({"retain": "pn4"}, 101 * KB, 7, 7.1),
        ({"retain": "pn4", "retain_battery": True}, 101 * KB, 400, None),
    ],
)
def test_retain_data_last_as_long_as_chapter_9_says(
    settings: dict[str, Any], size: int, kept_days: float, lost_days: float | None
) -> None:
    bench, there = marked(**settings)
    assert there == size
    assert is_kept(off_for(bench, kept_days))
    assert bench.get("DiagCode") == (0 if kept_days <= 7 else 7567), "the log is lost when the capacitor is flat"
    if lost_days is not None:
        assert not is_kept(off_for(bench, lost_days))
        assert bench.get("DiagCode") == 7567


@pytest.mark.manual("PD-112")
@pytest.mark.parametrize("settings", [{"retain": "ups"}, {"retain": "pn4", "retain_battery": True}])
def test_the_log_lies_in_the_controllers_ram_all_the_same(settings: dict[str, Any]) -> None:
    bench, _ = marked(**settings)
    assert 8002 in bench.codes()
    off_for(bench, 8)
    assert bench.codes()[-1] in (7567, 8002, 8003)
    assert bench.codes().count(8002) == 1, "the first boot's entry is gone"
    assert is_kept(bench)


@pytest.mark.manual("PD-049")
def test_each_power_off_is_one_of_the_write_cycles_and_the_last_ones_data_stay() -> None:
    bench, _ = marked(retain="ups")
    ups = bench.max4.firmware.memory.ups
    assert ups is not None
    for count in (1, 2):
        off_for(bench, 8)
        assert ups.writes == count
    section = bench.max4.firmware.disk.section("RETAIN")
    section.save(WRITE_CYCLES.to_bytes(4, "little") + bytes(bench.max4.firmware.memory.ram.nvram))
    bench.set("nvram", "0:77")
    off_for(bench, 8)
    assert (ups.writes, bench.max4.firmware.memory.ram.nvram[0]) == (WRITE_CYCLES, 0xA1)


@pytest.mark.manual("PD-049")
def test_a_full_disk_keeps_nothing_and_the_controller_boots() -> None:
    bench = Bench(retain="ups", disk_bytes=65_536).run(100).set("nvram", "0:a1")
    off_for(bench, 8)
    assert bench.max4.firmware.memory.ram.nvram[0] == 0
    assert bench.max4.firmware.is_booted


@pytest.mark.manual("PD-050")
def test_data_and_log_are_there_for_the_next_process() -> None:
    """It was killed: nothing was written at the end."""
    for retain in ("nvram", "ups", "pn4"):
        bench, _ = marked(retain=retain)
        off_for(bench.set("nvram", "0:77"), 1).set("nvram", "0:a1")
        again = Bench(store=bench.store, retain=retain).run(100)
        assert is_kept(again), "as written after the last power-off"
        assert again.codes().count(8002) == 3


def test_a_battery_without_its_module_is_refused() -> None:
    with pytest.raises(ConfigError, match="retain: pn4"):
        Bench(retain_battery=True)


@pytest.mark.manual("PD-056")
def test_retained_before_declared_before_the_default_of_the_type() -> None:
    """Values at a boot without a program: retain data, start values of the parameter file, defaults."""
    bench = Bench(parameters={"MAx-4.General.MsgFilter": 0x0FFF}).run(100)
    bench.set("nvram", "0:a1").set("MsgFilter", 0x0001).set("RetainInit", True)
    restarts: list[Callable[[], object]] = [
        lambda: bench.do("system reset").run(100),
        lambda: off_for(bench, 1),  # the voltage returns within the 7 days of the capacitor
    ]
    for restart in restarts:
        bench.set("MsgFilter", 0x0001).set("RetainInit", True)
        restart()
        assert bench.max4.firmware.memory.ram.nvram[0] == 0xA1, "1: retained, for RetainInit was not saved"
        assert bench.get("MsgFilter") == 0x0FFF, "2: the declared start value"
        assert bench.get("RetainInit") is False, "3: the default of its type"
    assert not any(Bench(parameters={"MAx-4.General.MsgFilter": 0x0FFF}).run(100).max4.firmware.memory.ram.nvram), (
        "cold"
    )
    other = Bench().run(100)
    assert other.get("MsgFilter") == 0xFFFF, "3: the default, where no start value is declared"


def test_ram_of_rubbish_is_empty() -> None:
    """The content is that of another device, or of a capacitor that was discharged."""
    store = MemoryStore()
    store.buffered_ram(65_536)[:] = b"\xa5" * 65_536
    bench = Bench(store=store).run(100)
    assert bench.codes() == [8002, 8003]
    assert not any(bench.max4.firmware.memory.ram.nvram)


def test_without_power_nothing_is_recorded() -> None:
    bench = Bench().run(100)
    bench.fault("max4", what="power_off")
    bench.run(10)
    with bench.rig._present("max4"):
        bench.max4.firmware.tcp_connected("10.205.10.24")
    assert bench.codes() == [8002, 8003]
    assert bench.get("DiagCode") == 0


def test_without_room_for_the_ram_entries_last_until_there_is() -> None:
    store = FullStore()
    store.is_full = store.has_ram = False
    bench = Bench(store=store).run(100).set("nvram", "0:a1")
    assert bench.codes() == [8002, 8003]
    store.has_ram = True
    bench.do("system reset").run(100).set("nvram", "1:b2")
    again = Bench(store=store).run(100)
    assert (bytes(again.max4.firmware.memory.ram.nvram[:2]).hex(), again.codes()[:2]) == ("a1b2", [8002, 8003])


def test_a_download_that_the_disk_does_not_take_ends_there_and_leaves_the_files() -> None:
    store = FullStore()
    store.is_full = False
    bench = Bench(store=store).run(100)
    before = {name: bench.max4.firmware.disk.read(name) for name in bench.max4.firmware.disk.names}
    store.is_full = True
    bench.do("download").run(10_000)
    assert {name: bench.max4.firmware.disk.read(name) for name in bench.max4.firmware.disk.names} == before
    assert (8010 in bench.codes(), store.refused) == (False, 1)
    store.is_full = False
    bench.do("download").run(10_000)
    assert bench.codes().count(8010) == 7


def test_a_file_that_can_not_be_deleted_is_still_there() -> None:
    store = FullStore()
    store.is_full = False
    bench = Bench(store=store).run(100).do("save log \\A.LOG")
    store.is_full = True
    with pytest.raises(ControlError, match="the flash disk cannot be written: No space left on device"):
        bench.do("delete log \\A.LOG")
    assert "\\A.LOG" in bench.max4.firmware.disk
