"""The start-up of the VME DualPort (section 11.5; T26)."""

from collections.abc import Callable
from typing import Any

import pytest
from pam_ports import GROUP, VME, PortBench, started_vme

from fieldrig.clock import MS
from fieldrig_devices.pam.language.ports import PortVariable, crc_of
from fieldrig_devices.pam.ports.masters.vme import VmeMaster
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.options import ClassCodes, PortOptions
from fieldrig_devices.pam.ports.vme.layout import Answer, Command

START_UP = ["07..M01C", "07..M007", "07..M012", "07..M011"]
SYNCHRO, COMMAND, ACKNOWLEDGE = 22 // 2, 24 // 2, 32 // 2
LIMITED = VME.replace("MASTER_CONFIGURATION_TIMEOUT = NONE", "MASTER_CONFIGURATION_TIMEOUT = 300")


@pytest.mark.manual("PAMS-064", "PAMS-066")
def test_the_pam_presets_headers_and_acknowledge_but_not_synchro() -> None:
    bench = PortBench()
    bench.memory.write(0, [0xFFFF] * 2048)
    bench.begin()
    assert bench.memory.read(0, 10) == [58, 0, 0, 144, 14, 2074, 0, 0, 144, 14]
    assert bench.memory.read(SYNCHRO, 1) == [0xFFFF]
    assert bench.memory.read(16, 2) == [1, 0]  # ACK_OK, and PAM PARAMETER 1


@pytest.mark.manual("PAMS-067", "PAMS-107")
@pytest.mark.parametrize("cleared_by", ["pam", "master"])
@pytest.mark.parametrize("stale", [0, 1, 0x5A5A])
@pytest.mark.parametrize("later", ["pam", "master", "neither"])
def test_start_up_works_in_every_order_with_every_stale_value(stale: int, later: str, cleared_by: str) -> None:
    options = PortOptions(command_cleared_by="pam" if cleared_by == "pam" else "master")
    bench = PortBench(options=options)
    bench.memory.write(0, [stale] * 2048)
    master = VmeMaster(bench.variables, options)
    if later == "pam":
        bench.power_on_ns = 200 * MS
    else:
        bench.begin()
    if later == "master":
        bench.cycles(200)
    bench.play(master.start_up())
    assert bench.kernel.codes == START_UP
    assert bench.ports.states == {"DualPort": "running"}
    assert bench.ports.may_run
    assert not master.mistakes


@pytest.mark.parametrize(("stale", "last"), [(0, 0), (1, 1)])
def test_the_last_synchro_depends_on_the_first(stale: int, last: int) -> None:
    bench = PortBench()
    bench.memory.write(SYNCHRO, [stale])
    bench.begin()
    if stale == 0:
        bench.cycles()
    bench.play(VmeMaster(bench.variables).synchronise())
    bench.cycles()
    assert bench.memory.read(SYNCHRO, 1) == [last]


@pytest.mark.manual("PAMS-068", "PAMS-082")
def test_a_master_that_is_not_ready_is_fatal() -> None:
    bench = PortBench()
    bench.memory.write(SYNCHRO, [1])
    bench.begin()
    bench.cycles(499)
    assert bench.kernel.codes == ["07..M01C"]
    bench.cycles()
    assert bench.kernel.codes == ["07..M01C", "07..F020"]
    assert bench.ports.states == {"DualPort": "fatal error"}
    bench.memory.write(SYNCHRO, [0])
    bench.cycles(100)
    assert bench.memory.read(SYNCHRO, 1) == [0]  # only a reset leads on
    bench.begin()
    bench.cycles()
    assert bench.memory.read(SYNCHRO, 1) == [1]


def test_each_wait_for_synchro_has_its_own_time() -> None:
    bench = PortBench()
    bench.begin()
    bench.cycles(400)
    assert bench.memory.read(SYNCHRO, 1) == [1]  # the first wait ended at once, the second has begun
    bench.cycles(101)
    assert bench.kernel.codes[-1] == "07..F020"


@pytest.mark.manual("PAMS-071")
def test_a_late_command_is_fatal() -> None:
    bench = PortBench(GROUP + LIMITED)
    bench.begin()
    master = VmeMaster(bench.variables)
    bench.play(master.synchronise())
    bench.cycles(290)
    assert bench.play(master.command(Command.ASK_DEF_IN)) == Answer.ACK_OK
    bench.cycles(285)
    assert bench.kernel.codes[-1] == "07..M007"
    bench.cycles(16)
    assert bench.kernel.codes[-1] == "07..F020"


def test_without_time_outs_the_pam_waits_for_ever() -> None:
    bench = PortBench(GROUP + VME.replace("= 500", "= NONE"))
    bench.memory.write(SYNCHRO, [1])
    bench.begin()
    bench.cycles(3000)
    assert bench.kernel.codes == ["07..M01C"]


@pytest.mark.manual("PAMS-063", "PAMS-065", "PAMS-069")
def test_definitions_of_inputs() -> None:
    bench = PortBench()
    bench.begin()
    master = VmeMaster(bench.variables)
    bench.play(master.synchronise())
    seen = []
    while bench.play(master.command(Command.ASK_DEF_IN)) == Answer.ACK_OK:
        seen.append(tuple(bench.memory.read(34 // 2, 5)))
    crc = {name: crc_of(name) for name in bench.ports.items}
    assert seen == [  # CRC, key, class, items, period in ms; the classes are those of the settings
        (crc["DFI_MachRunning"], 1, 1, 1, 20),
        (crc["DFI_MachAlarm"], 2, 1, 1, 10),
        (crc["DFI_MachHeadReady"], 3, 1, 4, 20),
        (crc["DFI_MachHeadStopped"], 4, 1, 6, 20),
        (crc["DWI_MachPressure"], 5, 2, 1, 5),
        (crc["DLI_MachHeadSpeed"], 6, 3, 6, 20),
        (crc["DRI_MachHeadFactor"], 7, 4, 6, 20),
    ]
    assert bench.play(master.command(Command.ASK_DEF_IN)) == Answer.END_DEF_IN


@pytest.mark.manual("PAMS-070", "PAMS-072")
def test_an_output_with_an_unknown_crc_is_never_updated() -> None:
    bench = PortBench()
    bench.begin()
    master = VmeMaster(bench.variables)
    bench.play(master.synchronise())
    bench.play(master.configure_inputs())
    assert bench.play(master.command(Command.DEF_OUT, 0x1234, 0x0002, 0x0001)) == Answer.BAD_CRC
    assert bench.kernel.reports[-1] == ("07..E028", (0x1234, 0x0001_0002, 0))
    assert bench.play(master.command(Command.END_DEF_OUT)) == Answer.ACK_OK
    bench.play(master.initialise({}))
    assert bench.play(master.command(Command.START)) == Answer.ACK_OK
    bench.item("DWO_MachCurrentPressure").set_value(5)
    assert bench.memory.read(12 // 2, 1) == [0]  # it has the key -1


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (PortVariable("DWI_MachPressure", "LONG_VAR", True), "DWI_MachPressure has the class 2 and 1 items on the PAM"),
        (PortVariable("DWI_MachPressure", "WORD_VAR", True, number=2), "DWI_MachPressure has the class 2 and 1 items"),
        (PortVariable("DFO_MachStopped", "WORD_VAR", False), "DFO_MachStopped has the class 1 and 1 items on the PAM"),
        (PortVariable("DFO_Other", "FLAG_VAR", False), "the PAM does not know the output DFO_Other"),
    ],
)
def test_a_master_uses_nothing_that_is_defined_in_another_way(wrong: PortVariable, said: str) -> None:
    bench = PortBench()
    bench.begin()
    master = VmeMaster([*(found for found in bench.variables if found.name != wrong.name), wrong])
    bench.play(master.start_up({wrong.name: 1} if wrong.is_input else None))
    assert master.mistakes[0].startswith(said)
    assert bench.ports.may_run
    assert bench.value("DWI_MachPressure") == 0


def test_an_unknown_code_and_a_command_in_the_wrong_phase() -> None:
    bench = PortBench()
    bench.begin()
    master = VmeMaster(bench.variables)
    bench.play(master.synchronise())
    bench.play(master.command(Command.ASK_DEF_IN))
    assert bench.play(master.command(Command.END_DEF_OUT)) == Answer.CDE_REJECTED  # not all inputs are asked for
    bench.memory.write(ACKNOWLEDGE, [0])
    bench.memory.write(COMMAND, [77])
    bench.cycles()
    assert bench.memory.read(ACKNOWLEDGE, 1) == [Answer.BAD_CDE]
    bench.play(master.configure_inputs())
    bench.play(master.configure_outputs())
    assert bench.play(master.command(Command.ASK_DEF_IN)) == Answer.CDE_REJECTED
    assert bench.play(master.command(Command.END_INIT_IN)) == Answer.CDE_REJECTED


@pytest.mark.manual("PAMS-076")
def test_start_is_rejected_before_the_configuration_is_complete_and_starts_anyway() -> None:
    bench = PortBench()
    bench.begin()
    master = VmeMaster(bench.variables)
    bench.play(master.synchronise())
    assert bench.play(master.command(Command.START)) == Answer.CDE_REJECTED
    assert bench.ports.may_run


@pytest.mark.manual("PAMS-074")
def test_inputs_begin_with_the_initial_values_of_the_master() -> None:
    bench = PortBench()
    bench.begin()
    master = VmeMaster(bench.variables)
    bench.play(master.start_up({"DWI_MachPressure": -12, "DRI_MachHeadFactor": [1.5, 2.5, 0, 0, 0, 123.75]}))
    assert bench.value("DWI_MachPressure") == -12
    assert [bench.value("DRI_MachHeadFactor", index) for index in (0, 1, 5)] == [1.5, 2.5, 123.75]
    assert bench.kernel.events == []  # the application does not run yet


def test_end_init_in_is_acknowledged_when_the_fifo_is_empty() -> None:
    bench = PortBench()
    bench.begin()
    master = VmeMaster(bench.variables)
    for script in (master.synchronise(), master.configure_inputs(), master.configure_outputs()):
        bench.play(script)
    bench.play(master.command(Command.INIT_IN))
    bench.play(master.put("DWI_MachPressure", 5))
    bench.memory.write(ACKNOWLEDGE, [Answer.NO_ACK])
    bench.memory.write(COMMAND, [Command.END_INIT_IN])
    bench.cycles()
    assert bench.memory.read(ACKNOWLEDGE, 1) == [Answer.ACK_OK]
    assert bench.value("DWI_MachPressure") == 5


class Racing(list[int]):
    """Words in which the master acts just before the PAM looks at COMMAND."""

    act: Callable[[], None] | None = None

    def __getitem__(self, place: Any) -> Any:
        if place == COMMAND and self.act is not None:
            act, self.act = self.act, None
            act()
        return super().__getitem__(place)


def test_a_block_that_arrives_with_end_init_in_is_read_first() -> None:
    words = Racing([0] * 2048)
    bench = PortBench(memory=Memory(words))
    bench.begin()
    master = VmeMaster(bench.variables)
    for script in (master.synchronise(), master.configure_inputs(), master.configure_outputs()):
        bench.play(script)
    bench.play(master.command(Command.INIT_IN))

    def act() -> None:
        bench.play(master.put("DWI_MachPressure", 5))
        bench.memory.write(ACKNOWLEDGE, [Answer.NO_ACK])
        bench.memory.write(COMMAND, [Command.END_INIT_IN])

    words.act = act
    bench.cycles()
    assert bench.memory.read(ACKNOWLEDGE, 1) == [Answer.NO_ACK]
    bench.cycles()
    assert bench.memory.read(ACKNOWLEDGE, 1) == [Answer.ACK_OK]
    assert bench.value("DWI_MachPressure") == 5


def test_no_time_out_of_the_start_up_is_left_while_the_application_runs() -> None:
    bench, master = started_vme(GROUP + LIMITED)
    for _ in range(100):
        bench.play(master.watch())
        bench.cycles(10)
    assert bench.kernel.codes == START_UP


def test_after_a_reset_no_key_of_before_is_used() -> None:
    bench, master = started_vme()
    bench.begin()
    bench.play(master.synchronise())
    bench.play(master.command(Command.START))
    assert bench.ports.may_run
    bench.item("DFO_MachStopped").do("set", ())
    assert bench.memory.read(12 // 2, 1) == [0]


def test_class_codes_are_those_of_the_settings() -> None:
    options = PortOptions(class_codes=ClassCodes(flag=10, word=11, long=12, real=13))
    bench, master = started_vme(options=options)
    assert not master.mistakes
    assert bench.memory.read(38 // 2, 1) == [13]  # the last definition was a real


def test_a_reset_begins_again_without_keys_and_values() -> None:
    bench, master = started_vme()
    bench.play(master.put("DWI_MachPressure", 5))
    bench.cycles(600)
    assert bench.item("DualPort").ask("error", ())
    bench.begin()
    assert bench.value("DWI_MachPressure") == 0
    assert not bench.item("DualPort").ask("error", ())
    assert not bench.ports.may_run
    bench.play(master.start_up())
    assert bench.ports.may_run


def test_a_block_that_waits_for_its_period_is_lost_at_a_reset() -> None:
    bench, master = started_vme()
    bench.cycles(21 - bench.kernel.cycle_number % 20)
    bench.play(master.put("DLI_MachHeadSpeed", 5, 0))
    bench.cycles()
    bench.begin()
    bench.play(master.start_up())
    bench.cycles(20)
    assert bench.value("DLI_MachHeadSpeed", 0) == 0
