"""The feeder in virtual time: a Modbus master sets recipes, labels are fed to the pulse, and the bar keeps its heat."""

from collections.abc import Callable
from pathlib import Path

import pytest

from fieldrig import MS, Branch, BranchMaker, Rig, RigMaker, S
from fieldrig_bus.modbus import ModbusRequest, ModbusResponse

RIG = Path(__file__).with_name("feeder.yaml")
FEEDER, SEALER = 1, 2
START, STARTED = "05 0000 ff00", "050000ff00"

Ask = Callable[[int, str], str]


def hot(rig: Rig) -> None:
    """Let the bar get its temperature."""
    rig.until(lambda: rig.get("feeder/g_bHot"), within=100 * S)


def asked(rig: Rig, bus: str, unit: int, pdu: str) -> str:
    """Return the response of a unit to a foreign master on a bus of the rig."""
    link = rig.attach("master").link(bus)
    answers: list[str] = []
    link.on_receive(lambda message: answers.append(message.pdu.hex()) if isinstance(message, ModbusResponse) else None)
    link.send(ModbusRequest(unit, bytes.fromhex(pdu), 1))
    rig.run_for(50 * MS)
    rig.detach("master")
    return answers[-1]


def master_of(rig: Branch, bus: str = "labels") -> Ask:
    return lambda unit, pdu: rig.call(asked, bus, unit, pdu)


@pytest.fixture
def rig(fieldrig_branch: BranchMaker) -> Branch:
    """The rig with a hot bar, which is heated once for all tests."""
    return fieldrig_branch(RIG, boot=hot)


@pytest.mark.parametrize("bus", ["labels", "labels_rtu"])
def test_a_master_sets_the_recipe_and_each_feed_has_its_pulses(rig: Branch, bus: str) -> None:
    ask = master_of(rig, bus)
    # 100 mm at 20 kHz with ramps of 100 ms, and 200 ms of sealing
    assert ask(FEEDER, "10 0000 0008 10 000003e8 00004e20 00000064 000000c8") == "1000000008"
    for _ in range(4):
        assert ask(FEEDER, START) == STARTED
        assert ask(FEEDER, "02 0000 0001") == "020101"  # busy
        ask(FEEDER, "05 0000 0000")
        rig.run_for(S)
    assert ask(FEEDER, "04 0000 0004") == "0408" + "00000004" + "00000002"  # feeds, labels at the barrier
    assert rig.get("feeder/PTO00.Position") == 4 * 2_000
    assert rig.get("web/position") == pytest.approx(0.4, abs=1e-6)


def test_requests_of_several_sources_do_not_hide_each_other(rig: Branch) -> None:
    rig.set("feeder/g_bStart", True)  # a master that never takes its request back
    rig.run_for(2 * S)
    rig.set("feeder/panel.key1", True)
    rig.run_for(2 * S)
    assert rig.get("feeder/g_udiFeeds") == 2


def test_a_recipe_beyond_the_limits_of_the_table_is_refused(rig: Branch) -> None:
    ask = master_of(rig)
    assert ask(FEEDER, "10 0002 0002 04 0000c351") == "9004"  # 50001 Hz
    assert rig.get("feeder/g_udiSpeed") == 10_000


def test_a_ramp_that_is_too_short_is_an_error_of_the_block_until_the_reset(rig: Branch) -> None:
    ask = master_of(rig)
    ask(FEEDER, "10 0004 0002 04 00000005")  # 5 ms, below the 20 ms of the channel
    ask(FEEDER, START)
    assert ask(FEEDER, "04 0008 0002") == "0404" + "0003" + "0004"  # PTO_INVALID_PARAMETER, ErrorStop
    assert rig.get("feeder/panel.line1") == "drive error: reset"
    ask(FEEDER, "10 0004 0002 04 000000c8")
    ask(FEEDER, "05 0000 0000")
    ask(FEEDER, "05 0001 ff00")
    assert ask(FEEDER, "02 0001 0001") == "020100"
    ask(FEEDER, START)
    rig.run_for(2 * S)
    assert rig.get("feeder/g_udiFeeds") == 1


def test_a_lost_ready_contact_stops_the_feed(rig: Branch) -> None:
    rig.set("feeder/g_bStart", True)
    rig.run_for(150 * MS)
    rig.add_fault("stepper", {"what": "trip"})
    rig.run_for(S)
    assert (rig.get("feeder/g_bError"), rig.get("feeder/PTO00.State")) == (True, 4)
    assert int(rig.get("feeder/PTO00.Position")) < 2_000


def test_the_bar_follows_its_set_point(rig: Branch) -> None:
    ask = master_of(rig)
    assert ask(SEALER, "06 0000 0708") == "0600000708"  # 180.0 degC
    rig.run_for(50 * S)
    assert rig.get("heater/temperature") == pytest.approx(180.0, abs=1.0)
    assert ask(SEALER, "02 0000 0001") == "020101"
    ask(SEALER, "06 0000 0000")
    rig.run_for(S)
    assert rig.get("heater/power") == 0
    assert rig.get("feeder/panel.line1") == "sealer is heating"


def test_without_heat_there_is_no_feed(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.set("feeder/g_bStart", True)
    rig.run_until(5 * S)
    assert (rig.get("feeder/PTO00.Position"), rig.get("feeder/g_bBusy")) == (0, False)


def test_a_controller_that_was_off_in_the_middle_of_a_feed_comes_back(rig: Branch) -> None:
    """Its pulses end too fast for the motor, so the drive has an alarm after the only reset at power-on; the reset
    stayed on then, and the drive, which takes the edge, was never ready again."""
    rig.set("feeder/g_bStart", True)
    rig.run_for(271 * MS)
    rig.restart("feeder")
    rig.run_for(5 * MS)
    assert rig.get("stepper/alarm")
    rig.until(lambda: rig.get("stepper/ready") and not rig.get("feeder/g_bError"), within=2 * S)
    rig.set("feeder/panel.key1", True)
    rig.run_for(2 * S)
    assert rig.get("feeder/g_udiFeeds") == 1
