"""The drive's end alone, cycle by cycle: the phases that it accepts, and the telegrams that it may miss."""

from collections.abc import Sequence

import pytest

from fieldrig.clock import VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.ring.sercos.message import Cycle, RingMessage
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import Attribute, Code, Format, Length, ServiceError
from fieldrig_devices.sercos.service import ServiceClient
from fieldrig_devices.sercos.slave import SercosSlave

ADDRESS = 5
TIMES = {1: 4_000, 2: 4_000, 6: 100, 89: 400, 8: 700, 7: 3_800, 9: 1, 10: 8, 15: 4}
MDT = bytes.fromhex("ff 0000 0000 10270000")  # position 10 000


class Bare:
    def __init__(self) -> None:
        signed = Attribute(Length.FOUR, Format.SIGNED)
        self.table = IdnTable(
            [
                Datum(47, "position command value", signed),
                Datum(51, "position feedback value 1", signed),
                Datum(100, "gains", Attribute(Length.LIST_OF_WORDS), (), largest=8, maximum=1_000),
            ]
        )
        self.link = RecordedLink[RingMessage]()
        self.failures = 0
        self.heard: list[tuple[int, ...]] = []
        self.missed = 0
        self.missed_after: tuple[int, ...] = ()
        self.slave = SercosSlave(VirtualClock(), self.link, ADDRESS, self.table, self)
        self.client = ServiceClient()
        self.number = 0
        for idn, value in TIMES.items():
            self.table[idn].set(value)

    # ---- its application

    def on_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        self.heard.append(values[2:])
        return words.POWERED, bytes(4)

    def on_missed_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        self.missed += 1
        self.missed_after = values[2:]
        return words.POWERED, bytes(4)

    def status(self) -> int:
        return words.READY_FOR_POWER

    def feedback(self) -> bytes:
        return bytes(4)

    def on_phase(self, phase: int) -> None:
        """Nothing here depends on it."""

    def on_ring_failure(self) -> None:
        self.failures += 1

    def check(self, phase: int) -> list[int]:
        return []

    # ---- the ring

    def cycle(self, phase: int | None, mdt: bytes = b"") -> bytes:
        """The AT that it left.  None: no MST came."""
        self.number += 1
        self.link.deliver(Cycle(self.number, b"" if phase is None else bytes((0xFF, phase)), mdt))
        sent = self.link.take()
        at = sent[0] if sent else b""
        assert isinstance(at, bytes)
        return at

    def cycles(self, phases: Sequence[int | None], mdt: bytes = b"") -> "Bare":
        for phase in phases:
            self.cycle(phase, mdt)
        return self

    def write(self, idn: int, data: bytes) -> bytes | ServiceError:
        """Over the service channel of the present phase."""
        answers: list[bytes | ServiceError] = []
        self.client.write(idn, data, answers.append)
        status = info = 0
        for _ in range(200):
            self.client.step(status & 7, info)
            if answers:
                return answers[0]
            head = self.client.control.to_bytes(2, "little") + self.client.info.to_bytes(2, "little")
            late = self.slave.phase >= 3
            at = self.cycle(self.slave.phase, b"\xff" + head + MDT[5:] if late else bytes((ADDRESS,)) + head)
            status, info = int.from_bytes(at[1:3], "little"), int.from_bytes(at[3:5], "little")
        raise AssertionError("no answer")

    def command(self, idn: int) -> None:
        assert self.write(idn, b"\3\0") == b""
        assert self.write(idn, b"\0\0") == b""

    def in_phase(self, phase: int) -> "Bare":
        for number in range(phase + 1):
            if number >= 3:
                self.command(124 + number)
            self.cycle(number, MDT if number >= 3 else b"")
        assert self.slave.phase == phase
        return self


def test_the_way_up() -> None:
    bare = Bare().in_phase(4).cycles([4] * 3, MDT)
    assert bare.heard[-3:] == [(10_000,)] * 3
    assert (bare.slave.failures, bare.failures, bare.missed) == (0, 0, 0)


@pytest.mark.parametrize(
    ("at", "told", "failure"),
    [
        (0, 2, words.WRONG_ADVANCE),
        (1, 3, words.WRONG_ADVANCE),
        (2, 4, words.WRONG_ADVANCE),
        (2, 1, words.WRONG_RETURN),
        (3, 2, words.WRONG_RETURN),
        (4, 3, words.WRONG_RETURN),
        (4, 1, words.WRONG_RETURN),
        (2, 5, words.INVALID_PHASE),
        (4, 7, words.INVALID_PHASE),
    ],
)
def test_a_phase_that_does_not_follow_is_a_failure_wherever_it_is_told(at: int, told: int, failure: int) -> None:
    bare = Bare().in_phase(at).cycles([told], MDT)
    assert (bare.slave.phase, bare.slave.failures, bare.failures) == (0, failure, 1)
    bare.cycles([told, 1, 2])
    assert bare.slave.phase == 0, "it waits for the master to start again"
    assert bare.cycles([0, 1]).slave.phase == 1


@pytest.mark.parametrize("phase", [3, 4])
def test_a_phase_without_its_check_is_a_failure(phase: int) -> None:
    bare = Bare().in_phase(phase - 1).cycles([phase], MDT)
    assert (bare.slave.phase, bare.slave.failures, bare.failures) == (0, words.NOT_ACKNOWLEDGED, 1)


def test_a_check_counts_in_its_own_phase_only() -> None:
    """S-0-0128 in CP2 says nothing about CP3."""
    bare = Bare().in_phase(2)
    bare.write(128, b"\3\0")
    bare.write(128, b"\0\0")
    bare.command(127)
    bare.cycles([3, 4], MDT)
    assert bare.slave.failures == words.NOT_ACKNOWLEDGED


def test_a_check_does_not_outlive_the_ring() -> None:
    bare = Bare().in_phase(3).cycles([0, 1, 2, 3], MDT)
    assert bare.slave.failures == words.NOT_ACKNOWLEDGED


def test_down_to_phase_0_is_no_failure() -> None:
    bare = Bare().in_phase(4).cycles([0])
    assert (bare.slave.phase, bare.slave.failures, bare.failures) == (0, 0, 0)


def test_every_other_telegram_may_be_missing() -> None:
    bare = Bare().in_phase(4)
    for _ in range(20):
        bare.cycle(None, MDT)
        bare.cycle(4, MDT)
        bare.cycle(4, b"")
        bare.cycle(4, MDT)
    assert (bare.slave.phase, bare.failures, bare.missed) == (4, 0, 40)
    assert (bare.table[28].number, bare.table[29].number) == (20, 20)


@pytest.mark.parametrize("mdt", [MDT[:-1], MDT + b"\0", b"", b"\x05" + MDT[1:]])
def test_an_mdt_of_another_form_is_none(mdt: bytes) -> None:
    bare = Bare().in_phase(4).cycles([4], mdt)
    assert (bare.missed, bare.slave.phase) == (1, 4)
    bare.cycles([4], mdt)
    assert (bare.slave.failures, bare.failures) == (words.MDT_FAILED, 1)


def test_nine_msts_may_be_missing_before_cp3_and_then_it_begins_anew() -> None:
    bare = Bare().in_phase(2).cycles([None] * 9)
    assert bare.slave.phase == 2
    bare.cycles([2]).cycles([None] * 9)
    assert bare.slave.phase == 2
    bare.cycles([None])
    assert (bare.slave.phase, bare.failures) == (0, 0)


def test_only_the_drive_that_is_called_answers() -> None:
    bare = Bare().in_phase(1)
    assert bare.cycle(1, bytes.fromhex("06 0000 0000")) == b""
    assert bare.cycle(1, bytes.fromhex("05 0000 0000"))[0] == ADDRESS
    assert bare.cycle(1, bytes.fromhex("05 0000")) == b""


def test_counters_stop_at_their_end() -> None:
    bare = Bare().in_phase(4)
    bare.table[28].set(0xFFFF)
    bare.table[29].set(0xFFFF)
    bare.cycle(None, MDT)
    bare.cycle(4, MDT)
    bare.cycle(4, b"")
    assert (bare.table[28].number, bare.table[29].number) == (0xFFFF, 0xFFFF)


def test_half_a_number_in_a_list_is_refused() -> None:
    bare = Bare().in_phase(2)
    for data, code in ((b"\1\0\2", Code.TOO_SHORT), (b"\1\0" * 5, Code.TOO_LONG), (b"\xff\xff", Code.ABOVE_MAXIMUM)):
        answer = bare.write(100, data)
        assert isinstance(answer, ServiceError)
        assert answer.code == code
    assert bare.write(100, b"\1\0\2\0") == b""
    assert bare.table[100].numbers == [1, 2]


def test_data_without_an_end_are_refused() -> None:
    """A master that never says that this was the last element doesn't fill the drive's memory."""
    bare = Bare().in_phase(2)
    server = bare.slave._service
    handshake = server.status & 1
    server.step(0x0A | handshake ^ 1, 100)  # write the IDN
    for _ in range(20):
        server.step(0x3A | server.status & 1 ^ 1, 0)  # write data, not the last
        if server.status & 4:
            break
    assert (server.status & 4, server.info) == (4, Code.TOO_LONG)


def test_command_that_ends_meanwhile_is_shown_by_the_drive_itself() -> None:
    bare = Bare()
    commands: list[Command] = []
    bare.table.add(Datum(170, "probing cycle", Attribute(Length.TWO, is_command=True), 0))
    bare.slave.command(170, commands.append)
    bare.in_phase(4)
    assert bare.write(170, b"\3\0") == b""
    commands[0].finish()
    assert int.from_bytes(bare.cycle(4, MDT)[1:3], "little") & words.COMMAND_CHANGED


def test_both_of_two_telegrams_that_bring_it_down_are_counted() -> None:
    """S-0-0028 and S-0-0029: of more than two in a row the first two."""
    assert Bare().in_phase(4).cycles([None] * 4, MDT).table[28].number == 2
    assert Bare().in_phase(4).cycles([4] * 4, b"").table[29].number == 2


def test_counters_begin_anew_with_cp3() -> None:
    bare = Bare()
    bare.table[28].set(7)
    bare.table[29].set(8)
    bare.in_phase(3)
    assert (bare.table[28].number, bare.table[29].number) == (0, 0)


def test_interface_status_keeps_the_phase_of_a_failure_until_that_is_quitted() -> None:
    bare = Bare().in_phase(4).cycles([None] * 2, MDT)
    assert bare.table[14].number == words.MST_FAILED | 4
    bare.cycles([0, 1])
    assert bare.table[14].number == words.MST_FAILED | 4
    bare.slave.clear_failures()
    assert bare.table[14].number == 1


def test_transition_checks_are_cleared_when_the_ring_goes_down() -> None:
    bare = Bare().in_phase(2)
    bare.write(127, b"\3\0")
    assert bare.table[127].status == Command.DONE
    bare.cycles([0, 1, 2])
    assert (bare.table[127].status, bare.table[127].data) == (Command.CLEARED, b"\0\0")


def test_service_channel_is_dead_in_cp1() -> None:
    """It is set up in CP2; a drive that is called in CP1 only says that it is there."""
    bare = Bare().in_phase(1)
    at = bare.cycle(1, bytes.fromhex("05 0f00 2f00"))  # MHS, write, last, element 1: S-0-0047
    assert (at[0], at[1] & 7, at[3:5]) == (ADDRESS, 0, b"\0\0")
