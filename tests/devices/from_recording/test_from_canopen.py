"""A rig of a CANopen log: what each kind of traffic becomes.  The bytes are those of CiA 301's protocol pictures."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import canopen
import pytest
from made_rigs import SdoMaster, keys_of, read_by_sdo, recorded, rig_file, virtual, written_log

from fieldrig.clock import MS, S
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.eds.check import check_eds
from fieldrig_devices.cia402 import EDS as DRIVE
from fieldrig_devices.replay import replay

CONFIGS = Path(__file__).parents[3] / "configs"
BOOT = "0 705#00"
STARTED = "0.1 000#0105"
TYPE = read_by_sdo(0.05, 5, "4300100091010F00")


def heard(rig_path: Path, identifier: int, until_ns: int, start: bool = True) -> list[tuple[int, str]]:
    """Return the frames of an identifier in the rig; the node is started after 0.1 s."""
    with virtual(rig_path) as rig:
        frames: list[tuple[int, str]] = []
        can = rig.attach("master").link("can0")
        can.on_receive(lambda frame: frames.append((rig.now_ns, frame.data.hex(" "))), [(identifier, 0x7FF)])
        rig.run_until(100 * MS)
        if start:
            can.send(CanFrame(0, b"\x01\x05"))
        rig.run_until(until_ns)
        return frames


def test_a_heartbeat_has_the_period_of_the_log(tmp_path: Path) -> None:
    log = written_log(tmp_path, BOOT, *(f"{0.25 * beat} 705#7F" for beat in range(1, 20)))
    beats = heard(rig_file(log), 0x705, 1 * S, start=False)
    assert [(round(at / MS), data) for at, data in beats[1:]] == [(250 * beat, "7f") for beat in range(1, 4)]


def test_a_node_begins_with_the_heartbeat_from_before_its_master_set_another(tmp_path: Path) -> None:
    before = [f"{0.2 * beat} 705#7F" for beat in range(1, 8)]
    write = ["1.5 605#2B171000F4010000", "1.501 585#6017100000000000"]
    log = written_log(tmp_path, BOOT, *before, *write, *(f"{1.5 + 0.5 * beat} 705#7F" for beat in range(1, 20)))
    with virtual(rig_file(log)) as running:
        assert running.get("node5/1017:00") == 200


def test_node_guarding_is_told_from_a_heartbeat(tmp_path: Path) -> None:
    guarded = [
        line
        for turn in range(20)
        for line in (f"{0.1 * turn + 0.1} 705#R", f"{0.1 * turn + 0.101} 705#{0x7F | turn % 2 << 7:02X}")
    ]
    rig = rig_file(written_log(tmp_path, BOOT, *guarded))
    assert "node guarding every 100 ms" in rig.read_text()
    with virtual(rig) as running:
        assert (running.get("node5/100C:00"), running.get("node5/1017:00")) == (100, 0)
        frames: list[str] = []
        can = running.attach("master").link("can0")
        running.run_until(10 * MS)
        can.on_receive(lambda frame: frames.append(frame.data.hex()), [(0x705, 0x7FF)])
        for _ in range(2):
            can.send(CanFrame(0x705, is_remote=True, remote_length=1))
            running.run_for(10 * MS)
        assert frames == ["7f", "ff"]


@pytest.mark.parametrize(
    ("lines", "boot_up_ms"),
    [
        (["1 000#8205", "1.25 705#00"], 250),
        (["1 000#8105", "1.25 705#00", "2 000#8200", "2.15 705#00", "3 000#8105", "3.21 705#00"], 210),
        (["1 000#8105", "1.0005 705#00"], 0),
        (["1 705#00"], 0),
    ],
)
def test_a_node_boots_as_long_after_a_reset_as_in_the_log(lines: list[str], boot_up_ms: float, tmp_path: Path) -> None:
    rig = rig_file(written_log(tmp_path, BOOT, *TYPE, *lines))
    assert keys_of(rig)["devices"]["node5"].get("boot_up_ms", 0) == boot_up_ms


@pytest.mark.parametrize(("type_code", "name"), [("9101", "Read analogue input 16-bit"), ("0000", "Object 6401h")])
def test_an_i_o_module_has_the_names_of_its_profile(type_code: str, name: str, tmp_path: Path) -> None:
    """Device type 000F 0191h: profile 401."""
    asked = read_by_sdo(0.05, 5, f"43001000{type_code}0F00"), read_by_sdo(0.1, 5, "4B0164029CFF0000")
    rig = rig_file(written_log(tmp_path, BOOT, *asked[0], *asked[1]))
    described: Any = canopen.import_od(str(rig.parent / "eds/node5.eds"))[0x6401]
    assert (described.name, described[2].name.startswith(f"{name}, ")) == (name, True)


def test_a_node_that_no_command_has_started_starts_by_itself(tmp_path: Path) -> None:
    log = written_log(tmp_path, *(f"{0.1 * beat} 705#05" for beat in range(10)))
    with virtual(rig_file(log)) as rig:
        rig.run_until(10 * MS)
        assert rig.get("node5/nmt.state") == "operational"


@pytest.mark.parametrize(("every", "type"), [(1, 1), (4, 4)])
def test_a_synchronous_pdo_is_told_by_its_place_after_sync(tmp_path: Path, every: int, type: int) -> None:
    lines = [BOOT, STARTED]
    for turn in range(40):
        lines.append(f"{0.2 + 0.01 * turn} 080#")
        lines += [f"{0.2 + 0.01 * turn + 0.0004} 185#{turn:02X}"] if turn % every == 0 else []
    with virtual(rig_file(written_log(tmp_path, *lines))) as rig:
        assert rig.get("node5/1800:02") == type


def test_a_pdo_after_a_sync_with_a_counter_is_sent_again(tmp_path: Path) -> None:
    """CiA 301, 7.5.2.21: a node whose 1019h is 0 takes a SYNC with a counter for a wrong one."""
    lines = ["0.000 705#00", "0.010 000#0105"]
    for number in range(30):
        at_s = 1 + number / 50
        lines += [f"{at_s:.4f} 080#{number % 10 + 1:02X}", f"{at_s + 0.0004:.4f} 185#{number:04X}"]
    path = rig_file(written_log(tmp_path, *lines))
    with virtual(path) as rig:
        assert rig.get("node5/1019:00") == 10
        entries, master = recorded(rig), rig.attach("plc").link("can0")
        rig.run_for(1 * S)
        master.send(CanFrame(0x000, bytes((1, 5))))
        for number in range(12):
            master.send(CanFrame(0x080, bytes((number % 10 + 1,))))
            rig.run_for(20 * MS)
    assert sum(entry.data[:2] == b"\x85\x01" for entry in entries) == 12
    assert not any(entry.data[:2] == b"\x85\x00" for entry in entries)


def test_a_pdo_that_remote_frames_ask_for_is_sent_on_request(tmp_path: Path) -> None:
    lines = ["0.000 705#00", "0.010 000#0105"]
    for number in range(6):
        lines += [f"{1 + number:.4f} 185#R2", f"{1 + number + 0.0005:.4f} 185#{number:02X}00"]
    log = written_log(tmp_path, *lines)
    path = rig_file(log)
    assert "TPDO 1, 185h, 2 bytes: sent when a remote frame asks for it" in path.read_text()
    with virtual(path) as rig:
        assert rig.get("node5/1800:02") == 253
    assert replay(log, path).is_same


def test_the_channel_of_a_second_master_is_no_unknown_identifier(tmp_path: Path) -> None:
    lines = ["0.000 705#00"]
    for number, cob_id in ((1, 0x6A0), (2, 0x6B0)):
        lines += [f"0.{number}00 605#230112{number:02X}{cob_id.to_bytes(4, 'little').hex()}",
                  f"0.{number}01 585#600112{number:02X}00000000"]  # fmt: skip
    lines += ["1.000 6A0#4000200000000000", "1.001 6B0#4B00200005000000"]
    log = written_log(tmp_path, *lines)
    path = rig_file(log)
    assert "no node accounts for" not in path.read_text()
    assert replay(log, path).is_same


def test_a_node_that_is_another_one_later_is_the_first_and_says_so(tmp_path: Path) -> None:
    lines = ["0 704#00", *read_by_sdo(0.1, 4, "4300100091010100"), *read_by_sdo(0.2, 4, "4318100111000000")]
    lines += ["3 704#00", *read_by_sdo(3.1, 4, "4300100092010000"), *read_by_sdo(3.2, 4, "4318100122000000")]
    path = rig_file(written_log(tmp_path, *lines))
    words = " ".join(path.read_text().replace("#", " ").split())
    assert keys_of(path)["devices"]["node4"]["kind"] == "canopen.node"
    assert "node 4: device type 10191h, vendor 11h" in words
    assert "device type 10191h, later 192h; vendor 11h, later 22h; here it is the first" in words
    with virtual(path) as rig:
        assert (rig.get("node4/1000:00"), rig.get("node4/1018:01")) == (0x10191, 0x11)


def test_a_pdo_with_a_timer_is_sent_in_its_period(tmp_path: Path) -> None:
    log = written_log(tmp_path, BOOT, STARTED, *(f"{0.13 + 0.05 * turn} 185#0102" for turn in range(20)))
    sent = heard(rig_file(log), 0x185, 400 * MS)
    distances = {round((later - earlier) / MS) for (earlier, _), (later, _) in pairwise(sent[1:])}
    assert distances == {50}
    assert {data for _, data in sent} == {"01 02"}


def test_a_pdo_of_events_repeats_its_values_at_their_instants(tmp_path: Path) -> None:
    changes = [(0.2, "185#00FF"), (0.27, "185#01FF"), (0.5, "185#02FF"), (0.91, "185#03FF")]
    log = written_log(tmp_path, BOOT, STARTED, *(f"{at} {frame}" for at, frame in changes), "2 705#05")
    sent = heard(rig_file(log), 0x185, 1_900 * MS)
    assert [data for _, data in sent] == ["00 ff", "01 ff", "02 ff", "03 ff"]
    assert [round(at / MS) for at, _ in sent[1:]] == [270, 500, 910]


def test_a_value_that_stays_has_no_column(tmp_path: Path) -> None:
    log = written_log(tmp_path, BOOT, STARTED, *(f"{0.2 + 0.1 * turn} 185#07{turn:02X}" for turn in range(9)))
    assert list(keys_of(rig_file(log))["devices"]["node5"]["sources"]) == ["5800:02"]


MAPPED = [
    *read_by_sdo(0.01, 5, "4F001A0002000000"),
    *read_by_sdo(0.02, 5, "43001A0108010060"),  # 6000h sub-index 1, 8 bits
    *read_by_sdo(0.03, 5, "43001A0210010264"),  # 6402h sub-index 1, 16 bits
]


def test_a_mapping_that_was_read_names_the_objects_of_a_pdo(tmp_path: Path) -> None:
    log = written_log(tmp_path, BOOT, *MAPPED, STARTED, "0.2 185#011027", "0.3 185#02102F", "0.4 185#021030")
    rig = rig_file(log)
    with virtual(rig) as running:
        running.run_until(350 * MS)
        assert (running.get("node5/6000:01"), running.get("node5/6402:01")) == (2, 0x2F10)
    assert [data for _, data in heard(rig, 0x185, 1 * S)][-1] == "02 10 30"


def test_a_mapping_that_was_read_in_part_leaves_the_rest_as_bytes(tmp_path: Path) -> None:
    log = written_log(tmp_path, BOOT, *MAPPED[:4], STARTED, "0.2 185#011027", "0.3 185#02102F")
    with virtual(rig_file(log)) as rig:
        rig.run_until(350 * MS)
        assert (rig.get("node5/6000:01"), rig.get("node5/5800:02")) == (2, 0x2F10)


def test_a_mapping_whose_count_was_not_read_is_filled_up_to_the_length_of_the_frames(tmp_path: Path) -> None:
    log = written_log(tmp_path, BOOT, *MAPPED[2:], STARTED, "0.2 185#0110275A", "0.3 185#02102F5B")
    rig = rig_file(log)
    words = " ".join(rig.read_text().replace("#", "").split())
    assert "the end of its mapping is not known, so the bytes there are 5800h" in words
    with virtual(rig) as running:
        master = SdoMaster(running)
        running.run_until(350 * MS)
        assert [running.get(f"node5/{key}") for key in ("6000:01", "6402:01", "5800:01")] == [2, 0x2F10, 0x5B]
        assert master.read(5, 0x1A00, 1) == "43 00 1a 01 08 01 00 60"


def test_a_node_sends_the_emergencies_of_its_recording_again(tmp_path: Path) -> None:
    """Codes of CiA 301, table 26: two errors one after the other, with bytes of the maker, and their resets."""
    sent_at = ["0.2 085#3081110102030405", "0.4 085#0050310000000000"]
    reset_at = ["0.6 085#0000210000000000", "0.9 085#0000000000000000"]
    rig = rig_file(written_log(tmp_path, BOOT, *TYPE, "0.1 705#7F", *sent_at, *reset_at, "1.5 705#7F"))
    sent = heard(rig, 0x085, 2 * S, start=False)
    assert [(round(at / MS), data) for at, data in sent] == [
        (200, "30 81 11 01 02 03 04 05"), (400, "00 50 31 00 00 00 00 00"),
        (600, "00 00 21 00 00 00 00 00"), (900, "00 00 00 00 00 00 00 00"),
    ]  # fmt: skip


def test_a_drive_sends_the_emergencies_of_its_recording_with_the_bytes_of_its_maker(tmp_path: Path) -> None:
    """The error register has bit 7, manufacturer, besides that of the code 2310h, current."""
    lines = [BOOT, *read_by_sdo(0.05, 5, "4300100092010600"), "0.1 705#7F", "0.2 085#1023830102030405"]
    sent = heard(rig_file(written_log(tmp_path, *lines, "1.5 705#7F")), 0x085, 2 * S, start=False)
    assert [data for _, data in sent] == ["10 23 83 01 02 03 04 05"]


@pytest.mark.parametrize("count", [2, 3])
def test_a_mapping_keeps_its_count_where_some_objects_were_not_read(tmp_path: Path, count: int) -> None:
    """Five bytes: one is known, and the others share the rest."""
    read = [*read_by_sdo(0.01, 5, f"4F001A000{count}000000"), *read_by_sdo(0.02, 5, "43001A0108010060")]
    rig = rig_file(written_log(tmp_path, BOOT, *read, STARTED, "0.2 185#0110270000", "0.3 185#02102F0001"))
    with virtual(rig) as running:
        master = SdoMaster(running)
        running.run_until(10 * MS)
        assert master.read(5, 0x1A00) == f"4f 00 1a 00 0{count} 00 00 00"
        assert master.read(5, 0x1A00, 1) == "43 00 1a 01 08 01 00 60"
    assert [data for _, data in heard(rig, 0x185, 350 * MS)][-1] == "02 10 2f 00 01"


def test_a_mapping_that_was_not_read_to_its_end_and_of_which_no_frame_came_is_told(tmp_path: Path) -> None:
    read = [*read_by_sdo(0.01, 5, "4F001A0004000000"), *read_by_sdo(0.02, 5, "43001A0108010060")]
    rig = rig_file(written_log(tmp_path, BOOT, *read))
    text = " ".join(rig.read_text().replace("#", " ").split())
    assert "the objects that 1A00h maps, as not all of them were read: a byte for each of the others here" in text
    with virtual(rig) as running:
        running.run_until(10 * MS)
        assert SdoMaster(running).read(5, 0x1A00) == "4f 00 1a 00 04 00 00 00"


@pytest.mark.parametrize("first", ["43001A0140010060", "43001A0100010060"])
def test_a_mapping_that_has_no_room_for_the_objects_that_were_not_read_maps_none(tmp_path: Path, first: str) -> None:
    """The first of its objects takes the whole PDO, or is none."""
    read = [*read_by_sdo(0.01, 5, "4F001A0004000000"), *read_by_sdo(0.02, 5, first)]
    text = " ".join(rig_file(written_log(tmp_path, BOOT, *read)).read_text().replace("#", " ").split())
    assert "the objects that 1A00h maps, as not all of them were read: it maps none at power-on" in text


def test_a_node_that_refuses_pdos_for_their_length_keeps_its_mapping(tmp_path: Path) -> None:
    """Its master sends two bytes of four, and the node reports 8210h (CiA 301, 7.2.7.1)."""
    mapped = [line for place in range(1, 5)
              for line in read_by_sdo(0.02 + place / 100, 5, f"430016{place:02X}08{place:02X}0062")]  # fmt: skip
    read = [*read_by_sdo(0.01, 5, "4F00160004000000"), *mapped]
    rig = rig_file(written_log(tmp_path, BOOT, *read, STARTED, "0.2 205#0102", "0.201 085#1082110204000000"))
    assert "faults" not in keys_of(rig)["devices"]["node5"]
    with virtual(rig) as running:
        master, log = SdoMaster(running), recorded(running)
        running.run_until(150 * MS)
        assert master.read(5, 0x1600) == "4f 00 16 00 04 00 00 00"
        master.can.send(CanFrame(0, b"\x01\x05"))
        master.can.send(CanFrame(0x205, b"\x01\x02"))
        running.run_for(50 * MS)
    emergencies = [entry.data[4:].hex() for entry in log if entry.data[:2] == b"\x85\x00"]
    assert [data[2:6] for data in emergencies] == ["1082"]


def test_a_mapping_of_which_only_the_count_was_read_is_the_written_one(tmp_path: Path) -> None:
    lines = [
        *read_by_sdo(0.01, 5, "4F001A0008000000"),  # eight objects, of which no master has asked
        "0.02 605#2F001A0000000000", "0.021 585#60001A0000000000",
        "0.03 605#23001A0120000020", "0.031 585#60001A0100000000",  # 2000h, 32 bits
        "0.04 605#2F001A0001000000", "0.041 585#60001A0000000000",
    ]  # fmt: skip
    rig = rig_file(written_log(tmp_path, BOOT, *lines, STARTED, "0.2 185#01000000", "0.3 185#02000000"))
    assert [finding for finding in check_eds(rig.parent / "eds/node5.eds") if finding.is_refused] == []
    assert [data for _, data in heard(rig, 0x185, 350 * MS)][-1] == "02 00 00 00"


@pytest.mark.parametrize("cob_id", [0x185, 0x8000_0185])
def test_a_node_that_let_its_master_map_a_valid_pdo_does_so_again(cob_id: int, tmp_path: Path) -> None:
    requests = [
        f"23001801{cob_id.to_bytes(4, 'little').hex()}", "2F001A0000000000", "23001A0120000020", "2F001A0001000000",
        "2300180185010000",
    ]  # fmt: skip
    lines = [
        line
        for place, request in enumerate(requests)
        for line in (f"0.0{place} 605#{request}", f"0.0{place}1 585#60{request[2:8]}00000000")
    ]
    rig = rig_file(written_log(tmp_path, BOOT, *lines, STARTED, "0.2 185#01000000", "0.3 185#02000000"))
    keys = keys_of(rig)["devices"]["node5"]
    assert keys.get("maps_while_valid", False) == (cob_id == 0x185)
    with virtual(rig) as running:
        master = SdoMaster(running)
        running.run_until(10 * MS)
        assert [master.ask(5, request)[:2] for request in requests] == ["60"] * 5


def test_a_pdo_on_an_identifier_of_its_own_belongs_to_its_node(tmp_path: Path) -> None:
    moved = read_by_sdo(0.04, 5, "4300180133030040")
    log = written_log(tmp_path, BOOT, *moved, STARTED, *(f"{0.2 + turn / 10} 333#{turn:02X}" for turn in range(5)))
    sent = heard(rig_file(log), 0x333, 650 * MS)
    assert list(dict.fromkeys(data for _, data in sent)) == ["00", "01", "02", "03", "04"]


def test_objects_have_size_value_and_access_of_the_log(tmp_path: Path) -> None:
    lines = [
        *TYPE,
        *read_by_sdo(0.1, 5, "4B002000D2040000"),  # 2000h = 1234, two bytes
        "0.2 605#2F01200007000000", "0.201 585#6001200000000000",  # 2001h := 7, one byte
    ]  # fmt: skip
    with virtual(rig_file(written_log(tmp_path, BOOT, *lines))) as rig:
        master = SdoMaster(rig)
        rig.run_until(10 * MS)
        assert master.read(5, 0x1000) == "43 00 10 00 91 01 0f 00"
        assert master.read(5, 0x2000) == "4b 00 20 00 d2 04 00 00"
        assert master.read(5, 0x2001) == "4f 01 20 00 07 00 00 00"
        assert master.write(5, 0x2001, 0, 9, 1) == "60 01 20 00 00 00 00 00"
        assert master.write(5, 0x2000, 0, 9, 2) == "80 00 20 00 02 00 01 06"  # read-only


def test_a_text_in_segments_is_a_text(tmp_path: Path) -> None:
    name = [
        "0.1 605#4008100000000000", "0.101 585#4108100006000000",
        "0.102 605#6000000000000000", "0.103 585#0350756D70203100",
    ]  # fmt: skip
    with virtual(rig_file(written_log(tmp_path, BOOT, *name))) as rig:
        assert rig.get("node5/1008:00") == "Pump 1"


def test_an_object_whose_transfer_was_broken_off_exists(tmp_path: Path) -> None:
    broken = ["0.1 605#4000200000000000", "0.101 585#4100200011000000", *read_by_sdo(0.2, 5, "4300100091010F00")]
    rig = rig_file(written_log(tmp_path, BOOT, *broken))
    assert "the content of 2000:00: its transfer was not finished" in rig.read_text()
    with virtual(rig) as running:
        master = SdoMaster(running)
        running.run_until(10 * MS)
        assert master.read(5, 0x2000) == "41 00 20 00 11 00 00 00"


def test_the_first_value_counts_where_a_master_wrote_another_one(tmp_path: Path) -> None:
    lines = [*read_by_sdo(0.1, 5, "4B00200001000000"), "0.2 605#2B00200005000000", "0.201 585#6000200000000000"]
    rig = rig_file(written_log(tmp_path, BOOT, *lines))
    assert "written after it was read: 2000:00" in rig.read_text()
    with virtual(rig) as running:
        assert running.get("node5/2000:00") == 1


@pytest.mark.parametrize(
    ("request_", "abort"),
    [
        ("4000200000000000", "8000200000000206"),  # reading: no such object
        ("4018100900000000", "8018100911000906"),  # reading: no such sub-index
        ("4010200000000000", "8010200022000008"),  # reading: device state
        ("2F00100001000000", "8000100002000106"),  # writing: read-only
        ("2311200001000000", "8011200030000906"),  # writing: invalid value
    ],
)
def test_a_refusal_has_the_abort_code_of_the_log(tmp_path: Path, request_: str, abort: str) -> None:
    identity = read_by_sdo(0.03, 5, "4318100107000000")
    log = written_log(tmp_path, BOOT, *TYPE, *identity, f"0.2 605#{request_}", f"0.201 585#{abort}")
    with virtual(rig_file(log)) as rig:
        master = SdoMaster(rig)
        rig.run_until(10 * MS)
        assert master.ask(5, request_) == bytes.fromhex(abort).hex(" ")


def test_a_limit_explains_values_that_were_refused(tmp_path: Path) -> None:
    lines = [
        "0.1 605#2B00200064000000", "0.101 585#6000200000000000",  # 100 is accepted
        "0.2 605#2B002000E8030000", "0.201 585#8000200031000906",  # 1000 is too high
        "0.3 605#2B00200001000000", "0.301 585#8000200032000906",  # 1 is too low
    ]  # fmt: skip
    with virtual(rig_file(written_log(tmp_path, BOOT, *lines))) as rig:
        master = SdoMaster(rig)
        rig.run_until(10 * MS)
        answers = [master.write(5, 0x2000, 0, value, 2)[:2] + master.write(5, 0x2000, 0, value, 2)[-12:]
                   for value in (1, 2, 100, 999, 1000)]  # fmt: skip
    assert answers == ["80 32 00 09 06", *["60 00 00 00 00"] * 3, "80 31 00 09 06"]


def test_values_that_moved_are_replayed_and_those_that_a_master_wrote_are_not(tmp_path: Path) -> None:
    lines = [line for turn in range(5) for line in read_by_sdo(0.1 + turn, 5, f"4B002000{turn:02X}000000")]
    lines += ["5.2 605#2B00210005000000", "5.201 585#6000210000000000", *read_by_sdo(5.3, 5, "4B00210005000000")]
    rig = rig_file(written_log(tmp_path, BOOT, *lines))
    with virtual(rig) as running:
        master = SdoMaster(running)
        values = []
        for turn in range(5):
            running.run_until(100 * MS + turn * S)
            values.append(master.read(5, 0x2000))
        assert values == [f"4b 00 20 00 0{turn} 00 00 00" for turn in range(5)]
    assert list(keys_of(rig)["devices"]["node5"]["sources"]) == ["2000:00"]


def test_a_node_that_was_reset_counts_from_its_reset(tmp_path: Path) -> None:
    before = [line for turn in range(3) for line in read_by_sdo(0.1 + turn, 5, f"4B002000{turn + 90:02X}000000")]
    after = [line for turn in range(3) for line in read_by_sdo(5.1 + turn, 5, f"4B002000{turn:02X}000000")]
    log = written_log(tmp_path, BOOT, *before, "5 000#8105", "5.0 705#00", *after)
    with virtual(rig_file(log)) as rig:
        master = SdoMaster(rig)
        rig.run_until(5 * S)
        master.can.send(CanFrame(0, b"\x81\x05"))
        rig.run_until(7_100 * MS)
        assert master.read(5, 0x2000) == "4b 00 20 00 02 00 00 00"


def test_an_eds_of_1021h_describes_the_node(tmp_path: Path) -> None:
    eds = CONFIGS / "eds/level-sensor.eds"
    data = eds.read_bytes()
    lines = ["0.1 606#4021100000000000", f"0.101 586#41211000{len(data).to_bytes(4, 'little').hex()}"]
    for place in range(0, len(data), 7):
        part, toggle = data[place : place + 7], 0x10 * (place // 7 % 2)
        head = toggle | 7 - len(part) << 1 | (place + 7 >= len(data))
        lines += [
            f"0.2 606#{0x60 | toggle:02X}00000000000000",
            f"0.2 586#{bytes((head, *part)).ljust(8, bytes(1)).hex()}",
        ]
    rig = rig_file(written_log(tmp_path, "0 706#00", *lines))
    assert (rig.parent / "eds/node6.eds").read_bytes() == data


def test_the_written_eds_has_no_findings(tmp_path: Path) -> None:
    guard = ["0.3 705#R", "0.301 705#7F", "0.4 705#R", "0.401 705#FF"]
    log = written_log(
        tmp_path, BOOT, *TYPE, *MAPPED, *guard, STARTED, "0.5 185#010203", "0.6 205#01", "0.7 085#3081110000000000"
    )
    assert list(check_eds(rig_file(log).parent / "eds/node5.eds")) == []


def test_a_file_of_the_maker_fills_what_is_not_known(tmp_path: Path) -> None:
    eds = CONFIGS / "eds/level-sensor.eds"
    lines = ["0 706#00", *read_by_sdo(0.1, 6, "4300100094010200"), *read_by_sdo(0.2, 6, "4B171000E8030000")]
    rig = rig_file(written_log(tmp_path, *lines, "1.2 706#7F"), str(eds))
    with virtual(rig) as running:
        assert running.get("node6/1017:00") == 1000
        assert running.get("node6/1008:00") == "Level sensor"


def test_the_bit_rate_is_that_of_frames_without_a_gap(tmp_path: Path) -> None:
    # a frame without data and stuff bits has 47 bits with its intermission; 555h has no stuff bits in its identifier
    lines = [BOOT] + [f"{1 + turn * 47 / 250_000:.6f} 555#" for turn in range(40)]
    rig = rig_file(written_log(tmp_path, *lines))
    assert keys_of(rig)["buses"]["can0"]["bitrate"] in (125_000, 250_000, 500_000)


def test_python_canopen_reads_the_written_eds(tmp_path: Path) -> None:
    lines = [BOOT, *TYPE, *MAPPED, STARTED, "0.2 185#011027", "0.3 185#02102F", "0.4 205#0102"]
    text = ["0.5 605#4008100000000000", "0.501 585#4208100050756D70"]
    eds = rig_file(written_log(tmp_path, *lines, *text)).parent / "eds/node5.eds"
    dictionary: Any = canopen.import_od(str(eds), node_id=5)
    assert dictionary[0x1000].default == 0x000F0191
    assert dictionary[0x1008].default == "Pump"
    assert dictionary[0x1800][1].default == 0x185
    assert dictionary[0x1A00][2].default == 0x64020110
    assert (dictionary[0x6402][1].data_type, dictionary[0x6402][1].pdo_mappable) == (0x06, True)
    assert [dictionary[0x1600][entry].default for entry in range(3)] == [2, 0x54000108, 0x54000208]


def test_a_drive_with_the_file_of_its_maker_keeps_it(tmp_path: Path) -> None:
    words = [line for turn in range(4) for line in read_by_sdo(1 + turn, 3, "4B41600050060000")]
    log = written_log(tmp_path, "0 703#00", *read_by_sdo(0.5, 3, "4300100092010200"), *words)
    rig = rig_file(log, f"3={DRIVE}")
    assert keys_of(rig)["devices"]["node3"]["kind"] == "cia402.drive"
    assert (rig.parent / "eds" / DRIVE.name).read_bytes() == DRIVE.read_bytes()
    with virtual(rig) as running:
        assert running.get("node3/6083:00") == 10_000_000


@pytest.mark.parametrize(
    ("words", "lost"),
    [
        ((0x0240, 0x0240, 0x0250), [{"what": "mains_lost", "duration_ms": 3000}]),
        ((0x0240, 0x0240, 0x0240), [{"what": "mains_lost"}]),
        ((0x0240, 0x0240), None),  # too few to say it
        ((0x0240, 0x0221, 0x0221), None),
        ((0x0240, 0x0240, 0x0237), None),
        ((0x0250, 0x0250), None),
    ],
)
def test_a_drive_has_its_mains_when_it_had_them(tmp_path: Path, words: tuple[int, ...], lost: object) -> None:
    """Bit 4 is "voltage enabled"; a drive that sets it with the enabled state says nothing of its mains."""
    read = [
        line
        for turn, word in enumerate(words)
        for line in read_by_sdo(1 + turn, 3, f"4B416000{word.to_bytes(2, 'little').hex()}0000")
    ]
    keys = keys_of(rig_file(written_log(tmp_path, "0 703#00", *read_by_sdo(0.5, 3, "4300100092010200"), *read)))
    assert keys["devices"]["node3"].get("faults") == lost


@pytest.mark.parametrize(("first_s", "runs"), [(0.1, True), (2, False)])
def test_a_node_that_sends_before_it_is_started_runs_by_itself(tmp_path: Path, first_s: float, runs: bool) -> None:
    sent = [f"{first_s + turn / 10:.1f} 185#01" for turn in range(9)]
    started = "1.5 000#0100"
    rig = rig_file(
        written_log(
            tmp_path, "0.01 605#4000100000000000", *sorted([started, *sent], key=lambda line: float(line.split()[0]))
        )
    )
    assert ("it starts by itself (1F80h)" in rig.read_text()) == runs


@pytest.mark.parametrize(("boot_s", "runs"), [(0.05, True), (0.35, False)])
def test_a_node_that_boots_and_sends_before_it_is_started_runs_by_itself(
    tmp_path: Path, boot_s: float, runs: bool
) -> None:
    """PDOs before the boot-up are of a node that was on."""
    lines = [f"{boot_s} 705#00", *(f"{0.1 + turn / 10:.1f} 185#01" for turn in range(9)), "1.5 000#0100"]
    rig = rig_file(written_log(tmp_path, *sorted(lines, key=lambda line: float(line.split()[0]))))
    assert ("it starts by itself (1F80h)" in rig.read_text()) == runs


def test_time_that_jumps_back_is_no_negative_time(tmp_path: Path) -> None:
    asked = ["2 603#4041600000000000", "1.5 583#4B41600050060000"] * 3
    rig = rig_file(written_log(tmp_path, "0 703#00", *read_by_sdo(0.5, 3, "4300100092010200"), *asked))
    assert "the time jumps back" in " ".join(rig.read_text().split())
    with virtual(rig) as running:
        running.run_until(100 * MS)


def test_axes_of_one_node_stay_a_node_that_replays(tmp_path: Path) -> None:
    lines = [
        *read_by_sdo(0.5, 3, "4300100092010200"),
        *read_by_sdo(0.6, 3, "4B41600050060000"),
        *read_by_sdo(0.7, 3, "4B41680050060000"),
    ]
    rig = rig_file(written_log(tmp_path, "0 703#00", *lines))
    assert keys_of(rig)["devices"]["node3"]["kind"] == "canopen.node"
    assert "node 3 has several axes" in rig.read_text()


def test_two_files_of_one_name_are_both_there(tmp_path: Path) -> None:
    """Makers call every file `device.eds`."""
    files = []
    for name in ("io32", "level-sensor"):
        file = tmp_path / name / "device.eds"
        file.parent.mkdir()
        file.write_bytes((CONFIGS / f"eds/{name}.eds").read_bytes())
        files.append(file)
    rig = rig_file(written_log(tmp_path, "0 705#00", "0.1 706#00"), f"5={files[0]}", f"6={files[1]}")
    with virtual(rig) as running:
        assert [running.get(f"node{node_id}/1008:00") for node_id in (5, 6)] == ["IO32", "Level sensor"]
