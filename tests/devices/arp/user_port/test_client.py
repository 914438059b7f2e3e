"""The client for PCs, with a card in virtual time, over good lines and bad ones."""

import random
from dataclasses import dataclass, field

import pytest
from arp_user_port import PortBench, an_object, client, frame

from fieldrig.errors import BusError
from fieldrig_devices.arp.card_access import CardState
from fieldrig_devices.arp.user_port.client import ArpPort, RefusedByCardError
from fieldrig_devices.arp.user_port.line import NoAnswerError
from fieldrig_devices.arp.user_port.memory import FLASH, RAM
from fieldrig_devices.arp.user_port.messages import ProgramCode, Quantity, Status
from fieldrig_devices.arp.user_port.quantities import Kind, named

COUNT = "L:\nV1 += 0.001\nWAIT 0.001\nGOTO L"
LONG = an_object("\n".join(f"V{number} == {number}.5 * V1 + SQR(V2)" for number in range(1, 150)), name="LONG")


def test_the_whole_of_a_cards_life() -> None:
    bench = PortBench(COUNT, is_enabled=True)
    card = client(bench)
    assert card.number == 1
    assert (card.condition().state, card.condition().program) == (CardState.RUN, ProgramCode.RUNNING)
    card.stop()
    assert card.condition().state == CardState.STOPPED
    progress: list[tuple[int, int]] = []
    card.download(LONG, lambda done, whole: progress.append((done, whole)))
    assert progress[0] == (0, len(LONG))
    assert progress[-1] == (len(LONG), len(LONG))
    assert card.hello().name == "LONG"
    assert card.upload() == LONG
    card.run()
    card.reset()
    assert card.condition().state == CardState.RESET_COMMAND


def test_all_variables_and_flags_in_as_many_requests_as_it_takes() -> None:
    card = client(PortBench())
    values = list(range(-500, 500))
    card.set_variables(1, values)
    assert card.variables(1, 1_000) == values
    card.set_bits(Kind.FLAG, 1, [1, 0] * 100)
    assert card.bits(Kind.FLAG, 1, 320) == [1, 0] * 100 + [0] * 120
    assert card.values([Quantity(Kind.VARIABLE, number) for number in range(1, 101)]) == values[:100]


def test_one_word_sets_whatever_can_be_set() -> None:
    bench = PortBench(COUNT, is_enabled=True)
    card = client(bench)
    for text, raw in (("V9", 2_500), ("F5", 1), ("O102", 1), ("PAR1.11", 7_000), ("PAR.16", 50_000)):
        card.set(named(text), raw)
    wanted = [named(text) for text in ("V9", "F5", "O102", "PAR1.11", "PAR.16")]
    assert card.values(wanted) == [2_500, 1, 1, 7_000, 50_000]
    for text in ("I101", "POS1", "ERROR"):
        with pytest.raises(RefusedByCardError):
            card.set(named(text), 1)


def test_parameters_in_ram_and_flash() -> None:
    card = client(PortBench())
    card.set_parameter(RAM, 1, 11, 5_000)
    card.set_parameter(FLASH, 2, 11, 6_000)
    assert [card.parameters(copy, group)[11] for copy in (RAM, FLASH) for group in (1, 2)] == [
        5_000,
        6_000,
        1_000,
        6_000,
    ]
    with pytest.raises(RefusedByCardError, match="cannot be 11000"):
        card.set_parameter(RAM, 0, 1, 11_000)


def test_debugging() -> None:
    card = client(
        PortBench(
            "L:\nV1 += 1\nCALL S\nWAIT 0.01\nGOTO L\nEND\nBEG S\nV2 += 1".join(("BEG M\n", "\nEND")), is_enabled=True
        )
    )
    card.events(True)
    assert card.break_at([9, 100]) == [9]
    assert card.breakpoints() == [9]
    while (event := card.event(1.0)) is not None and event.program != ProgramCode.PAUSED:
        pass
    assert event is not None
    assert (event.line, card.place()) == (9, [9, 5])
    card.step()
    assert card.place() == [10, 5]
    card.break_at([])
    card.run()
    card.pause()
    assert card.condition().program == ProgramCode.PAUSED


def test_a_trace() -> None:
    card = client(PortBench(COUNT, is_enabled=True, user_port={"baud": 1_000_000}))
    card.trace(2, [named("V1"), named("STATE")])
    samples = [card.sample(1.0) for _ in range(50)]
    found = [sample for sample in samples if sample is not None]
    assert [sample.loop - found[0].loop for sample in found] == list(range(0, 100, 2))
    assert {(sample.values[1], sample.lost) for sample in found} == {(CardState.RUN, 0)}
    card.end_trace()
    assert card.sample(0.01) is None


@pytest.mark.long
def test_who_only_listens_shows_that_he_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fieldrig_devices.arp.user_port.line.KEEP_S", 0.0)
    bench = PortBench(COUNT, is_enabled=True, user_port={"baud": 1_000_000})
    card = client(bench)
    card.trace(1_000, [named("V1")])
    assert all(card.sample(10.0) is not None for _ in range(15))  # seconds of the card's time


# ---- lines


@dataclass
class Noise:
    """Loses, damages and doubles data on the line, by chance."""

    chance: random.Random = field(default_factory=lambda: random.Random(7))

    def __call__(self, wire: bytes) -> bytes:
        spoiled = bytearray(wire)
        match self.chance.choice(("good", "good", "good", "good", "lost", "damaged", "twice", "noise")):
            case "lost":
                return b""
            case "damaged":
                spoiled[self.chance.randrange(len(spoiled))] ^= 1 << self.chance.randrange(8)
            case "twice":
                return wire * 2
            case "noise":
                return self.chance.randbytes(5) + wire
        return bytes(spoiled)


@pytest.mark.long
def test_a_bad_line_costs_time_and_nothing_else() -> None:
    bench = PortBench("L:\nIF V2 = 0, L\nV1 += 1\nV2 == 0\nGOTO L", is_enabled=True)
    card = client(bench, Noise(), step_ms=0.01, timeout_s=0.02, retries=20)  # many times 20 ms are less than 10 s
    for count in range(1, 60):
        card.set_variables(2, [1])
        bench.run_for(5)
        assert card.variables(1, 1) == [count * 1_000]
    card.stop()
    card.download(LONG)
    assert card.upload() == LONG


@pytest.mark.long
def test_a_commit_whose_answer_is_lost_is_not_carried_out_twice() -> None:
    lost = list[bytes]()

    def lose_the_first(wire: bytes) -> bytes:
        is_answer = wire[4:5] == b"\xb2"
        if is_answer:
            lost.append(wire)
        return b"" if is_answer and len(lost) < 3 else wire

    bench = PortBench(COUNT)
    client(bench, lose_the_first, step_ms=0.01, timeout_s=0.05).download(LONG)
    assert (len(lost), len(set(lost)), bench.access.program_name) == (3, 1, "LONG")


def silent(_wire: bytes) -> bytes:
    return b""


def test_a_card_that_does_not_answer_is_reported_with_the_remedy() -> None:
    bench = PortBench()
    with pytest.raises(NoAnswerError, match="no card answers at the bench\n  check that its rig runs"):
        client(bench, silent, timeout_s=0.01, retries=1)


def test_another_number_than_expected_is_refused() -> None:
    card = client(PortBench())
    with pytest.raises(RefusedByCardError, match="number 01, not 02"):
        card.hello(2)


@pytest.mark.parametrize("port", ["/dev/no-such-port", "socket://127.0.0.1:1", "nonsense://x"])
def test_a_port_that_is_not_there(port: str) -> None:
    with pytest.raises(BusError, match="cannot open"):
        ArpPort.open(port)


def test_what_the_card_says_is_in_the_error() -> None:
    card = client(PortBench(COUNT, is_enabled=True))
    with pytest.raises(RefusedByCardError, match="the card refuses the request: the program is running") as refused:
        card.download(LONG)
    assert refused.value.status is Status.REFUSED


STRANGE = b"".join(
    map(frame, map(bytes.fromhex, ("01 02 01 82 00", "01 01 63 82 00", "01 01 01 83 00", "01 01 01 82")))
)
"""Answers of another card, to another request, to another command, and without a status."""


def test_answers_of_other_cards_and_to_other_requests_are_not_taken() -> None:
    card = client(PortBench(), lambda wire: STRANGE + wire)
    assert card.condition().state == CardState.RESET_ENABLE


def test_a_client_that_was_killed_leaves_nothing_behind_for_the_next() -> None:
    bench = PortBench(COUNT, is_enabled=True, user_port={"baud": 1_000_000})
    client(bench).trace(1, [named("V1")])
    bench.run_for(100)
    second = client(bench)
    bench.user.take()
    bench.run_for(100)
    assert bench.heard() == []
    assert second.condition().state == CardState.RUN
