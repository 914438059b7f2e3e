"""python canopen, a CANopen master that is not ours, on the running lab."""

import struct
from itertools import pairwise
from statistics import median

import pytest
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError
from lab_masters import (
    BOOT_UP,
    IO,
    OPERATIONAL,
    PRE_OPERATIONAL,
    SENSOR,
    STOPPED,
    CanopenMaster,
    Heard,
    Pump,
    canopen_master,
    socketcand,
    until_last,
)
from lab_process import LabProcess
from running_rig import until

pytestmark = pytest.mark.real


def count(heard: list[Heard], at_least: int) -> None:
    until(lambda: len(heard) >= at_least)


def period_s(heard: list[Heard]) -> float:
    """The median period of the messages, as the host may be busy during some of them."""
    return median(second.time_s - first.time_s for first, second in pairwise(heard))


# SDO


def test_scanner_finds_the_two_nodes(master: CanopenMaster) -> None:
    master.network.scanner.search()
    until(lambda: len(master.network.scanner.nodes) >= 2)
    assert sorted(master.network.scanner.nodes) == [IO, SENSOR]


def test_nodes_say_what_they_are(master: CanopenMaster) -> None:
    assert master.io.sdo[0x1000].raw == 0x000F0191  # CiA 401, digital and analog
    assert master.io.sdo[0x1008].raw == "IO32"  # four bytes: expedited
    assert master.sensor.sdo[0x1000].raw == 0x00020194  # CiA 404
    assert master.sensor.sdo["Manufacturer device name"].raw == "Level sensor"  # twelve: segmented


def test_numbers_of_every_size_are_written_and_read(master: CanopenMaster) -> None:
    for index, subindex, value in ((0x6200, 1, 0xA5), (0x6411, 2, -12345), (0x6426, 1, 0xFEDCBA98)):
        variable = master.io.sdo[index][subindex]
        variable.raw = value
        assert variable.raw == value
    master.sensor.sdo[0x6149][1].raw = 12.5
    assert master.sensor.sdo[0x6149][1].raw == 12.5


def test_a_text_is_downloaded_in_segments_and_kept_until_reset(master: CanopenMaster) -> None:
    tag = master.sensor.sdo["Tag"]
    assert tag.raw == "LT-101"
    for text in ("a tag of more than seven bytes", "1234567", "12345678", "x"):
        tag.raw = text
        assert tag.raw == text
    master.reset()
    assert tag.raw == "LT-101"


@pytest.mark.parametrize(
    ("index", "subindex", "data", "code"),
    [
        (0x5FFF, 0, "00", 0x0602_0000),  # no such object
        (0x6200, 5, "00", 0x0609_0011),  # no such sub-index
        (0x1000, 0, "00000000", 0x0601_0002),  # read only
        (0x6200, 1, "0000", 0x0607_0012),  # too long
        (0x1017, 0, "00", 0x0607_0013),  # too short
        (0x1029, 1, "03", 0x0609_0031),  # above its limit
        (0x1003, 0, "01", 0x0609_0030),  # 7.5.2.4: only 0 may be written
    ],
)
def test_what_may_not_be_is_aborted_with_its_code(
    master: CanopenMaster, index: int, subindex: int, data: str, code: int
) -> None:
    with pytest.raises(SdoAbortedError) as abort:
        master.io.sdo.download(index, subindex, bytes.fromhex(data))
    assert abort.value.code == code


# NMT, boot-up, heartbeat


def test_reset_boots_the_node_and_leaves_it_pre_operational(master: CanopenMaster) -> None:
    beats = master.listen(0x700 + IO)
    master.io.sdo[0x6200][1].raw = 0xA5
    for command in ("RESET", "RESET COMMUNICATION"):
        beats.clear()
        master.io.nmt.state = command
        count(beats, 2)  # the next one a second later
        assert [beat.data for beat in beats[:2]] == [BOOT_UP, PRE_OPERATIONAL]
    assert master.io.sdo[0x6200][1].raw == 0


def test_reset_of_communication_keeps_the_application(master: CanopenMaster) -> None:
    master.io.sdo[0x6200][1].raw = 0xA5
    master.io.sdo[0x1017].raw = 100
    beats = master.listen(0x700 + IO)
    master.io.nmt.state = "RESET COMMUNICATION"
    until(lambda: BOOT_UP in [beat.data for beat in beats])
    assert master.io.sdo[0x6200][1].raw == 0xA5
    assert master.io.sdo[0x1017].raw == 1000  # as the rig file has it


def test_states_follow_the_master_and_are_reported_by_heartbeat(master: CanopenMaster) -> None:
    master.io.sdo[0x1017].raw = 50
    beats = master.listen(0x700 + IO)
    for wish, state in (
        ("OPERATIONAL", OPERATIONAL),
        ("STOPPED", STOPPED),
        ("OPERATIONAL", OPERATIONAL),
        ("PRE-OPERATIONAL", PRE_OPERATIONAL),
    ):
        master.io.nmt.state = wish
        until_last(beats, state)
        assert master.io.nmt.state == wish


def test_one_node_is_started_and_the_other_is_not(master: CanopenMaster) -> None:
    master.start(master.io)
    master.sensor.sdo[0x1017].raw = 50
    beats = master.listen(0x700 + SENSOR)
    count(beats, 2)
    assert beats[-1].data == PRE_OPERATIONAL


def test_stopped_node_answers_no_sdo(master: CanopenMaster) -> None:
    master.start(master.io)
    master.io.nmt.state = "STOPPED"
    master.io.sdo.RESPONSE_TIMEOUT = 0.2
    with pytest.raises(SdoCommunicationError):
        master.io.sdo.upload(0x1000, 0)
    assert master.sensor.sdo[0x1000].raw == 0x00020194
    master.io.nmt.state = "PRE-OPERATIONAL"
    assert master.io.sdo[0x1000].raw == 0x000F0191


def test_heartbeat_keeps_its_period(master: CanopenMaster) -> None:
    beats = master.listen(0x700 + IO)
    master.io.sdo[0x1017].raw = 100
    count(beats, 11)
    assert period_s(beats[-11:]) == pytest.approx(0.1, abs=0.02)


def test_heartbeat_is_off_at_zero(master: CanopenMaster) -> None:
    master.io.sdo[0x1017].raw = 0
    io, sensor = master.listen(0x700 + IO), master.listen(0x700 + SENSOR)
    master.sensor.sdo[0x1017].raw = 50
    count(sensor, 25)  # longer than the io node's second
    assert io == []


# PDO


def test_mapping_is_read_from_the_nodes(master: CanopenMaster) -> None:
    for node in (master.io, master.sensor):
        node.tpdo.read()
    master.io.rpdo.read()
    assert [variable.name for variable in master.io.tpdo[2]] == [
        f"Read analogue input 16-bit.Analogue input {channel}" for channel in (1, 2, 3, 4)
    ]
    assert (master.io.rpdo[1].cob_id, master.io.rpdo[2].cob_id) == (0x205, 0x305)
    assert (master.io.tpdo[1].cob_id, master.io.tpdo[2].cob_id) == (0x185, 0x285)
    assert [variable.length for variable in master.io.rpdo[1]] == [8, 8, 8, 8]
    assert [variable.index for variable in master.sensor.tpdo[1]] == [0x9130, 0x6150]


def test_rpdo_opens_the_outlet_and_a_modbus_master_sees_the_tank_drain(master: CanopenMaster, pump: Pump) -> None:
    before_mm = pump.level_mm
    master.io.rpdo.read()
    outputs = master.io.rpdo[2]
    outputs["Write analogue output 16-bit.Analogue output 1"].raw = 10_000  # 100 %
    master.start(master.io)
    outputs.transmit()
    until(lambda: pump.level_mm <= before_mm - 5)
    assert master.io.sdo[0x6411][1].raw == 10_000


def test_rpdo_counts_only_in_operational(master: CanopenMaster) -> None:
    master.send(0x205, "11 22 33 44")
    assert master.io.sdo[0x6200][1].raw == 0
    master.start(master.io)
    master.send(0x205, "11 22 33 44")
    assert [master.io.sdo[0x6200][byte].raw for byte in (1, 2, 3, 4)] == [0x11, 0x22, 0x33, 0x44]


def test_sdo_opens_the_outlet_too(master: CanopenMaster, pump: Pump) -> None:
    before_mm = pump.level_mm
    master.io.sdo[0x6411][1].raw = 10_000
    until(lambda: pump.level_mm <= before_mm - 3)


def test_stopping_the_node_closes_the_outlet(lab: LabProcess, master: CanopenMaster) -> None:
    master.start(master.io)
    master.io.sdo[0x6411][1].raw = 5_000
    until(lambda: lab.get("tank/outlet") == 50)
    master.io.nmt.state = "STOPPED"  # 6443h and 6444h: the error value is 0
    until(lambda: lab.get("tank/outlet") == 0)
    master.io.nmt.state = "OPERATIONAL"
    until(lambda: lab.get("tank/outlet") == 50)


def test_rpdo_of_type_0_waits_for_sync(master: CanopenMaster) -> None:
    master.io.rpdo.read()
    outputs = master.io.rpdo[1]
    outputs.trans_type = 0
    outputs.save()
    master.start(master.io)
    master.send(0x205, "11 22 33 44")
    assert master.io.sdo[0x6200][1].raw == 0
    master.network.sync.transmit()
    assert master.io.sdo[0x6200][1].raw == 0x11


def test_modbus_master_starts_the_pump_and_tpdos_tell_the_level(master: CanopenMaster, pump: Pump) -> None:
    master.io.sdo[0x6423].raw = True  # analog events are off by default (CiA 401)
    events = master.listen(0x280 + IO)
    measured = master.listen(0x180 + SENSOR)
    master.start(master.io, master.sensor)
    pump.run(100)
    until(lambda: len(events) > 8 and len(measured) > 2)
    levels = [struct.unpack("<h", pdo.data[:2])[0] for pdo in events]
    assert levels == sorted(levels)
    assert levels[-1] > 5000
    level_mm, status = struct.unpack("<iB", measured[-1].data)
    assert 500 < level_mm < 2000
    assert status == 0
    speed = (levels[-1] - levels[1]) * 1e-4 / (events[-1].time_s - events[1].time_s)
    assert speed == pytest.approx(0.004, rel=0.3)  # 1 l/s into 0.25 m2


def test_high_level_alarm_reaches_both_masters(lab: LabProcess, master: CanopenMaster, pump: Pump) -> None:
    lab.set("tank/level", 1.795)
    inputs = master.listen(0x180 + IO)
    master.start(master.io)
    pump.run(100)
    until(lambda: bool(inputs) and inputs[-1].data[0] & 1 == 1)
    assert master.io.sdo[0x6000][1].raw & 1
    until(lambda: lab.get("drive/high_level"))


@pytest.mark.parametrize("every", [1, 3])
def test_tpdo_comes_with_every_nth_sync(master: CanopenMaster, every: int) -> None:
    master.io.tpdo.read()
    pdo = master.io.tpdo[2]
    pdo.trans_type = every
    pdo.save()
    master.start(master.io)
    heard = master.listen(0x280 + IO)
    for _ in range(6):
        master.network.sync.transmit()
    assert master.io.sdo[0x1000].raw == 0x000F0191  # behind the SYNCs on the same bus
    count(heard, 6 // every)
    assert len(heard) == 6 // every
    assert struct.unpack("<4h", heard[-1].data)[0] == pytest.approx(5000, abs=10)


def test_tpdo_of_type_0_comes_with_the_sync_after_a_change(lab: LabProcess, master: CanopenMaster) -> None:
    master.io.tpdo.read()
    pdo = master.io.tpdo[2]
    pdo.trans_type = 0
    pdo.save()
    master.io.sdo[0x6423].raw = True
    master.start(master.io)
    heard = master.listen(0x280 + IO)
    master.network.sync.transmit()
    master.io.sdo.upload(0x1000, 0)
    heard.clear()
    master.network.sync.transmit()
    master.io.sdo.upload(0x1000, 0)
    assert heard == []
    lab.set("tank/level", 0.75)
    until(lambda: master.io.sdo[0x6401][1].raw == 7500)
    assert heard == []
    master.network.sync.transmit()
    count(heard, 1)
    assert heard[0].data[:2] == struct.pack("<h", 7500)


def test_event_timer_sends_a_tpdo_without_event(master: CanopenMaster) -> None:
    master.io.tpdo.read()
    pdo = master.io.tpdo[1]
    pdo.event_timer = 50
    pdo.save()
    heard = master.listen(0x180 + IO)
    master.start(master.io)
    count(heard, 12)
    assert period_s(heard[-11:]) == pytest.approx(0.05, abs=0.02)


def test_mapping_is_changed_by_the_master(lab: LabProcess, master: CanopenMaster) -> None:
    lab.set("tank/level", 0.15)
    master.io.tpdo.read()
    pdo = master.io.tpdo[1]
    pdo.clear()
    pdo.add_variable(0x6401, 1)
    pdo.add_variable(0x6000, 1)
    pdo.trans_type = 1
    pdo.enabled = True
    pdo.save()
    master.start(master.io)
    heard = master.listen(0x180 + IO)
    master.network.sync.transmit()
    count(heard, 1)
    assert heard[0].data == struct.pack("<hB", 1500, 0b10)  # the low switch


def test_output_is_not_mapped_for_transmission(master: CanopenMaster) -> None:
    master.io.tpdo.read()
    pdo = master.io.tpdo[1]
    pdo.clear()
    pdo.add_variable(0x6200, 1)  # rww: mapped to be received only (CiA 306)
    with pytest.raises(SdoAbortedError) as abort:
        pdo.save()
    assert abort.value.code == 0x0604_0041


# EMCY


def test_short_rpdo_is_an_emergency_that_a_right_one_ends(master: CanopenMaster) -> None:
    master.start(master.io)
    master.send(0x205, "11")
    emergency = master.io.emcy.wait(0x8210, timeout=10)
    assert emergency is not None
    assert (emergency.register, bytes(emergency.data[:2])) == (0x11, b"\x01\x04")
    assert master.io.sdo[0x1001].raw == 0x11
    assert master.io.sdo[0x1003][1].raw & 0xFFFF == 0x8210
    master.send(0x205, "11 22 33 44")
    until(lambda: not master.io.emcy.active)
    assert master.io.sdo[0x1001].raw == 0
    assert master.io.sdo[0x6200][1].raw == 0x11
    master.io.sdo[0x1003][0].raw = 0
    assert master.io.sdo[0x1003][0].raw == 0


def test_lost_heartbeat_of_the_master_is_an_emergency(lab: LabProcess, master: CanopenMaster) -> None:
    master.io.sdo[0x1016][1].raw = 0x7F << 16 | 200
    master.start(master.io)
    master.io.sdo[0x6411][1].raw = 5_000
    until(lambda: lab.get("tank/outlet") == 50)
    master.send(0x77F, "05")
    emergency = master.io.emcy.wait(0x8130, timeout=10)
    assert emergency is not None
    assert emergency.register == 0x11
    until(lambda: lab.get("tank/outlet") == 0)
    assert master.io.nmt.wait_for_heartbeat(timeout=10) == "PRE-OPERATIONAL"  # 1029h: the default


# Several masters


def test_two_masters_work_at_once_and_hear_each_other(lab: LabProcess, master: CanopenMaster) -> None:
    with canopen_master(socketcand(lab)) as second:
        asked, answered = second.listen(0x600 + IO), second.listen(0x580 + IO)
        assert master.io.sdo[0x1000].raw == 0x000F0191
        count(answered, 1)
        assert asked[0].data[:4] == bytes.fromhex("40 00 10 00")
        assert answered[0].data == bytes.fromhex("43 00 10 00 91 01 0f 00")
        assert second.sensor.sdo[0x1008].raw == "Level sensor"
