"""The VME DualPort while the application runs (sections 11.3, 11.6 and 11.7)."""

from datetime import UTC, datetime

import pytest
from pam_ports import GROUP, VME, PortBench, started_vme

from fieldrig_devices.pam.ports.vme.layout import (
    BLOCKS,
    Command,
    input_block,
    output_block,
    value_of,
)

WATCHDOG = 20 // 2
SOME_DAY = datetime(1995, 10, 15, tzinfo=UTC)
PI = 3.141592653589793


def behind_an_update(bench: PortBench) -> None:
    """Go to the cycle behind the one in which all periods up to 20 cycles have ended."""
    bench.cycles(21 - bench.kernel.cycle_number % 20)


@pytest.mark.manual("PAMS-077")
@pytest.mark.parametrize(
    ("key", "index", "kind", "value", "words"),
    [
        (5, 0, "WORD_VAR", -2, "0005 0000 0000 FFFE 0000 0000 0000"),
        (7, 2, "REAL_VAR", PI, "0007 0000 0002 2D18 5444 21FB 4009"),
        (7, -1, "REAL_VAR", 123.75, "0007 0000 FFFF 0000 0000 F000 405E"),
        (1, 3, "FLAG_VAR", True, "0001 0000 0003 0001 0000 0000 0000"),
    ],
)
def test_input_blocks(key: int, index: int, kind: str, value: float, words: str) -> None:
    block = tuple(int(word, 16) for word in words.split())
    assert input_block(key, index, kind, value) == block
    assert value_of(kind, block[3:]) == value


@pytest.mark.manual("PAMS-078")
def test_an_output_block_has_32_bits_of_key() -> None:
    block = output_block(0x0001_0002, -1, "LONG_VAR", 0x1234_5678)
    assert " ".join(f"{word:04X}" for word in block) == "0002 0001 FFFF 5678 1234 0000 0000"


@pytest.mark.manual("PAMS-078")
def test_each_change_of_an_output_is_written_at_once() -> None:
    bench, master = started_vme()
    bench.item("DLO_MachHeadPosition", 3).set_value(-70_000)
    bench.item("DLO_MachHeadPosition", 3).set_value(-70_000)  # no change
    bench.item("DFO_MachStopped").do("set", ())
    bench.item("DFO_MachStopped").do("invert", ())
    bench.item("DRO_MachHeadLevel", 0).set_value(0.25)
    assert bench.play(master.take()) == [
        ("DLO_MachHeadPosition", 3, -70_000),
        ("DFO_MachStopped", 0, True),
        ("DFO_MachStopped", 0, False),
        ("DRO_MachHeadLevel", 0, 0.25),
    ]
    assert bench.value("DRO_MachHeadLevel", 0) == 0.25
    assert bench.kernel.events == [
        "DLO_MachHeadPosition",
        "DFO_MachStopped",
        "DFO_MachStopped",
        "DRO_MachHeadLevel",
    ]


def test_a_master_passes_over_a_block_with_an_unknown_key() -> None:
    bench, master = started_vme()
    bench.ports._ports[0]._out.put((99, 0, 0, 1, 0, 0, 0))  # type: ignore[attr-defined]
    bench.item("DFO_MachStopped").do("set", ())
    assert bench.play(master.take()) == [("DFO_MachStopped", 0, True)]
    assert master.mistakes == ["a value has the unknown key 99"]


@pytest.mark.parametrize(("given", "kept"), [(32767, 32767), (40_000, -25_536), (-2.9, -2), (float("inf"), 0)])
def test_a_word_has_16_bits(given: float, kept: int) -> None:
    bench, master = started_vme()
    bench.item("DWO_MachCurrentPressure").set_value(1)
    bench.item("DWO_MachCurrentPressure").set_value(given)
    assert bench.value("DWO_MachCurrentPressure") == kept
    bench.play(master.take())
    assert master.values["DWO_MachCurrentPressure"] == [kept]


@pytest.mark.manual("PAMS-079", "PAML-220")
def test_a_period_raises_one_event_with_the_last_value() -> None:
    bench, master = started_vme()
    behind_an_update(bench)
    for value in (1, 2, 3):
        bench.play(master.put("DLI_MachHeadSpeed", value, 4))
        bench.cycles(2)
    assert bench.value("DLI_MachHeadSpeed", 4) == 0
    bench.cycles(15)
    assert bench.value("DLI_MachHeadSpeed", 4) == 3
    assert bench.kernel.events == ["DLI_MachHeadSpeed"]


@pytest.mark.manual("PAMS-085")
def test_each_period_has_its_own_updates() -> None:
    bench, master = started_vme()
    behind_an_update(bench)
    for name in ("DWI_MachPressure", "DFI_MachAlarm", "DFI_MachRunning"):
        bench.play(master.put(name, 1))
    seen = []
    for _ in range(20):
        bench.cycles()
        seen.append(len(bench.kernel.events))
    assert seen == [0] * 4 + [1] * 5 + [2] * 10 + [3]


@pytest.mark.manual("PAMS-079")
def test_a_full_queue_of_a_period_is_reported() -> None:
    bench, master = started_vme()
    behind_an_update(bench)
    for value in range(150):
        if value in (50, 100):
            bench.cycles(2)
        assert bench.play(master.put("DLI_MachHeadSpeed", value, 0))
    bench.cycles()
    lost = [details for code, details in bench.kernel.reports if code == "07..E02B"]
    assert len(lost) == 150 - BLOCKS
    assert lost[0][:2] == (20, BLOCKS)
    bench.cycles(20)
    assert bench.value("DLI_MachHeadSpeed", 0) == BLOCKS - 1  # what did not fit is lost


@pytest.mark.manual("PAMS-077")
def test_index_minus_one_means_all_items() -> None:
    bench, master = started_vme()
    bench.play(master.put("DRI_MachHeadFactor", 1.5, -1))
    bench.cycles(20)
    assert [bench.value("DRI_MachHeadFactor", index) for index in range(6)] == [1.5] * 6


@pytest.mark.manual("PAMS-075")
@pytest.mark.parametrize(
    ("key", "index", "report"),
    [
        (0, 0, ("07..E029", (0, 0xFFFF_FFFF, 0))),
        (99, 0, ("07..E029", (99, 0xFFFF_FFFF, 0))),
        (5, 1, ("07..E02A", (5, 0, 1))),  # the only word
        (2, 0xFFFF, ("07..E02A", (2, 1, 0xFFFF))),  # the second flag has one item only
        (4, 6, ("07..E02A", (4, 3, 6))),
    ],
)
def test_a_block_with_a_wrong_key_or_index_is_dropped(
    key: int, index: int, report: tuple[str, tuple[int, ...]]
) -> None:
    bench, _ = started_vme()
    bench.memory.write(58 // 2 + 7 * bench.memory.read(1, 1)[0], input_block(key, index, "WORD_VAR", 1))
    bench.memory.write(1, [bench.memory.read(1, 1)[0] + 1])
    bench.cycles(20)
    assert bench.kernel.reports[-1] == report
    assert bench.kernel.events == []


@pytest.mark.manual("PAMS-086", "PAML-029")
def test_components_that_are_not_active_are_not_serviced() -> None:
    bench, master = started_vme()
    bench.inactive = {1, 3}
    bench.play(master.put("DFI_MachHeadReady", True, -1))
    bench.cycles(20)
    assert [bench.value("DFI_MachHeadReady", index) for index in range(4)] == [True, False, True, False]
    for index in range(4):
        bench.item("DLO_MachHeadPosition", index).set_value(7)
    assert [index for _, index, _ in bench.play(master.take())] == [0, 2]


@pytest.mark.manual("PAMS-081", "PAMS-083", "PAMS-107")
def test_a_master_that_stops_is_an_error_and_the_application_goes_on() -> None:
    bench, master = started_vme()
    for _ in range(100):
        assert bench.play(master.watch())
        bench.cycles(10)
    port = bench.item("DualPort")
    assert (port.ask("error", ()), port.ask("error_code", ()), port.ask("error_code", (1,))) == (False, 1, True)
    bench.cycles(490)
    assert not port.ask("error", ())
    bench.cycles(30)
    assert bench.kernel.codes[-1] == "07..E01E"
    assert (port.ask("error", ()), port.ask("error_code", ()), port.ask("error_code", (2,))) == (True, 2, True)
    assert bench.kernel.events == ["DualPort"]
    assert bench.ports.states == {"DualPort": "running without a master"}
    assert bench.ports.may_run
    bench.play(master.put("DWI_MachPressure", 1))
    bench.cycles(100)
    assert bench.value("DWI_MachPressure") == 0  # inputs are no longer read
    bench.memory.write(WATCHDOG, [1])
    bench.cycles(100)
    assert bench.memory.read(WATCHDOG, 1) == [1]  # nor is the watchdog served
    assert bench.kernel.codes.count("07..E01E") == 1
    bench.item("DFO_MachStopped").do("set", ())
    assert bench.play(master.take()) == [("DFO_MachStopped", 0, True)]


@pytest.mark.manual("PAMS-081")
def test_the_time_out_counts_from_the_last_watchdog() -> None:
    bench, master = started_vme()
    bench.play(master.watch())
    while bench.memory.read(WATCHDOG, 1) == [1]:
        bench.cycles()
    bench.cycles(509)
    assert "07..E01E" not in bench.kernel.codes
    bench.cycles()  # the first look after more than 500 ms
    assert bench.kernel.codes[-1] == "07..E01E"


@pytest.mark.manual("PAMS-081")
def test_the_master_sees_that_the_pam_has_stopped() -> None:
    bench, master = started_vme()
    alive = []
    bench.ports.fail(3, 0x2C, SOME_DAY)
    for _ in range(52):
        alive.append(bench.play(master.watch()))
        bench.cycles(10)
    assert alive == [True] * 51 + [False]


@pytest.mark.manual("PAMS-084")
def test_the_inactivity_time_out_is_changed_by_a_program() -> None:
    bench, _ = started_vme()
    port = bench.item("DualPort")
    assert port.parameter("MASTER_INACTIVITY_TIMEOUT") == 500
    assert port.parameter("MASTER_CONFIGURATION_TIMEOUT") == 0  # NONE
    port.set_parameter("MASTER_INACTIVITY_TIMEOUT", 100)
    bench.cycles(130)
    assert bench.kernel.codes[-1] == "07..E01E"
    bench, _ = started_vme()
    for ignored in (-1, float("inf"), float("nan")):
        bench.item("DualPort").set_parameter("MASTER_INACTIVITY_TIMEOUT", ignored)
        assert bench.item("DualPort").parameter("MASTER_INACTIVITY_TIMEOUT") == 500
    bench.item("DualPort").set_parameter("MASTER_INACTIVITY_TIMEOUT", "NONE")
    bench.cycles(2000)
    assert "07..E01E" not in bench.kernel.codes


def test_commands_are_answered_while_the_application_runs() -> None:
    bench, master = started_vme()
    assert bench.play(master.command(Command.START)) == 3  # CDE_REJECTED


def test_an_application_without_a_port_runs_at_once() -> None:
    bench = PortBench(GROUP)
    bench.begin()
    assert bench.kernel.codes == ["07..M005"]
    assert bench.ports.may_run
    assert not bench.item("DualPort").ask("error", ())


def test_periods_in_milliseconds_are_rounded_up() -> None:
    bench = PortBench(GROUP + VME.replace("PERIOD = 10", "PERIOD = 6").replace("PERIOD = 5 ", "PERIOD = 200 "))
    periods = {variable.name: variable.period for variable in bench.variables}
    assert (periods["DFI_MachAlarm"], periods["DWI_MachPressure"], periods["DFI_MachRunning"]) == (10, 50, 20)
