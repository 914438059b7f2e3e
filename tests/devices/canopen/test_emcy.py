"""EMCY, CiA 301 7.2.7, and the error register and history."""

import pytest
from canopen_bench import CanopenBench

TEMPERATURE = 0x4210


def test_error_is_sent_with_register_and_information(bench: CanopenBench) -> None:
    bench.node.emcy.raise_error(TEMPERATURE, 0x08, b"\x01\x02\x03\x04\x05")
    assert bench.take() == ["085#10 42 09 01 02 03 04 05"]
    assert bench.sdo("40 01 10 00 00 00 00 00") == "4f 01 10 00 09 00 00 00"


def test_error_is_sent_once_and_its_end_too(bench: CanopenBench) -> None:
    bench.set("emcy.code", TEMPERATURE)
    bench.set("emcy.code", TEMPERATURE)
    assert bench.take() == ["085#10 42 01 00 00 00 00 00"]
    bench.set("emcy.code", 0)
    bench.set("emcy.code", 0)
    assert bench.take() == ["085#00 00 00 00 00 00 00 00"]
    assert bench.point("error_register") == 0


def test_what_is_left_stays_in_the_register(bench: CanopenBench) -> None:
    bench.node.emcy.raise_error(TEMPERATURE, 0x08)
    bench.node.emcy.raise_error(0x3110, 0x04)
    bench.node.emcy.clear_error(TEMPERATURE)
    assert bench.take()[-1] == "085#00 00 05 00 00 00 00 00"


def test_history_has_the_newest_first(bench: CanopenBench) -> None:
    bench.node.emcy.raise_error(TEMPERATURE, info=b"\xaa\xbb\xcc")
    bench.node.emcy.raise_error(0x3110)
    bench.play(
        [
            ("40 03 10 00 00 00 00 00", "4f 03 10 00 02 00 00 00"),
            ("40 03 10 01 00 00 00 00", "43 03 10 01 10 31 00 00"),
            ("40 03 10 02 00 00 00 00", "43 03 10 02 10 42 aa bb"),
            ("40 03 10 03 00 00 00 00", "80 03 10 03 24 00 00 08"),
            ("2f 03 10 00 00 00 00 00", "60 03 10 00 00 00 00 00"),
            ("40 03 10 00 00 00 00 00", "4f 03 10 00 00 00 00 00"),
            ("40 03 10 01 00 00 00 00", "80 03 10 01 24 00 00 08"),
        ]
    )


def test_history_forgets_the_oldest(bench: CanopenBench) -> None:
    for code in range(0xFF01, 0xFF0A):
        bench.node.emcy.raise_error(code)
    assert bench.sdo("40 03 10 00 00 00 00 00") == "4f 03 10 00 08 00 00 00"
    assert bench.sdo("40 03 10 08 00 00 00 00") == "43 03 10 08 02 ff 00 00"


def test_inhibit_time_spaces_messages(bench: CanopenBench) -> None:
    bench.write("2b 15 10 00 64 00 00 00")  # 10 ms
    for code in (0xFF01, 0xFF02, 0xFF03):
        bench.node.emcy.raise_error(code)
    assert bench.take() == ["085#01 ff 01 00 00 00 00 00"]
    assert bench.after(9.9) == []
    assert bench.after(0.1) == ["085#02 ff 01 00 00 00 00 00"]
    assert bench.after(100) == ["085#03 ff 01 00 00 00 00 00"]


def test_stopped_node_reports_when_it_may_again(bench: CanopenBench) -> None:
    bench.send("000#02 05")
    bench.set("emcy.code", TEMPERATURE)
    assert bench.after(0) == []
    assert bench.send("000#80 05") == ["085#10 42 01 00 00 00 00 00"]


def test_without_valid_cob_id_nothing_is_sent(bench: CanopenBench) -> None:
    bench.write("23 14 10 00 85 00 00 80")
    bench.set("emcy.code", TEMPERATURE)
    assert bench.take() == []
    bench.write("23 14 10 00 90 00 00 00")
    bench.set("emcy.code", 0)
    assert bench.take() == ["090#00 00 00 00 00 00 00 00"]


def test_errors_of_the_device_outlast_a_reset_of_communication(bench: CanopenBench) -> None:
    bench.set("emcy.code", TEMPERATURE)
    bench.send("000#82 05")
    assert bench.point("error_register") == 1
    bench.send("000#81 05")
    assert bench.point("error_register") == 0


@pytest.mark.parametrize(("code", "register"), [(0x8611, 1), (0x8130, 0), (0x8210, 0)])
def test_only_errors_of_communication_end_with_its_reset(bench: CanopenBench, code: int, register: int) -> None:
    """86xxh is an error of a drive, positioning, and not of the communication."""
    bench.set("emcy.code", code)
    bench.send("000#82 05")
    assert bench.point("error_register") == register


@pytest.mark.parametrize("value", [-1, 0x10000, True, "1", 1.0])
def test_what_is_no_error_code_is_refused(bench: CanopenBench, value: bool | int | float | str) -> None:
    with pytest.raises(ValueError, match="expected a number from 0 to 0xFFFF"):
        bench.set("emcy.code", value)


# Consumer, 1028h


def test_errors_of_other_nodes_are_heard(bench: CanopenBench) -> None:
    bench.write("23 28 10 03 83 00 00 00")
    assert 0x083 in bench.interest
    bench.send("083#10 42 09 01 02 03 04 05")
    assert bench.point("emcy.heard") == "node 3: 4210h, register 09h, 01 02 03 04 05"
    bench.send("083#10 43", "083#R", "084#10 43 09 01 02 03 04 05")
    assert bench.point("emcy.heard") == "node 3: 4210h, register 09h, 01 02 03 04 05"
    bench.write("23 28 10 03 83 00 00 80")
    assert 0x083 not in bench.interest


def test_cob_id_of_the_consumer_is_guarded(bench: CanopenBench) -> None:
    bench.play(
        [
            ("23 28 10 03 83 00 00 00", "60 28 10 03 00 00 00 00"),
            ("23 28 10 03 84 00 00 00", "80 28 10 03 22 00 00 08"),
            ("23 28 10 04 01 07 00 00", "80 28 10 04 30 00 09 06"),
        ]
    )
