"""Each fault of a CANopen node, by the frames of CiA 301: SDO (7.2.4.3), boot-up and heartbeat (7.2.8), PDO (7.2.2)."""

from typing import Any

import pytest
from canopen_bench import CanopenBench

ASK_1000 = "40 00 10 00 00 00 00 00"
ASK_NAME = "40 08 10 00 00 00 00 00"
SEGMENT_0, SEGMENT_1 = "60 00 00 00 00 00 00 00", "70 00 00 00 00 00 00 00"
WRITE_1017 = "2B 17 10 00 32 00 00 00"


def bench(*faults: dict[str, Any], **settings: Any) -> CanopenBench:
    made = CanopenBench(objects={"1008:00": "a name of 19 bytes.", **settings})
    made.take()
    for fault in faults:
        made.node.add_fault(fault)
    return made


def test_a_transfer_is_aborted_with_the_code_and_nothing_is_done() -> None:
    at = bench({"what": "sdo_abort", "index": 0x1017, "code": 0x0800_0021, "count": 1})
    assert at.sdo(WRITE_1017) == "80 17 10 00 21 00 00 08"
    assert at.sdo("40 17 10 00 00 00 00 00")[:14] == "4b 17 10 00 00"
    assert at.sdo(WRITE_1017)[:2] == "60"
    assert at.node.faults()[1]["applied"] == 1


def test_segment_2_of_the_next_upload_of_1008h() -> None:
    at = bench({"what": "sdo_abort", "index": "0x1008", "transfer": "upload", "segment": 2, "count": 1})
    first = at.sdo(ASK_NAME)
    assert first[:2] == "41"
    assert at.sdo(SEGMENT_0)[:2] == "00"
    assert at.sdo(SEGMENT_1) == "80 08 10 00 00 00 00 08"
    assert at.sdo(ASK_1000)[:2] == "43"  # the server has ended the transfer
    for request, begin in ((ASK_NAME, "41"), (SEGMENT_0, "00"), (SEGMENT_1, "1")):
        assert at.sdo(request).startswith(begin)


@pytest.mark.parametrize(
    ("where", "answers"),
    [
        ({}, ["", "", ""]),
        ({"index": 0x1008}, ["43", "", "60"]),
        ({"transfer": "download"}, ["43", "41", ""]),
        ({"subindex": 1}, ["43", "41", "60"]),
        ({"nth": 2}, ["43", "", ""]),
    ],
    ids=str,
)
def test_an_answer_that_never_comes(where: dict[str, Any], answers: list[str]) -> None:
    at = bench({"what": "sdo_silence", **where})
    found = [at.sdo(ASK_1000)[:2], at.sdo(ASK_NAME)[:2]]
    at.sdo("80 08 10 00 00 00 04 05")
    assert [*found, at.sdo(WRITE_1017)[:2]] == answers


def test_a_silent_server_has_done_what_was_asked() -> None:
    at = bench({"what": "sdo_silence", "count": 1})
    assert at.sdo(WRITE_1017) == ""
    assert at.after(60)[0] == "705#7f"


def test_a_wrong_toggle_bit_is_that_of_the_segment() -> None:
    at = bench({"what": "sdo_toggle", "segment": 1})
    at.sdo(ASK_NAME)
    assert at.sdo(SEGMENT_0)[:2] == "10"
    assert at.sdo(SEGMENT_1)[0] in "01"
    assert at.node.faults()[1]["applied"] == 1


def test_a_late_sdo_answer() -> None:
    at = bench({"what": "sdo_delay", "delay_ms": 40})
    assert at.sdo(ASK_1000) == ""
    assert at.after(39) == []
    assert at.after(1) == ["585#43 00 10 00 91 01 0f 00"]


def test_a_late_boot_up_and_nothing_before_it() -> None:
    at = bench({"what": "late_boot_up", "delay_ms": 300}, **{"1017:00": 100})
    assert at.send("000#81 05") == []
    assert at.sdo(ASK_1000) == ""
    assert at.after(299) == []
    assert at.after(1)[0] == "705#00"
    assert at.sdo(ASK_1000)[:2] == "43"


def test_a_heartbeat_that_is_lost_for_a_while() -> None:
    at = bench({"what": "heartbeat_lost", "duration_ms": 250}, **{"1017:00": 100})
    assert at.after(240) == []
    assert at.sdo(ASK_1000)[:2] == "43"
    assert at.after(100) == ["705#7f"]


@pytest.mark.parametrize(("length", "data"), [(1, 1), (8, 8)])
def test_a_pdo_of_another_length(length: int, data: int) -> None:
    at = bench({"what": "pdo_length", "pdo": 1, "length": length})
    pdos = [frame for frame in at.send("000#01 05") if frame.startswith("185#")]
    assert [len(bytes.fromhex(frame[4:])) for frame in pdos] == [data]


def test_a_silent_node_neither_sends_nor_hears() -> None:
    at = bench({"what": "silent", "duration_ms": 500}, **{"1017:00": 100})
    assert at.sdo(WRITE_1017) == ""
    assert at.after(490) == []
    assert at.after(20) == ["705#7f"]
    assert at.sdo("40 17 10 00 00 00 00 00")[:14] == "4b 17 10 00 64"


def test_a_node_without_faults_has_its_own_end_of_the_bus() -> None:
    at = bench()
    assert at.node._port.link is at.can
    number = at.node.add_fault({"what": "silent"})
    assert at.node._port.link is not at.can
    at.node.clear_fault(number)
    assert at.node._port.link is at.can
    assert at.sdo(ASK_1000)[:2] == "43"


def test_an_emergency_is_an_emcy_at_its_start_and_another_one_at_its_end() -> None:
    """Figure 53 of CiA 301: error code, error register with the generic bit, and the bytes of the maker."""
    at = bench({"what": "emergency", "code": 0x5000, "error_register": 0x20, "info": "01 02", "duration_ms": 100})
    assert at.node.points()["error_register"].read() == 0x21
    assert at.take() == ["085#00 50 21 01 02 00 00 00"]
    assert at.after(150) == ["085#00 00 00 00 00 00 00 00"]
    assert at.node.points()["error_register"].read() == 0


def test_an_emergency_ends_when_it_is_cleared_and_a_reset_forgets_it() -> None:
    at = bench({"what": "emergency", "code": 0x5000})
    at.take()
    at.node.clear_fault(1)
    assert at.take() == ["085#00 00 00 00 00 00 00 00"]
    at.node.add_fault({"what": "emergency", "code": 0x6000})
    at.send("000#81 05")
    at.node.clear_fault(2)
    assert at.take() == []
