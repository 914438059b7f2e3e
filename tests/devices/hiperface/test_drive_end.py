"""The drive's side: what it asks at start, what fails by which name, and that the line takes its time."""

from collections.abc import Callable
from dataclasses import dataclass

import pytest
from hiperface_bench import PLATE, crc16
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, VirtualClock
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_devices.hiperface.client import Failure, Motor, MotorError, read_plate, read_position, write_plate
from fieldrig_devices.hiperface.conversation import AnsweredError, Conversation, NoAnswerError
from fieldrig_devices.hiperface.drive_end import EncoderEnd, built_in
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder, eeprom_with
from fieldrig_devices.hiperface.line import InternalLine
from fieldrig_devices.hiperface.shaft import INCREMENTS, STEPS, TYPES, Turning, TypeName, increments_of
from fieldrig_devices.hiperface.telegram import Status


def encoder(
    kind: TypeName = "multi_turn", turns: float = 3.25, on_change: Callable[[], None] = lambda: None
) -> HiperfaceEncoder:
    return HiperfaceEncoder(TYPES[kind], eeprom_with(PLATE), lambda _now_ns: Turning(turns), on_change=on_change)


class Bench:
    """A drive's end at an encoder built in."""

    def __init__(self, there: HiperfaceEncoder, motor_type: str | None = None) -> None:
        self.clock = VirtualClock()
        self.encoder = there
        self.end = built_in(self.clock, there, motor_type)
        self.end.start()

    def read(self) -> Motor | Failure:
        found = list[Motor | Failure]()
        self.end.read_motor(found.append)
        self.clock.advance_to(self.clock.now_ns() + 5000 * MS)
        [result] = found
        return result


@pytest.mark.manual("PD-170")
def test_drive_knows_its_motor_within_half_a_second() -> None:
    bench = Bench(encoder())
    ended = list[int]()
    bench.end.read_motor(lambda _found: ended.append(bench.clock.now_ns()))
    bench.clock.advance_to(5000 * MS)
    assert bench.end.motor is not None
    assert bench.end.motor.plate == PLATE
    assert bench.end.motor.encoder.type_code == 0x27
    assert bench.end.motor.encoder.serial_number == "FR0000001"
    assert bench.end.motor.steps == 3 * 32768 + 8192
    assert ended[0] < 500 * MS


@pytest.mark.manual("PD-173", "PD-174")
def test_position_is_told_in_increments_of_the_drive() -> None:
    bench = Bench(encoder(turns=4095.5))
    found = list[int | None]()
    bench.end.read_position(found.append)
    bench.clock.advance_to(1000 * MS)
    assert found == [4_095_500_000]


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.integers(0, 4096 * 32768 - 1))
def test_increments_lie_within_their_step(steps: int) -> None:
    assert increments_of(steps) * STEPS // INCREMENTS == steps


def test_line_takes_its_time() -> None:
    clock = VirtualClock()
    line = InternalLine(clock)
    heard = list[tuple[int, SerialMessage]]()
    line.ends[1].on_receive(lambda message: heard.append((clock.now_ns(), message)))
    line.ends[0].send(b"abc")
    clock.advance_to(1000 * MS)
    times = [11 * 1_000_000_000 * place // 9600 for place in (1, 2, 3)]
    assert heard == list(zip(times, (b"a", b"b", b"c"), strict=True))


def break_memory(there: HiperfaceEncoder) -> None:
    there.requests.trouble.is_memory_dead = lambda: True


def silence(there: HiperfaceEncoder) -> None:
    there.requests.trouble.is_silent = lambda: True


def garble(there: HiperfaceEncoder) -> None:
    there.requests.trouble.is_garbling = lambda: True


def lose_the_field(there: HiperfaceEncoder) -> None:
    there.eeprom.fields.clear()


def blank(there: HiperfaceEncoder) -> None:
    there.eeprom.fields[0].data[:] = b"\xff" * 128


def age(there: HiperfaceEncoder) -> None:
    there.eeprom.fields[0].data[50] ^= 1


def rewrite(there: HiperfaceEncoder) -> None:
    there.eeprom.fields[0].data[:16] = b"Another owner's!"


def shrink(there: HiperfaceEncoder) -> None:
    there.eeprom.fields[0].status &= ~7
    del there.eeprom.fields[0].data[16:]


def change_the_code(there: HiperfaceEncoder) -> None:
    there.eeprom.codes[0] = 0x12


def damage_the_table(there: HiperfaceEncoder) -> None:
    there.requests.report(Status.PARTITION)


def renew(there: HiperfaceEncoder) -> None:
    body = b"FRNP\x02" + there.eeprom.fields[0].data[5:98]
    there.eeprom.fields[0].data[:100] = body + crc16(body)


def count_otherwise(there: HiperfaceEncoder) -> None:
    """A right plate of a resolver (manual 6933), which the drive cannot count by."""
    there.eeprom.fields[0].data[:] = PLATE.model_copy(update={"encoder_increments": 65_000}).encode()


@pytest.mark.manual("PD-171", "PD-173")
@pytest.mark.parametrize(
    ("do", "failure"),
    [
        (silence, Failure.NO_ANSWER),
        (garble, Failure.UNREADABLE),
        (break_memory, Failure.UNREADABLE),
        (change_the_code, Failure.UNREADABLE),
        (damage_the_table, Failure.UNREADABLE),
        (lose_the_field, Failure.MISSING),
        (blank, Failure.MISSING),
        (age, Failure.CHECKSUM),
        (rewrite, Failure.FOREIGN),
        (renew, Failure.FOREIGN),
        (shrink, Failure.FOREIGN),
        (count_otherwise, Failure.FOREIGN),
    ],
)
def test_what_is_wrong_has_a_name(do: Callable[[HiperfaceEncoder], None], failure: Failure) -> None:
    bench = Bench(encoder())
    do(bench.encoder)
    assert bench.read() is failure
    assert bench.end.failure is failure
    assert bench.end.why.startswith(failure.value)
    plates = list[object]()
    bench.end.read_plate(plates.append)
    bench.clock.advance_to(bench.clock.now_ns() + 5000 * MS)
    assert plates[0] is None or do is damage_the_table  # that was reported once


@pytest.mark.manual("PD-171")
def test_another_motor_is_refused() -> None:
    assert isinstance(Bench(encoder(), "SM-100/30/080").read(), Motor)
    assert Bench(encoder(), "SM-140/30/200").read() is Failure.SWAPPED
    assert Bench(encoder("single_turn")).read() is Failure.SWAPPED  # the plate is of a multi-turn one


def test_trouble_that_passes_is_overcome() -> None:
    bench = Bench(encoder())
    strikes = iter([True, False] * 100)
    bench.encoder.requests.trouble.is_garbling = lambda: next(strikes)
    assert isinstance(bench.read(), Motor)


def test_warnings_do_not_matter() -> None:
    bench = Bench(encoder())
    bench.encoder.requests.set_temperature(120)
    assert isinstance(bench.read(), Motor)


def test_drive_without_an_encoder_gives_up() -> None:
    clock = VirtualClock()
    found = list[Motor | Failure]()
    end = EncoderEnd(clock, InternalLine(clock).ends[0])
    end.read_motor(found.append)
    end.read_position(lambda position: found.append(Failure.NO_ANSWER) if position is None else None)
    clock.advance_to(1000 * MS)
    assert found == [Failure.NO_ANSWER, Failure.NO_ANSWER]


def test_plate_is_written_and_half_a_plate_is_none() -> None:
    kept = [PLATE.encode()]
    there = encoder(on_change=lambda: kept.append(bytes(there.eeprom.fields[0].data)))
    bench = Bench(there)
    other = PLATE.model_copy(update={"serial_number": "17-0002"})
    done = list[Conversation[None]]()
    bench.end.ask(write_plate(other), done.append)
    bench.clock.advance_to(5000 * MS)
    done[0].result()
    assert kept[-1] == other.encode()
    assert len(kept) > 3
    assert all(between[:6] == b"\xff" * 6 for between in kept[1:-1])


def test_plate_that_is_read_back_otherwise_was_not_written() -> None:
    there = encoder()
    there.requests.trouble.plate = lambda _field: PLATE.encode()
    bench = Bench(there)
    done = list[Conversation[None]]()
    bench.end.ask(write_plate(PLATE.model_copy(update={"serial_number": "17-0002"})), done.append)
    bench.clock.advance_to(5000 * MS)
    with pytest.raises(MotorError, match="differs from the one written") as wrong:
        done[0].result()
    assert wrong.value.failure is Failure.CHECKSUM


def test_late_bytes_of_an_answer_that_was_given_up_put_the_next_request_off() -> None:
    """The drive does not take late characters for an answer."""
    talk = Conversation(read_position())
    request = talk.due(0)
    over = talk.next_ns()
    assert over is not None
    assert talk.due(over) == b""
    again = talk.next_ns()
    assert again is not None
    late = again - MS
    talk.receive(late, bytes.fromhex("40 42 00 00"))
    assert talk.due(again) == b""
    assert talk.next_ns() == late + 6 * MS
    assert talk.due(late + 6 * MS) == request
    talk.receive(late + 20 * MS, bytes.fromhex("40 42 00 00 00 07 05"))
    assert talk.result() == 7


def test_plate_is_written_into_an_empty_memory() -> None:
    there = encoder()
    there.eeprom.fields.clear()
    bench = Bench(there)
    done = list[Conversation[None]]()
    bench.end.ask(write_plate(PLATE), done.append)
    bench.clock.advance_to(5000 * MS)
    done[0].result()
    assert bytes(there.eeprom.fields[0].data) == PLATE.encode()
    assert there.eeprom.fields[0].status == 0xCF


def test_write_protection_is_told() -> None:
    there = encoder()
    there.eeprom.fields[0].status &= ~0x40
    bench = Bench(there)
    done = list[Conversation[None]]()
    bench.end.ask(write_plate(PLATE), done.append)
    bench.clock.advance_to(5000 * MS)
    with pytest.raises(AnsweredError, match="must not be written"):
        done[0].result()


@dataclass
class Noisy:
    """The bytes that a drive receives, written by hand."""

    conversation: Conversation[object]
    now_ns: int = 0

    def run(self, replies: list[bytes]) -> None:
        for reply in [*replies, *[b""] * 40]:
            if self.conversation.is_done:
                return
            self.conversation.due(self.now_ns)
            self.now_ns += 3 * MS
            self.conversation.receive(self.now_ns, reply)
            next_ns = self.conversation.next_ns()
            self.now_ns = max(self.now_ns, next_ns or 0)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(st.binary(max_size=20) | st.binary(max_size=8).map(lambda data: b"\x40\x4c" + data), max_size=12))
def test_garbage_at_the_drive_ends_in_a_name(replies: list[bytes]) -> None:
    conversation: Conversation[object] = Conversation(read_plate())
    Noisy(conversation).run(replies)
    assert conversation.is_done
    with pytest.raises((NoAnswerError, AnsweredError, ValueError)):
        conversation.result()


def test_noise_before_an_answer_is_passed_over() -> None:
    conversation: Conversation[object] = Conversation(read_plate())
    assert conversation.due(0) == bytes.fromhex("40 4c 00 0c")
    conversation.receive(5 * MS, bytes.fromhex("00 40 40 17 40 4c 00 cf c3"))
    assert conversation.due(11 * MS) == bytes.fromhex("40 4a 00 00 06 55 59")


@pytest.mark.parametrize(("status", "check"), [(0x0A, 0x9A), (0x09, 0x99)], ids=["checksum", "parity"])
@pytest.mark.parametrize("refusals", [2, 3])
def test_a_request_that_reached_the_encoder_garbled_is_repeated(status: int, check: int, refusals: int) -> None:
    """The encoder says by its status that it has understood nothing, and so it has done nothing."""
    conversation = Conversation(read_position(), retries=2)
    now_ns = 0
    for _ in range(refusals):
        now_ns = conversation.next_ns() or 0
        assert conversation.due(now_ns) == bytes.fromhex("404202")
        conversation.receive(now_ns + MS, bytes((0x40, 0xD0, status, check)))
    if refusals == 2:
        now_ns = conversation.next_ns() or 0
        assert conversation.due(now_ns) == bytes.fromhex("404202")
        conversation.receive(now_ns + MS, bytes.fromhex("40420001020302"))
        assert conversation.result() == 0x010203
    else:
        with pytest.raises(AnsweredError, match=f"refuses 42h with status {status:02X}h"):
            conversation.result()


def test_another_refusal_is_final() -> None:
    conversation = Conversation(read_position())
    assert conversation.due(0) == bytes.fromhex("404202")
    conversation.receive(MS, bytes.fromhex("40D01E8E"))  # the encoder is too hot
    with pytest.raises(AnsweredError, match="1Eh, encoder too hot"):
        conversation.result()
