"""A rig of a Modbus log: units, registers, refusals and answer times.  The PDUs are those of V1.1b3, chapter 6."""

import math
import struct
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from made_rigs import keys_of, rig_file, save, virtual

from fieldrig import Rig
from fieldrig.clock import MS, S
from fieldrig.config.yaml_source import read
from fieldrig.errors import UnmetError, UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus import codec
from fieldrig_bus.modbus.message import LineState, ModbusRequest, ModbusResponse
from fieldrig_devices.dialogues.rtu_line import RtuLine
from fieldrig_devices.from_recording.answer_log import AnswerLog
from fieldrig_devices.from_recording.content import content_for
from fieldrig_devices.modbus.answer_times import Answer

READ = "03 006B 0003"  # 6.3: holding registers 107 to 109
VALUES = "03 06 022B 0000 0064"


def exchanges(
    *rows: tuple[float, int, str, str | None], answer_ms: float = 5, line: bool = False
) -> Iterable[TraceEntry]:
    """Yield requests with their responses, as instant in seconds, unit, and both PDUs in hex."""
    state = LineState(1, 0) if line else None
    for number, (at_s, unit, request, response) in enumerate(rows):
        asked = ModbusRequest(unit, bytes.fromhex(request), number, state)
        yield TraceEntry(round(at_s * S), "mb", "modbus", "client", codec.encode(asked))
        if response is not None:
            answered = ModbusResponse(unit, bytes.fromhex(response), number)
            at_ns = round(at_s * S + answer_ms * MS)
            yield TraceEntry(at_ns, "mb", "modbus", "server", codec.encode(answered))


def made(tmp_path: Path, *rows: tuple[float, int, str, str | None], answer_ms: float = 5, line: bool = False) -> Path:
    return rig_file(save(list(exchanges(*rows, answer_ms=answer_ms, line=line)), tmp_path / "meter.jsonl"))


def ask(rig: Rig, unit: int, request: str) -> tuple[str, int]:
    """Return the response in hex, and the time that it took in ms."""
    received: list[ModbusResponse] = []
    master = rig.attach(f"master at {rig.now_ns}").link("mb")
    master.on_receive(received.append)
    begin_ns = rig.now_ns
    master.send(ModbusRequest(unit, bytes.fromhex(request)))
    rig.until(lambda: received, within=1 * S)
    return received[0].pdu.hex(), round((rig.now_ns - begin_ns) / MS)


@pytest.mark.parametrize(
    ("request_", "response"),
    [
        ("01 0013 0013", "01 03 CD 6B 05"),  # 6.1
        ("02 00C4 0016", "02 03 AC DB 35"),  # 6.2
        (READ, VALUES),  # 6.3
        ("04 0008 0001", "04 02 000A"),  # 6.4
        ("03 0FFF 0001", "83 02"),
        ("06 0001 0003", "86 04"),
        ("07", "07 6D"),  # 6.7
        ("07", "87 01"),
        ("2B 0E 01 00", "2B 0E 01 81 00 00 03 00 04 41 42 43 44 01 02 45 46 02 01 31"),
        ("2B 0E 01 00", "2B 0E 01 82 00 00 03 00 04 41 42 43 44 01 02 45 46 02 01 31"),  # 6.21: more than was read
        ("2B 0E 01 00", "2B 0E 01 83 00 00 03 00 04 41 42 43 44 01 02 45 46 02 01 31"),
    ],
)
def test_a_request_has_the_response_of_the_log(tmp_path: Path, request_: str, response: str) -> None:
    with virtual(made(tmp_path, (0, 7, request_, response))) as rig:
        assert ask(rig, 7, request_)[0] == bytes.fromhex(response).hex()


def test_an_answer_takes_its_usual_time(tmp_path: Path) -> None:
    with virtual(made(tmp_path, *((turn, 7, READ, VALUES) for turn in range(5)), answer_ms=23)) as rig:
        assert ask(rig, 7, READ)[1] == 23


def test_registers_that_moved_are_replayed_and_others_stay(tmp_path: Path) -> None:
    rows = [(float(turn), 7, READ, f"03 06 022B {turn:04X} 0064") for turn in range(5)]
    path = made(tmp_path, *rows)
    table = read((path.parent / "registers/unit7.yaml").read_text(), "").data
    assert [entry.get("source", {}).get("kind") for entry in table["holding_registers"]] == [None, "replay", None]
    with virtual(path) as rig:
        for turn, (at_s, unit, request, response) in enumerate(rows):
            rig.run_until(round(at_s * S))
            assert (turn, ask(rig, unit, request)[0]) == (turn, bytes.fromhex(response).hex())


def test_a_register_that_a_client_wrote_keeps_what_is_written(tmp_path: Path) -> None:
    rows = [(0.0, 7, READ, VALUES), (1.0, 7, "06 006C 0007", "06 006C 0007"), (2.0, 7, READ, "03 06 022B 0007 0064")]
    with virtual(made(tmp_path, *rows)) as rig:
        assert ask(rig, 7, READ)[0] == bytes.fromhex(VALUES).hex()
        ask(rig, 7, "06 006C 0009")
        assert ask(rig, 7, READ)[0] == bytes.fromhex("03 06 022B 0009 0064").hex()


def test_a_register_that_the_device_changes_after_a_client_is_replayed_between_the_writes(tmp_path: Path) -> None:
    """A handshake: a client sets a bit, and the device takes it back; another value moves in the meantime."""
    values = [(0, 0), (1, 0), (1, 1), (0, 2), (0, 3), (1, 4), (0, 5)]
    rows = [(float(at_s), 7, READ, f"03 06 {bit:04X} {number:04X} 0064") for at_s, (bit, number) in enumerate(values)]
    rows += [(at_s, 7, "06 006B 0001", "06 006B 0001") for at_s in (0.5, 4.6)]
    path = made(tmp_path, *sorted(rows))
    assert "was written, and changed" not in path.read_text()
    with virtual(path) as rig:
        for at_s, unit, request, response in sorted(rows):
            rig.run_until(round(at_s * S))
            assert (at_s, ask(rig, unit, request)[0]) == (at_s, bytes.fromhex(response).hex())


def test_a_coil_that_starts_something_is_taken_back(tmp_path: Path) -> None:
    rows = [(0.0, 7, "01 0000 0001", "01 01 00"), (1.0, 7, "05 0000 FF00", "05 0000 FF00"),
            (2.0, 7, "01 0000 0001", "01 01 00"), (3.0, 7, "01 0000 0001", "01 01 00")]  # fmt: skip
    with virtual(made(tmp_path, *rows)) as rig:
        for at_s, unit, request, response in rows:
            rig.run_until(round(at_s * S))
            assert (at_s, ask(rig, unit, request)[0]) == (at_s, bytes.fromhex(response).hex())


def test_a_group_that_reaches_beyond_the_registers_is_refused(tmp_path: Path) -> None:
    with virtual(made(tmp_path, (0, 7, READ, VALUES))) as rig:
        assert ask(rig, 7, "03 006B 0004")[0] == "8302"


def test_each_unit_is_a_device(tmp_path: Path) -> None:
    path = made(tmp_path, (0, 1, READ, VALUES), (1, 2, READ, VALUES), (2, 9, READ, None))
    keys = keys_of(path)
    assert {name: device["unit_id"] for name, device in keys["devices"].items()} == {"unit1": 1, "unit2": 2}
    assert keys["buses"]["mb"]["unknown_unit"] == "silence"
    assert "unit 9 never answered 1 request" in path.read_text()


def test_units_that_never_answered_are_one_sentence(tmp_path: Path) -> None:
    text = made(tmp_path, (0, 1, READ, VALUES), *((unit, unit, READ, None) for unit in (2, 3, 4, 9))).read_text()
    assert "units 2 to 4, 9 never answered 1 request each: they are no devices here" in text


def answered(rig: Rig, at_s: float, request: str = READ) -> bool:
    """Return whether unit 7 answers a request at this instant."""
    rig.run_until(round(at_s * S))
    try:
        ask(rig, 7, request)
    except UnmetError:
        return False
    return True


def test_a_unit_is_silent_when_it_was_silent(tmp_path: Path) -> None:
    """It boots for three seconds, and is off from 6 to 9; function 7 it does not know, and ignores."""
    answers = [None if turn < 3 or turn in (6, 7, 8) else VALUES for turn in range(12)]
    rows = [(float(turn), 7, READ, answer) for turn, answer in enumerate(answers)]
    path = made(tmp_path, *rows, (4.5, 7, "07", None))
    with virtual(path) as rig:
        instants = (0.1, 1.2, 3, 5, 6, 7.2, 9)
        assert [answered(rig, at_s) for at_s in instants] == [False, False, True, True, False, False, True]
        assert not answered(rig, 10, "07")
    text = " ".join(path.read_text().replace("#", " ").split())
    assert "7 requests had no answer: its faults `silent` are silent in the same times" in text


def test_each_group_of_registers_has_its_answer_time(tmp_path: Path) -> None:
    """A gateway asks its device for register 110 alone, and for 107 to 109 with it; it has 107 itself."""
    times = {"03 006B 0001": 2, "03 006E 0001": 80, "03 006B 0003": 200}
    answers = {"03 006B 0001": "03 02 022B", "03 006E 0001": "03 02 0001", "03 006B 0003": VALUES}
    asked = enumerate([*times] * 4)
    log = [entry for turn, request in asked for entry in exchanges(
        (turn, 7, request, answers[request]), answer_ms=times[request])]  # fmt: skip
    path = rig_file(save(log, tmp_path / "meter.jsonl"))
    assert "2 kinds of requests had other times or answers: see recorded/unit7-answers.csv" in " ".join(
        path.read_text().replace("#", " ").split()
    )
    with virtual(path) as rig:
        assert {request: ask(rig, 7, request)[1] for request in times} == times


def test_a_part_of_a_group_is_not_slower_because_the_group_is(tmp_path: Path) -> None:
    log = [entry for turn in range(12) for entry in exchanges(
        (turn, 7, READ, VALUES) if turn % 2 else (turn, 7, "03 006A 0004", "03 08 0001 022B 0000 0064"),
        answer_ms=200 if turn % 2 else 2)]  # fmt: skip
    with virtual(rig_file(save(log, tmp_path / "meter.jsonl"))) as rig:
        assert [ask(rig, 7, request)[1] for request in (READ, "03 006A 0004")] == [200, 2]


def test_answers_take_the_times_of_the_recording_in_turn(tmp_path: Path) -> None:
    """A read that is slow at times, a write that always takes 40 ms, and an exception and a function with their own."""
    reads = [(5.0, VALUES), (60.0, VALUES), (5.0, VALUES), (700.0, VALUES)]
    rows: list[tuple[str, str, float]] = [(READ, answer, ms) for ms, answer in reads]
    rows += [("06 006C 0000", "06 006C 0000", 40.0)] * 3
    rows += [
        ("03 0FFF 0001", "83 02", 90.0),
        ("03 0FFF 0001", "83 02", 9.0),
        ("07", "07 6D", 21.0),
        ("07", "07 6D", 3.5),
    ]
    log = [entry for turn, (request, answer, ms) in enumerate(rows) for entry in exchanges(
        (turn, 7, request, answer), answer_ms=ms)]  # fmt: skip
    with virtual(rig_file(save(log, tmp_path / "meter.jsonl"))) as rig:
        for turn, (request, answer, ms) in enumerate([*rows, *rows]):  # they begin again
            assert (turn, *ask(rig, 7, request)) == (turn, bytes.fromhex(answer).hex(), round(ms))


def test_a_request_that_is_lost_alone_is_lost_again(tmp_path: Path) -> None:
    answers = [VALUES, None, VALUES, VALUES, None, VALUES]
    path = made(tmp_path, *((float(turn), 7, READ, answer) for turn, answer in enumerate(answers)))
    with virtual(path) as rig:
        for turn, answer in enumerate([*answers, *answers]):
            assert (turn, answered(rig, 2 * turn)) == (turn, answer is not None)


def test_what_is_refused_at_times_is_refused_in_the_same_order(tmp_path: Path) -> None:
    """A device is busy now and then; a value that it does not take says nothing of the next one."""
    rows = [(READ, VALUES), (READ, "83 06"), (READ, VALUES), (READ, "83 04"), ("08 0000 A537", "08 0000 A537"),
            ("08 0000 A537", "88 06"), ("06 006F 0000", "06 006F 0000"), ("06 006F 7FFF", "86 03")]  # fmt: skip
    path = made(tmp_path, *((float(turn), 7, *row) for turn, row in enumerate(rows)))
    words = " ".join(path.read_text().replace("#", " ").split())
    assert "ended in exception 06 (server device busy) 1 time, which comes again in turn" in words
    assert "ended in exception 03 (illegal data value) 1 time, which is not repeated here" in words
    rows[-1] = ("06 006F 7FFF", "06 006F 7FFF")
    with virtual(path) as rig:
        for request, answer in [*rows, *rows]:
            assert ask(rig, 7, request)[0] == bytes.fromhex(answer).hex()


def test_values_are_those_of_the_instants_of_the_requests(tmp_path: Path) -> None:
    """A gateway with several requests at once: the one that was asked first is answered last."""
    asked = [
        (0.0, 5, 9),
        (0.1, 2.9, 9),
        (3.0, 9, 1),
        (3.2, 1, 2),
        (3.4, 1, 3),
        (12.0, 2, 3),
    ]  # instant, s to answer, value
    entries = []
    for number, (at_s, takes_s, value) in enumerate(asked):
        request = ModbusRequest(7, bytes.fromhex("04 0000 0001"), number)
        response = ModbusResponse(7, b"\x04\x02" + value.to_bytes(2, "big"), number)
        entries.append(TraceEntry(round(at_s * S), "mb", "modbus", "client", codec.encode(request)))
        entries.append(TraceEntry(round((at_s + takes_s) * S), "mb", "modbus", "server", codec.encode(response)))
    path = rig_file(save(sorted(entries, key=lambda entry: entry.time_ns), tmp_path / "meter.jsonl"))
    heard: list[tuple[int, int]] = []
    with virtual(path) as rig:
        master = rig.attach("master").link("mb")
        master.on_receive(lambda answer: heard.append((rig.now_ns, answer.pdu[-1])))
        for number, (at_s, _, _) in enumerate(asked):
            rig.run_until(round(at_s * S))
            master.send(ModbusRequest(7, bytes.fromhex("04 0000 0001"), number))
        rig.run_until(20 * S)
    assert heard == sorted((round((at_s + takes_s) * S), value) for at_s, takes_s, value in asked)


def test_the_server_of_a_lost_request_is_that_of_its_connection(tmp_path: Path) -> None:
    entries = []
    rows = [(turn, server, turn != 2 or server == 8) for turn in range(5) for server in (8, 9)]
    for number, (turn, server, is_answered) in enumerate(rows):
        at_ns, client = turn * S + server * MS, f"10.0.0.1:500{server}"
        entries.append(
            TraceEntry(at_ns, "mb", "modbus", client, codec.encode(ModbusRequest(1, bytes.fromhex(READ), number)))
        )
        if is_answered:
            response = codec.encode(ModbusResponse(1, bytes.fromhex(VALUES), number))
            entries.append(TraceEntry(at_ns + 5 * MS, "mb", "modbus", f"10.0.0.{server}:502", response))
    path = rig_file(save(entries, tmp_path / "two.jsonl"))
    files = {file.name: file.read_text() for file in path.parent.glob("recorded/*-answers.csv")}
    ((name, text),) = files.items()
    assert text.splitlines()[1:] == ["3,107,3,5,", "3,107,3,5,", "3,107,3,,", "3,107,3,5,", "3,107,3,5,"], name


def test_the_times_of_long_recordings_are_from_all_of_it(tmp_path: Path) -> None:
    log = AnswerLog(1024)
    for number in range(10_000):
        log.take(number * S, Answer(number * MS))
    times_ns = [answer.after_ns or 0 for _, answer in log.rows()]
    assert (log.count, times_ns[0], times_ns[-1] > 9_900 * MS) == (10_000, 0, True)
    assert 512 <= len(times_ns) <= 1024
    assert len({later - before for before, later in pairwise(times_ns)}) == 1


def test_a_function_that_was_done_too_is_not_refused(tmp_path: Path) -> None:
    """6.8: a gateway that reaches its device at times; the remarks say what the log has of it."""
    path = made(tmp_path, (0, 7, "08 0001 0000", "88 0B"), (1, 7, "08 0001 0000", "08 0001 0000"))
    assert "faults" not in keys_of(path)["devices"]["unit7"]
    assert "function 8 with 00 01 00 00 ended in exception 11" in " ".join(path.read_text().replace("#", " ").split())


def test_a_unit_that_answers_by_chance_has_no_silences(tmp_path: Path) -> None:
    rows = [(turn / 10, 7, READ, None if turn % 2 else VALUES) for turn in range(120)]
    path = made(tmp_path, *rows)
    assert "faults" not in keys_of(path)["devices"]["unit7"]
    assert "why 60 requests had no answer" in " ".join(path.read_text().replace("#", " ").split())


def test_the_last_request_of_a_recording_says_nothing(tmp_path: Path) -> None:
    rows = [(float(turn), 7, READ, VALUES) for turn in range(5)]
    assert "faults" not in keys_of(made(tmp_path, *rows, (4.006, 7, READ, None)))["devices"]["unit7"]


def test_unit_255_is_the_device_itself(tmp_path: Path) -> None:
    with virtual(made(tmp_path, (0, 255, READ, VALUES), (1, 3, READ, "03 06 0001 0002 0003"))) as rig:
        assert ask(rig, 255, READ)[0] == bytes.fromhex(VALUES).hex()


def test_requests_of_a_serial_line_make_a_serial_line(tmp_path: Path) -> None:
    assert keys_of(made(tmp_path, (0, 7, READ, VALUES), line=True))["buses"]["mb"]["kind"] == "modbus.rtu"


# 6.3 on a serial line, unit 11h, with the checksums of pymodbus
LINE_REQUEST, LINE_RESPONSE = "11 03 00 6B 00 03 76 87", "11 03 06 02 2B 00 00 00 64 C8 BA"


def serial(*chunks: tuple[float, str, str]) -> list[TraceEntry]:
    """Return bytes of a serial line, with instants in seconds and the side that sent them."""
    return [
        TraceEntry(round(at_s * S), "line", "serial", side, b"\0" + bytes.fromhex(data)) for at_s, side, data in chunks
    ]


@pytest.mark.parametrize("sides", [("tx", "rx"), ("", "")])
def test_a_serial_capture_of_rtu_is_put_together(tmp_path: Path, sides: tuple[str, str]) -> None:
    ours, theirs = sides
    chunks = [(0.0, theirs, "00 FF 07")]  # what was on the line before
    for turn in range(4):
        chunks += [(1 + turn, ours, LINE_REQUEST[:11]), (1.003 + turn, ours, LINE_REQUEST[12:])]
        chunks += [(1.02 + turn, theirs, LINE_RESPONSE[:14]), (1.024 + turn, theirs, LINE_RESPONSE[15:])]
    path = rig_file(save(serial(*chunks), tmp_path / "line.jsonl"))
    assert keys_of(path)["buses"]["line"]["kind"] == "modbus.rtu"
    with virtual(path) as rig:
        received: list[ModbusResponse] = []
        master = rig.attach("master").link("line")
        master.on_receive(received.append)
        master.send(ModbusRequest(0x11, bytes.fromhex(READ)))
        rig.run_for(1 * S)
        assert [answer.pdu for answer in received] == [bytes.fromhex(VALUES)]


def test_a_serial_capture_of_ascii_makes_a_line_of_ascii(tmp_path: Path) -> None:
    """The checksums are those of pymodbus."""
    texts = (b":1103006B00037E\r\n", b":110306022B0000006455\r\n")
    chunks = [(turn + place / 50, "", text.hex()) for turn in range(4) for place, text in enumerate(texts)]
    path = rig_file(save(serial(*chunks), tmp_path / "line.jsonl"))
    assert keys_of(path)["buses"]["line"]["kind"] == "modbus.ascii"
    with virtual(path) as rig:
        received: list[ModbusResponse] = []
        master = rig.attach("master").link("line")
        master.on_receive(received.append)
        master.send(ModbusRequest(0x11, bytes.fromhex(READ)))
        rig.run_for(1 * S)
        assert [answer.pdu for answer in received] == [bytes.fromhex(VALUES)]


def test_a_serial_line_that_speaks_something_else_is_left_out(tmp_path: Path) -> None:
    log = save(serial((0, "tx", "41 54 0D"), (1, "rx", "4F 4B 0D 0A")), tmp_path / "line.jsonl")
    with pytest.raises(UsageError, match="shows no device") as refused:
        content_for(log)
    assert "2 messages of the family serial" in str(refused.value)


def test_servers_of_a_network_have_units_of_their_own(tmp_path: Path) -> None:
    entries = list(exchanges((0, 1, READ, VALUES), (1, 1, READ, "03 06 0001 0002 0003")))
    entries[1] = entries[1]._replace(sender="192.168.1.5:502")
    entries[3] = entries[3]._replace(sender="192.168.1.6:502")
    with virtual(rig_file(save(entries, tmp_path / "net.jsonl"))) as rig:
        assert [rig.get(f"mb-192-168-1-{host}-unit1/h107") for host in (5, 6)] == [0x22B, 1]


def test_a_log_without_answers_has_no_device(tmp_path: Path) -> None:
    log = save(list(exchanges((0, 7, READ, None))), tmp_path / "meter.jsonl")
    with pytest.raises(UsageError, match="shows no device") as refused:
        content_for(log)
    assert "unit 7 never answered 1 request" in str(refused.value)


def read_registers(*words: int) -> str:
    return (bytes((3, 2 * len(words))) + b"".join(word.to_bytes(2, "big") for word in words)).hex()


def table_of(path: Path) -> list[dict[str, Any]]:
    entries: list[dict[str, Any]] = read((path.parent / "registers/unit7.yaml").read_text(), "").data[
        "holding_registers"
    ]
    return entries


def test_a_text_is_certain_if_it_is_long_enough(tmp_path: Path) -> None:
    words = [int.from_bytes(b"PM-3200\0"[place : place + 2], "big") for place in range(0, 8, 2)]
    path = made(tmp_path, (0, 7, "03 0000 0005", read_registers(*words, 0x4142)))
    assert [(entry["address"], entry.get("type"), entry.get("initial")) for entry in table_of(path)] == [
        (0, "string[8]", "PM-3200"),
        (4, None, 0x4142),  # two letters may be a number
    ]
    with virtual(path) as rig:
        assert ask(rig, 7, "03 0000 0005")[0] == read_registers(*words, 0x4142)


@pytest.mark.parametrize("order", ["big", "little"])
def test_a_number_of_32_bits_is_certain_if_its_low_word_is_at_chance(tmp_path: Path, order: str) -> None:
    numbers = [struct.pack(">f", 228 + 3 * math.sin(turn)) for turn in range(20)]
    words = [(int.from_bytes(data[:2], "big"), int.from_bytes(data[2:], "big")) for data in numbers]
    rows = [
        (float(turn), 7, "03 0000 0002", read_registers(*(pair if order == "big" else pair[::-1])))
        for turn, pair in enumerate(words)
    ]
    path = made(tmp_path, *rows)
    (entry,) = table_of(path)
    assert (entry["type"], entry.get("word_order", "big")) == ("f32", order)
    with virtual(path) as rig:
        for at_s, unit, request, response in rows:
            rig.run_until(round(at_s * S))
            assert ask(rig, unit, request)[0] == response


@pytest.mark.parametrize(
    "words",
    [
        [(16803 + turn % 3, 215 + turn) for turn in range(20)],  # two temperatures
        [(turn * 7000 >> 16, turn * 7000 & 0xFFFF) for turn in range(40)],  # a counter
    ],
)
def test_numbers_of_16_bits_and_counters_are_no_such_number(tmp_path: Path, words: list[tuple[int, int]]) -> None:
    rows = [(float(turn), 7, "03 0000 0002", read_registers(*pair)) for turn, pair in enumerate(words)]
    assert [entry.get("type") for entry in table_of(made(tmp_path, *rows))] == [None, None]


PDUS = st.one_of(
    st.binary(min_size=1, max_size=12),
    st.builds(
        lambda head, rest: bytes(head) + rest,
        st.lists(st.integers(0, 6), min_size=5, max_size=5),
        st.binary(max_size=8),
    ),
)


@pytest.mark.parametrize("function", [1, 2, 3, 4, 5, 6, 15, 16, 22, 23])
def test_a_request_that_is_cut_but_answered_reads_nothing(tmp_path: Path, function: int) -> None:
    """A server of the log may answer what has no meaning."""
    cut, whole = bytes([function]), bytes([3, 0, 0, 0, 1])
    log = save(
        list(exchanges((0.0, 1, cut.hex(), cut.hex()), (0.1, 1, whole.hex(), bytes([3, 2, 0, 7]).hex()))),
        tmp_path / "cut.jsonl",
    )
    with virtual(rig_file(log)) as rig:
        rig.run_until(100 * MS)


@pytest.mark.long
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.integers(0, 255), PDUS, st.none() | PDUS), max_size=12))
def test_any_messages_make_a_valid_rig_or_a_refusal(
    tmp_path: Path, rows: list[tuple[int, bytes, bytes | None]]
) -> None:
    texts = [
        (place / 10, unit, asked.hex(), None if answer is None else answer.hex())
        for place, (unit, asked, answer) in enumerate(rows)
    ]
    log = save(list(exchanges(*texts)), tmp_path / "any.jsonl")
    try:
        path = rig_file(log)
    except UsageError:
        return
    with virtual(path) as rig:
        rig.run_until(100 * MS)


@given(st.lists(st.tuples(st.sampled_from(["", "tx", "rx"]), st.binary(max_size=20)), max_size=20))
def test_any_bytes_of_a_serial_line_are_frames_or_skipped(chunks: list[tuple[str, bytes]]) -> None:
    line = RtuLine()
    entries = [
        TraceEntry(place * MS, "line", "serial", side, b"\0" + data) for place, (side, data) in enumerate(chunks)
    ]
    messages = [message for entry in entries for message in line.take(entry)]
    assert len(messages) == line.frames
    assert line.skipped <= sum(len(data) for _, data in chunks)
