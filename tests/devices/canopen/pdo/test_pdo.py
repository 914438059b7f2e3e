"""PDOs, CiA 301 7.2.2 and 7.5.2.35 to 7.5.2.38.

The I/O module as node 5: RPDO 1 (205h) sets 6200h, TPDO 1 (185h) carries 6000h, TPDO 2 (285h) 6401h.
"""

from pathlib import Path

import pytest
from canopen_bench import CanopenBench, Script

SYNC = "080#"
START, STOP, PREPARE = "000#01 05", "000#02 05", "000#80 05"


def type_of_rpdo_1(transmission_type: int) -> str:
    return f"2f 00 14 02 {transmission_type:02x} 00 00 00"


def type_of_tpdo_1(transmission_type: int) -> str:
    return f"2f 00 18 02 {transmission_type:02x} 00 00 00"


def outputs(bench: CanopenBench) -> list[object]:
    return [bench.point(f"6200:{sub:02}") for sub in (1, 2, 3, 4)]


# RPDO


@pytest.mark.parametrize("transmission_type", [254, 255])
def test_event_driven_rpdo_acts_at_once(bench: CanopenBench, transmission_type: int) -> None:
    bench.write(type_of_rpdo_1(transmission_type))
    bench.send(START, "205#01 02 03 04")
    assert outputs(bench) == [1, 2, 3, 4]


@pytest.mark.parametrize("transmission_type", [0, 1, 240])
def test_synchronous_rpdo_acts_at_the_next_sync(bench: CanopenBench, transmission_type: int) -> None:
    bench.write(type_of_rpdo_1(transmission_type))
    bench.send(START, "205#ff ff ff ff", "205#01 02 03 04")
    assert outputs(bench) == [0, 0, 0, 0]
    bench.send(SYNC)
    assert outputs(bench) == [1, 2, 3, 4]


def test_rpdo_waiting_for_sync_is_forgotten_outside_operational(bench: CanopenBench) -> None:
    bench.write(type_of_rpdo_1(1))
    bench.send(START, "205#01 02 03 04", PREPARE, START, SYNC)
    assert outputs(bench) == [0, 0, 0, 0]


def test_rpdo_waiting_for_sync_is_forgotten_with_its_mapping(bench: CanopenBench) -> None:
    bench.write(type_of_rpdo_1(1))
    bench.send(START, "205#01 02 03 04")
    bench.write("23 00 14 01 05 02 00 80", "23 00 14 01 05 02 00 00")
    bench.send(SYNC)
    assert outputs(bench) == [0, 0, 0, 0]


@pytest.mark.parametrize("command", [STOP, PREPARE])
def test_no_pdo_outside_operational(running: CanopenBench, command: str) -> None:
    running.send(command, "205#01 02 03 04")
    running.set("6000:01", 1)
    assert running.send(SYNC, "185#R") == []
    assert outputs(running) == [0, 0, 0, 0]


def test_rpdo_that_is_too_long_gives_its_first_bytes_and_is_reported_once(running: CanopenBench) -> None:
    assert running.send("205#01 02 03 04 05 06") == ["085#20 82 11 06 04 00 00 00"]
    assert outputs(running) == [1, 2, 3, 4]
    assert running.send("205#02 02 03 04 05 06") == []
    assert outputs(running) == [2, 2, 3, 4]
    assert running.send("205#03 02 03 04") == ["085#00 00 00 00 00 00 00 00"]


def test_rpdo_that_is_too_short_is_not_taken_and_reported_once(running: CanopenBench) -> None:
    assert running.send("205#01 02 03") == ["085#10 82 11 03 04 00 00 00"]
    assert running.send("205#01 02") == []
    assert outputs(running) == [0, 0, 0, 0]
    assert running.send("205#01 02 03 04") == ["085#00 00 00 00 00 00 00 00"]


def test_rpdo_with_rtr_is_nothing(running: CanopenBench) -> None:
    assert running.send("205#R") == []


def test_value_beyond_its_limits_is_not_taken_from_an_rpdo(tmp_path: Path) -> None:
    bench = CanopenBench(tmp_eds(tmp_path, rpdo=[("0x20000008", "0x05", "rw", "HighLimit=9")]))
    bench.send(START, "205#09", "205#0a")
    assert bench.point("2000:00") == 9


# TPDO


def test_event_driven_tpdos_are_sent_when_operational_begins(bench: CanopenBench) -> None:
    assert bench.send(START) == ["185#00 00 00 00", "285#00 00 00 00 00 00 00 00"]


def test_change_of_an_input_sends_the_tpdo(running: CanopenBench) -> None:
    running.set("6000:02", 0xA5)
    assert running.after(0) == ["185#00 a5 00 00"]
    running.set("6000:02", 0xA5)
    assert running.after(0) == []


def test_changes_at_one_instant_go_out_in_one_tpdo(running: CanopenBench) -> None:
    running.set("6000:01", 1)
    running.set("6000:02", 2)
    assert running.after(0) == ["185#01 02 00 00"]


def test_acyclic_tpdo_is_sent_at_sync_if_there_was_an_event(bench: CanopenBench) -> None:
    bench.write(type_of_tpdo_1(0))
    bench.send(START)
    assert bench.send(SYNC) == []
    bench.set("6000:01", 1)
    assert bench.after(0) == []
    assert bench.send(SYNC) == ["185#01 00 00 00"]
    assert bench.send(SYNC) == []


@pytest.mark.parametrize("cycle", [1, 2, 3, 240])
def test_cyclic_tpdo_is_sent_at_every_nth_sync(bench: CanopenBench, cycle: int) -> None:
    bench.write(type_of_tpdo_1(cycle))
    bench.send(START)
    for _ in range(2):
        assert bench.send(*[SYNC] * (cycle - 1)) == []
        assert bench.send(SYNC) == ["185#00 00 00 00"]


def test_tpdo_carries_what_its_sync_puts_into_effect(tmp_path: Path) -> None:
    """RPDOs are processed first, so a mapped output is sent with the value that the same SYNC has set."""
    parts = [("0x20000010", "0x06", "rw", "")]
    bench = CanopenBench(tmp_eds(tmp_path, rpdo=parts, tpdo=parts))
    bench.write(type_of_rpdo_1(1), type_of_tpdo_1(1))
    bench.send(START, "205#34 12")
    assert bench.send(SYNC) == ["185#34 12"]


def test_inhibit_time_holds_events_back(bench: CanopenBench) -> None:
    bench.play(change_of_tpdo_1("2b 00 18 03 64 00 00 00"))  # 10 ms
    bench.send(START)
    bench.after(10)
    bench.set("6000:01", 1)
    assert bench.after(3) == ["185#01 00 00 00"]
    bench.set("6000:01", 2)
    bench.set("6000:01", 3)
    assert bench.after(6.9) == []
    assert bench.after(0.1) == ["185#03 00 00 00"]
    assert bench.after(100) == []


def test_event_timer_repeats_the_tpdo(bench: CanopenBench) -> None:
    bench.write("2b 00 18 05 64 00 00 00")
    bench.send(START)
    assert bench.after(99) == []
    assert bench.after(1) == ["185#00 00 00 00"]
    bench.after(50)
    bench.set("6000:01", 1)
    assert bench.after(0) == ["185#01 00 00 00"]
    assert bench.after(99) == []
    assert bench.after(1) == ["185#01 00 00 00"]


def test_event_timer_changes_while_running(running: CanopenBench) -> None:
    running.write("2b 00 18 05 64 00 00 00")
    assert running.after(100) == ["185#00 00 00 00"]
    running.write("2b 00 18 05 00 00 00 00")
    assert running.after(1000) == []


RTR_ALLOWED: Script = [
    ("23 00 18 01 85 01 00 c0", "60 00 18 01 00 00 00 00"),
    ("23 00 18 01 85 01 00 80", "60 00 18 01 00 00 00 00"),
    ("23 00 18 01 85 01 00 00", "60 00 18 01 00 00 00 00"),
]


def test_rtr_is_answered_only_where_it_is_allowed(running: CanopenBench) -> None:
    assert running.send("185#R") == []
    assert 0x185 not in running.interest
    running.play(RTR_ALLOWED)
    running.take()
    assert 0x185 in running.interest
    assert running.send("185#R") == ["185#00 00 00 00"]
    assert running.send("185#00 00 00 00") == []


def test_type_252_gives_what_the_last_sync_found(bench: CanopenBench) -> None:
    bench.play(RTR_ALLOWED)
    bench.write(type_of_tpdo_1(252))
    bench.send(START, SYNC)
    bench.set("6000:01", 7)
    assert bench.send("185#R") == ["185#00 00 00 00"]
    assert bench.send(SYNC) == []
    assert bench.send("185#R") == ["185#07 00 00 00"]


def test_type_253_gives_what_is_now(bench: CanopenBench) -> None:
    bench.play(RTR_ALLOWED)
    bench.write(type_of_tpdo_1(253))
    assert bench.send(START) == ["285#00 00 00 00 00 00 00 00"]
    bench.set("6000:01", 7)
    assert bench.after(0) == []
    assert bench.send("185#R") == ["185#07 00 00 00"]


def test_cyclic_tpdo_waits_for_its_sync_start_value(bench: CanopenBench) -> None:
    bench.write("2f 19 10 00 04 00 00 00")
    bench.play(change_of_tpdo_1("2f 00 18 06 03 00 00 00"))
    bench.write(type_of_tpdo_1(2))
    bench.send(START)
    assert bench.send("080#01", "080#02", "080#03") == []
    assert bench.send("080#04") == ["185#00 00 00 00"]
    assert bench.send("080#01") == []
    assert bench.send("080#02") == ["185#00 00 00 00"]


# Parameters and the mapping procedure


def change_of_tpdo_1(*requests: str) -> Script:
    """Make the PDO invalid for the time of a change."""
    steps = ["23 00 18 01 85 01 00 c0", *requests, "23 00 18 01 85 01 00 40"]
    return [(step, f"60 {step[3:11]} 00 00 00 00") for step in steps]


REFUSED: dict[str, Script] = {
    "reserved transmission types": [
        ("2f 00 18 02 f1 00 00 00", "80 00 18 02 30 00 09 06"),
        ("2f 00 18 02 fb 00 00 00", "80 00 18 02 30 00 09 06"),
        ("2f 00 14 02 f1 00 00 00", "80 00 14 02 30 00 09 06"),
        ("2f 00 14 02 fc 00 00 00", "80 00 14 02 30 00 09 06"),
        ("2f 00 14 02 fd 00 00 00", "80 00 14 02 30 00 09 06"),
    ],
    "another COB-ID, inhibit time or SYNC start value while the PDO is valid": [
        ("23 00 18 01 86 01 00 40", "80 00 18 01 22 00 00 08"),
        ("23 00 14 01 06 02 00 00", "80 00 14 01 22 00 00 08"),
        ("2b 00 18 03 64 00 00 00", "80 00 18 03 22 00 00 08"),
        ("2f 00 18 06 03 00 00 00", "80 00 18 06 22 00 00 08"),
    ],
    "restricted and ill-formed COB-IDs": [
        ("23 00 14 01 05 02 00 80", "60 00 14 01 00 00 00 00"),
        ("23 00 14 01 85 05 00 00", "80 00 14 01 30 00 09 06"),
        ("23 00 14 01 00 00 00 00", "80 00 14 01 30 00 09 06"),
        ("23 00 14 01 05 0a 00 00", "80 00 14 01 30 00 09 06"),
    ],
    "mapping of a valid PDO": [
        ("2f 00 1a 00 00 00 00 00", "80 00 1a 00 00 00 01 06"),
        ("23 00 1a 01 08 02 00 60", "80 00 1a 01 00 00 01 06"),
    ],
    "mapping while it is enabled": [
        ("23 00 18 01 85 01 00 c0", "60 00 18 01 00 00 00 00"),
        ("23 00 1a 01 08 02 00 60", "80 00 1a 01 00 00 01 06"),  # as the log of CiA's tool allows (PDO 23)
    ],
    "what cannot be mapped into a TPDO": [
        ("23 00 18 01 85 01 00 c0", "60 00 18 01 00 00 00 00"),
        ("2f 00 1a 00 00 00 00 00", "60 00 1a 00 00 00 00 00"),
        ("23 00 1a 01 08 01 00 55", "80 00 1a 01 00 00 02 06"),  # no object
        ("23 00 1a 01 08 09 00 60", "80 00 1a 01 41 00 04 06"),  # no sub-index
        ("23 00 1a 01 10 01 00 60", "80 00 1a 01 41 00 04 06"),  # another length
        ("23 00 1a 01 08 00 01 10", "80 00 1a 01 41 00 04 06"),  # not mappable
        ("23 00 1a 01 08 01 00 62", "80 00 1a 01 41 00 04 06"),  # rww
        ("23 00 1a 01 08 00 05 00", "80 00 1a 01 41 00 04 06"),  # a dummy
    ],
    "what cannot be mapped into an RPDO": [
        ("23 00 14 01 05 02 00 80", "60 00 14 01 00 00 00 00"),
        ("2f 00 16 00 00 00 00 00", "60 00 16 00 00 00 00 00"),
        ("23 00 16 01 08 01 00 60", "80 00 16 01 41 00 04 06"),  # ro
        ("23 00 16 01 08 01 02 62", "80 00 16 01 41 00 04 06"),  # not mappable
        ("23 00 16 01 10 00 05 00", "80 00 16 01 41 00 04 06"),  # a dummy of another length
    ],
    "more than 64 bits, more than there are entries": [
        ("23 00 18 01 85 01 00 c0", "60 00 18 01 00 00 00 00"),
        ("2f 00 1a 00 00 00 00 00", "60 00 1a 00 00 00 00 00"),
        ("2f 00 1a 00 09 00 00 00", "80 00 1a 00 42 00 04 06"),
        ("2f 00 1a 00 05 00 00 00", "80 00 1a 00 00 00 02 06"),  # the fifth is empty
        ("23 00 1a 01 10 01 01 64", "60 00 1a 01 00 00 00 00"),
        ("23 00 1a 02 10 02 01 64", "60 00 1a 02 00 00 00 00"),
        ("23 00 1a 03 10 03 01 64", "60 00 1a 03 00 00 00 00"),
        ("23 00 1a 04 10 04 01 64", "60 00 1a 04 00 00 00 00"),
        ("23 00 1a 05 08 01 00 60", "60 00 1a 05 00 00 00 00"),
        ("2f 00 1a 00 05 00 00 00", "80 00 1a 00 42 00 04 06"),
        ("2f 00 1a 00 04 00 00 00", "60 00 1a 00 00 00 00 00"),
    ],
}


@pytest.mark.parametrize("name", REFUSED)
def test_refuses(bench: CanopenBench, name: str) -> None:
    bench.play(REFUSED[name])


def test_mapping_procedure_changes_what_a_tpdo_carries(bench: CanopenBench) -> None:
    bench.play(
        change_of_tpdo_1(
            "2f 00 1a 00 00 00 00 00",
            "23 00 1a 01 10 02 01 64",
            "23 00 1a 02 08 01 00 60",
            "2f 00 1a 00 02 00 00 00",
        )
    )
    bench.send(START)
    bench.set("6401:02", -2)
    bench.set("6000:01", 0x81)
    assert "185#fe ff 81" in bench.after(0)


def test_some_nodes_change_the_mapping_of_a_pdo_that_stays_valid() -> None:
    bench = CanopenBench(maps_while_valid=True)
    bench.set("6401:02", -2)
    bench.send(START)
    bench.after(100)
    entry = ("23 00 1a 01 10 02 01 64", "80 00 1a 01 00 00 01 06")  # the number of entries comes before them
    bench.play([entry, ("2f 00 1a 00 00 00 00 00", "60 00 1a 00 00 00 00 00")])
    bench.set("6000:01", 0x81)
    assert bench.after(100) == []  # nothing is mapped, so nothing is sent
    bench.play([(entry[0], "60 00 1a 01 00 00 00 00")])
    assert bench.send("605#2f 00 1a 00 01 00 00 00") == ["585#60 00 1a 00 00 00 00 00", "185#fe ff"]


def test_pdo_made_valid_in_operational_is_sent(running: CanopenBench) -> None:
    running.write("23 00 18 01 85 01 00 c0")
    running.set("6000:01", 1)
    assert running.after(0) == []
    assert running.send("605#23 00 18 01 90 01 00 40") == ["585#60 00 18 01 00 00 00 00", "190#01 00 00 00"]


def test_rpdo_listens_to_its_new_cob_id(running: CanopenBench) -> None:
    running.write("23 00 14 01 05 02 00 80")
    assert 0x205 not in running.interest
    running.write("23 00 14 01 56 34 02 20")  # 23456h, 29 bits
    assert 0x8002_3456 in running.interest
    running.send("205#09 09 09 09", "00023456#01 02 03 04")
    assert outputs(running) == [1, 2, 3, 4]


def test_dummies_leave_gaps_in_an_rpdo(bench: CanopenBench) -> None:
    for request in [
        "23 00 14 01 05 02 00 80",
        "2f 00 16 00 00 00 00 00",
        "23 00 16 01 10 00 06 00",
        "23 00 16 02 08 01 00 62",
        "2f 00 16 00 02 00 00 00",
        "23 00 14 01 05 02 00 00",
    ]:
        bench.write(request)
    bench.send(START, "205#aa bb 01")
    assert outputs(bench) == [1, 0, 0, 0]


def tmp_eds(
    folder: Path,
    rpdo: list[tuple[str, str, str, str]] | None = None,
    tpdo: list[tuple[str, str, str, str]] | None = None,
) -> Path:
    """Write the EDS of a node whose PDOs map (entry, data type, access, more), and which has these objects."""
    lines = ["[1000]", "DataType=7", "AccessType=ro", "[1005]", "DataType=7", "AccessType=rw", "DefaultValue=0x80"]
    objects = {}
    for index, parts, cob_id in ((0x1400, rpdo, "0x200"), (0x1800, tpdo, "0x180")):
        for sub, name in ((None, "PDO"), (1, "COB-ID"), (2, "Type")):
            lines += [f"[{index:04X}{'' if sub is None else f'sub{sub}'}]", f"ParameterName={name}"]
            if sub is None:
                lines += ["ObjectType=9"]
            else:
                value = f"$NODEID+{cob_id}" if sub == 1 else "255"
                lines += [f"DataType={7 if sub == 1 else 5}", "AccessType=rw", f"DefaultValue={value}"]
        lines += [f"[{index + 0x200:04X}]", "ObjectType=9", f"[{index + 0x200:04X}sub0]"]
        lines += ["DataType=5", "AccessType=rw", f"DefaultValue={len(parts or [])}"]
        for sub, (entry, data_type, access, more) in enumerate(parts or [], start=1):
            lines += [f"[{index + 0x200:04X}sub{sub}]", "DataType=7", "AccessType=rw", f"DefaultValue={entry}"]
            objects[entry[2:6]] = [f"DataType={data_type}", f"AccessType={access}", "PDOMapping=1", more]
    for name, section in objects.items():
        lines += [f"[{name}]", *section]
    path = folder / "pdo.eds"
    path.write_text("\n".join(lines))
    return path


BITS = [("0x20000001", "0x01", "rw", ""), ("0x20010001", "0x01", "rw", ""), ("0x20020008", "0x05", "rw", "")]


def test_booleans_take_one_bit_each(tmp_path: Path) -> None:
    bench = CanopenBench(tmp_eds(tmp_path, rpdo=BITS, tpdo=BITS))
    bench.send(START, "205#fe 03")
    assert [bench.point(f"200{n}:00") for n in range(3)] == [False, True, 0xFF]
    bench.set("2002:00", 0x81)
    assert bench.after(0)[-1] == "185#06 02"


def test_mapping_that_the_eds_has_wrong_leaves_the_pdo_empty(tmp_path: Path) -> None:
    bench = CanopenBench(tmp_eds(tmp_path, tpdo=[("0x20000010", "0x05", "rw", "")]))
    assert "185#" not in "".join(bench.send(START, SYNC))


# Deadline of RPDOs (event timer, sub-index 5) and window of synchronous ones (1007h)

TIMEOUT, NO_ERROR = "085#50 82 11 00 00 00 00 00", "085#00 00 00 00 00 00 00 00"
DEADLINE_OF_100_MS = "2b 00 14 05 64 00 00 00"


def test_rpdo_that_stays_away_is_reported_until_it_is_back(bench: CanopenBench) -> None:
    bench.write(DEADLINE_OF_100_MS)
    bench.send(START)
    assert bench.after(1000) == []  # supervision starts with the first RPDO
    for _ in range(3):
        bench.send("205#01 02 03 04")
        assert bench.after(99) == []
    assert bench.after(1) == [TIMEOUT]
    assert bench.after(1000) == []
    assert bench.send("205#01 02 03 04") == [NO_ERROR]


@pytest.mark.parametrize("end", ["605#2b 00 14 05 00 00 00 00", "605#23 00 14 01 05 02 00 80", PREPARE])
def test_deadline_ends_with_the_rpdo(bench: CanopenBench, end: str) -> None:
    bench.write(DEADLINE_OF_100_MS)
    bench.send(START, "205#01 02 03 04", end)
    assert bench.after(1000) == []


def test_deadline_that_is_taken_away_takes_its_error_with_it(bench: CanopenBench) -> None:
    bench.write(DEADLINE_OF_100_MS)
    bench.send(START, "205#01 02 03 04")
    assert bench.after(100) == [TIMEOUT]
    assert NO_ERROR in bench.send("605#2b 00 14 05 00 00 00 00")


DEADLINE_OF_RPDO_2 = "2b 01 14 05 64 00 00 00"


def test_a_problem_of_two_rpdos_ends_with_the_last_of_them(bench: CanopenBench) -> None:
    bench.write(DEADLINE_OF_100_MS, DEADLINE_OF_RPDO_2)
    bench.send(START, "205#01 02 03 04", "305#01 00 02 00 03 00 04 00")
    assert bench.after(100) == [TIMEOUT]
    assert bench.send("205#01 02 03 04") == []
    assert bench.point("1001:00") == 0x11
    assert bench.send("305#01 00 02 00 03 00 04 00") == [NO_ERROR]
    assert bench.point("1001:00") == 0


def test_synchronous_rpdo_after_the_window_waits_for_the_next_sync(bench: CanopenBench) -> None:
    bench.write(type_of_rpdo_1(1), "23 07 10 00 88 13 00 00")  # 5 ms
    bench.send(START, SYNC)
    bench.after(4.9)
    bench.send("205#01 00 00 00")
    bench.after(0.1)
    bench.send("205#02 00 00 00", SYNC)
    assert outputs(bench)[0] == 1
    bench.send("205#03 00 00 00", SYNC)
    assert outputs(bench)[0] == 3
