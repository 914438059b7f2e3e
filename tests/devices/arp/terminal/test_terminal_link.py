"""The card's side of the terminal, with a terminal on the same bus: bytes, order, loss, and the program's view."""

from collections.abc import Callable

import pytest
from arp_terminal import NODE_ID, CardAtTerminal, CellBench

from fieldrig.clock import MS, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.card import Shown
from fieldrig_devices.arp.terminal.jobs import MAX_WAITING
from fieldrig_devices.arp.terminal.link import TerminalLink

CAN_ERROR = 106

# CiA 302-2: pre-operational, heartbeat 500 ms (twice, since the terminal has booted meanwhile), start; then what the
# terminal tells when it starts, its LEDs, and an empty screen.
TAKEN_UP = [
    "000#80 14",
    "614#2b 17 10 00 f4 01 00 00",
    "594#60 17 10 00 00 00 00 00",
    "614#2b 17 10 00 f4 01 00 00",  # for the first heartbeat, which follows the answer
    "000#01 14",
    "000#01 14",
    "594#60 17 10 00 00 00 00 00",
    "194#00 00 00 00",
    "294#00 00 00 00 00 00 00",
    "214#00",
    "314#00 00 01 00 00 01",
]

# Instructions of a program, and the frames that they cause; answers of SDO are left out.
INSTRUCTIONS = [
    ("TERM", ["314#00 00 01 00 00 01"]),
    ("TERM 6, 8", ["314#06 08 01 00 00 02"]),
    ("TERM 4, 1, 1, 35", ["314#04 01 01 23 00 03"]),
    ("V4 == 500\nTERM 6, 4, 2, V4", ["314#06 04 02 f4 01 03"]),
    ("V100 == 12.5\nTERM 5, 2, 2, 2, V100", ["314#05 02 02 02 00 04", "414#05 02 d4 30 00 00"]),
    ("V100 == 12.5\nTERM 5, 2, 2, 2, V100, E", ["314#05 02 02 02 00 05", "414#05 02 d4 30 00 00"]),
    ("V100 == 0 - 1\nTERM 6, 8, 3, 24, V100, P", ["314#06 08 03 18 00 06", "414#06 08 18 fc ff ff"]),
    ("TERM 8, 16, 3, 1", ["314#08 10 03 01 00 03"]),
    ("TERM 2, 300, 1, 1", ["314#02 ff 01 01 00 03"]),
    ("PRINT 0", ["514#00 00 00 00 00 00 01"]),
    ("PRINT 35", ["514#00 00 00 00 23 00 01"]),
    ("V100 == 12.5\nPRINT 2, V100", ["514#d4 30 00 00 02 00 02"]),
    ('MSG 500, "OK!!"', ["614#23 01 21 fa 4f 4b 21 21"]),
    ('MSG 1, "AB"', ["614#2b 00 21 01 41 42 00 00"]),
    ('MSG 1, ""', ["614#21 00 21 01 00 00 00 00", "614#0f 00 00 00 00 00 00 00"]),
    ("SET F218\nSET F224", ["214#41"]),
]


@pytest.fixture
def started() -> "CellBench":
    cell = CellBench().after(100)
    assert cell.take() == TAKEN_UP
    return cell


@pytest.mark.manual("ARP-119", "ARP-013")
def test_card_takes_the_terminal_up(started: CellBench) -> None:
    assert started.rig.get("tr", "nmt.state") == "operational"
    assert started.errors.error == 0


@pytest.mark.manual("ARP-119", "ARP-115", "ARP-114", "ARP-116")
@pytest.mark.parametrize(("program", "frames"), INSTRUCTIONS)
def test_every_instruction_by_its_bytes(started: CellBench, program: str, frames: list[str]) -> None:
    started.program(program, ms=100)
    assert [frame for frame in started.take() if not frame.startswith("594#")] == frames
    assert started.errors.error == 0


@pytest.mark.manual("ARP-013")
def test_terminal_is_looked_for_under_the_node_id_of_the_parameter() -> None:
    with CellBench(card_node_id=99).after(100) as cell:
        assert cell.frames[0] == "000#80 63"
        assert cell.rig.get("tr", "nmt.state") == "pre_operational"


@pytest.mark.manual("ARP-115")
def test_what_an_instruction_asks_for_comes_after_the_messages_before_it(started: CellBench) -> None:
    started.program('MSG 1, "OLD"\nTERM 1, 1, 1, 1\nPRINT 1\nMSG 1, "NEW"\nTERM 2, 1, 1, 1\nPRINT 1')
    assert started.screen[:2] == ["OLD", "NEW"]
    assert started.rig.get("tr", "printer") == "OLD\nNEW"


@pytest.mark.manual("ARP-115")
def test_instructions_before_the_terminal_answers_are_carried_out_when_it_does() -> None:
    with CellBench() as cell:
        cell.program('MSG 1, "HELLO"\nTERM 1, 1, 1, 1', ms=100)
        assert cell.screen[0] == "HELLO"
        assert cell.errors.error == 0


@pytest.mark.manual("ARP-115")
def test_shown_variable_follows_its_value(started: CellBench) -> None:
    started.program('MSG 1, "L=##.#"\nTERM 1, 1, 1, 1, V1\nTERM 2, 1, 1, 1, V1')
    started.card.V[1] = 12_300
    started.after(40)
    assert started.screen[:2] == ["L=12.3", "L=12.3"]


@pytest.mark.manual("ARP-115")
def test_or_shows_the_value_at_the_instruction_with_the_other_setting() -> None:
    with CellBench(Readings(terminal_value="once")) as cell:
        cell.program('MSG 1, "L=##.#"\nTERM 1, 1, 1, 1, V1\nV1 == 5\nTERM 2, 1, 1, 1, V1\nV1 == 7')
        cell.after(200)
        assert cell.screen[:2] == ["L= 0.0", "L= 5.0"]
        cell.program("TERM 1, 1, 1, 1, V1")
        assert cell.screen[:2] == ["L= 7.0", "L= 5.0"]


@pytest.mark.manual("ARP-116")
def test_printed_value_is_the_one_of_the_instruction(started: CellBench) -> None:
    started.program('MSG 1, "#"\nV1 == 1\nPRINT 1, V1\nV1 == 2\nPRINT 1, V1\nV1 == 3')
    assert started.rig.get("tr", "printer") == "1\n2"


@pytest.mark.long
def test_program_that_shows_the_same_in_a_loop_costs_the_bus_nothing(started: CellBench) -> None:
    loop = 'MSG 1, "L=##.#"\nTERM 1, 1, 1, 1, V1, E\nTERM 2, 1, 1, 1, V2'
    started.program(loop)
    started.take()
    for _ in range(50):
        started.program(loop, ms=1)
    assert started.take() == []
    started.rig.set("tr", "press", "4")
    started.after(20)
    started.program(loop, ms=200)
    assert started.screen[0] == "L=   4"  # nor does it disturb the operator


@pytest.mark.long
def test_fast_changes_are_sent_at_the_pace_of_the_bus_and_the_last_one_stays(started: CellBench) -> None:
    started.program('MSG 1, "A"\nMSG 2, "B"')
    started.take()
    for _ in range(100):
        started.program("TERM 1, 1, 1, 1\nTERM 1, 1, 1, 2\nTERM\nTERM 1, 1, 1, 1\nTERM 1, 1, 1, 2", ms=1)
    started.after(60)
    assert len(started.take()) <= 6 * 3  # in each pass, a TERM that clears, and one that shows
    assert started.screen[0] == "B"
    assert started.errors.error == 0


def test_many_values_share_the_passes(started: CellBench) -> None:
    places = [(line, column) for line in range(1, 9) for column in (1, 5, 9, 13)]
    lines = [f"TERM {line}, {column}, 1, 1, V{line * 100 + column}" for line, column in places]
    started.program('MSG 1, "###"\n' + "\n".join(lines), ms=500)
    for line, column in places:
        started.card.V[line * 100 + column] = (line * 10 + column) * 1_000
    started.after(4 * 20 + 20)  # 32 values, 8 in each pass
    shown = [started.screen[line - 1].split() for line in range(1, 9)]
    assert shown == [[str(line * 10 + column) for column in (1, 5, 9, 13)] for line in range(1, 9)]


def test_values_that_change_all_the_time_get_their_turns(started: CellBench) -> None:
    lines = [f"TERM {line}, {column}, 1, 1, V{line * 10 + column}" for line in range(1, 9) for column in (1, 5, 9)]
    started.program('MSG 1, "###"\n' + "\n".join(lines), ms=510)
    started.take()
    for count in range(1, 5):
        started.card.V[11:90] = [count * 1_000] * 79
        started.after(20)
    sent = started.take()
    assert len(sent) == 4 * 8
    assert len({frame[4:9] for frame in sent}) == 24  # places


@pytest.mark.long
def test_one_pass_takes_no_more_of_the_bus_than_eight_frames_or_nine(started: CellBench) -> None:
    started.program("\n".join(f"TERM {line}, {column}, 1, 1, V1" for line in (1, 2) for column in range(1, 11)), ms=0)
    sent = [len(started.after(20).take()) for _ in range(6)]
    assert max(sent) <= 9
    assert sum(sent) == 40  # 20 places, each with its value


def test_text_that_takes_the_place_of_a_waiting_one_comes_after_its_message(started: CellBench) -> None:
    started.program('MSG 1, "FIRST"\nTERM 1, 1, 1, 1\nMSG 2, "SECOND"\nTERM 1, 1, 1, 2')
    assert started.screen[0] == "SECOND"


@pytest.mark.long
def test_loader_of_all_500_messages_loses_none(started: CellBench) -> None:
    started.program("\n".join(f'MSG {number}, "MESSAGE {number:08}"' for number in range(1, 501)), ms=3_000)
    assert [started.rig.get("tr", f"message.{number}") for number in (1, 250, 251, 500)] == [
        "MESSAGE 00000001",
        "MESSAGE 00000250",
        "MESSAGE 00000251",
        "MESSAGE 00000500",
    ]
    assert started.errors.error == 0


def test_more_than_the_card_can_remember_is_error_6(started: CellBench) -> None:
    for _ in range(MAX_WAITING):
        started.link.print_text(1, None)
    assert started.errors.error == 0
    started.link.print_text(1, None)
    assert started.errors.error == CAN_ERROR


# ---- the terminal is missing, gone, and back


@pytest.mark.manual("ARP-013")
def test_configured_terminal_that_does_not_answer_is_error_6() -> None:
    with CellBench(card_node_id=99) as cell:
        cell.after(400)
        assert cell.errors.error == 0
        cell.after(200)
        assert cell.errors.error == CAN_ERROR


@pytest.mark.long
@pytest.mark.parametrize("instruction", ['MSG 1, "A"', "TERM", "TERM 1, 1", "TERM 1, 1, 1, 1", "PRINT 0"])
def test_every_instruction_for_a_missing_terminal_is_error_6(instruction: str) -> None:
    with CellBench(card_node_id=99).after(600) as cell:
        cell.errors.clear()
        cell.program(instruction, ms=1)
        assert cell.errors.error == CAN_ERROR


class Alone:
    """The card's side alone; the test plays the terminal."""

    def __init__(self, node_id: int | None = NODE_ID, *, has_can: bool = True) -> None:
        self.clock, self.can = VirtualClock(), RecordedLink[CanFrame]()
        self.card, self.errors = CardAtTerminal(), CardErrors(lambda code: None)
        self.link = TerminalLink(
            self.clock, self.can if has_can else None, self.card.V, self.card.F, self.errors, self.card.V.__setitem__
        )
        self.link.start(node_id)

    def answer(self, *frames: str) -> list[str]:
        for frame in frames:
            identifier, data = frame.split("#")
            self.can.deliver(CanFrame(int(identifier, 16), bytes.fromhex(data)))
        self.clock.advance_to(self.clock.now_ns() + 20 * MS)
        self.link.refresh()
        return [f"{frame.identifier:03X}#{frame.data.hex(' ')}" for frame in self.can.take()]

    def silence(self, ms: int) -> None:
        for _ in range(ms // 20):
            self.answer()


HEARTBEAT_WRITTEN, HEARTBEAT, STORED = "594#60 17 10 00 00 00 00 00", "714#05", "594#60 00 21 01 00 00 00 00"


@pytest.fixture
def alone() -> Alone:
    """The terminal was found, and shows message 1 with V1."""
    alone = Alone()
    alone.answer(HEARTBEAT_WRITTEN)
    alone.link.show_text(Shown(1, 1, 1, 1, 1, "E"))
    assert alone.answer() == ["314#01 01 01 01 00 05", "414#01 01 00 00 00 00"]
    return alone


@pytest.mark.manual("ARP-013")
def test_terminal_without_heartbeat_for_a_second_is_error_6(alone: Alone) -> None:
    alone.answer(HEARTBEAT)
    alone.silence(960)
    assert alone.errors.error == 0
    alone.silence(60)
    assert alone.errors.error == CAN_ERROR


@pytest.mark.manual("ARP-064")
def test_keys_of_a_lost_terminal_are_let_go(alone: Alone) -> None:
    alone.answer("194#00 00 10 80")
    assert (alone.card.F[245], alone.card.F[256]) == (1, 1)
    alone.silence(1_100)
    assert alone.card.F[225:257] == [0] * 32


@pytest.mark.manual("ARP-115")
def test_terminal_that_is_back_gets_leds_the_screen_and_what_was_shown_meanwhile(alone: Alone) -> None:
    alone.card.F[218] = 1
    alone.answer()
    alone.silence(1_100)
    alone.can.take()
    alone.link.store_message(1, "LOST")
    alone.link.print_text(1, None)
    alone.link.show_text(Shown(2, 1, 1, 2))
    alone.card.V[1] = 3_000
    assert alone.answer("714#00") == ["614#2b 17 10 00 f4 01 00 00"]
    assert alone.answer(HEARTBEAT_WRITTEN) == [
        "000#01 14",
        "214#01",
        "314#00 00 01 00 00 01",
        "314#01 01 01 01 00 05",
        "414#01 01 b8 0b 00 00",
        "314#02 01 01 02 00 03",
    ]


def test_messages_are_sent_again_to_a_terminal_that_may_be_another(alone: Alone) -> None:
    asked = ["614#2b 00 21 01 41 42 00 00"]
    alone.link.store_message(1, "AB")
    assert alone.answer() == asked
    alone.answer(STORED)
    alone.link.store_message(1, "AB")
    assert alone.answer() == []
    alone.answer("714#00")
    alone.answer(HEARTBEAT_WRITTEN)
    alone.link.store_message(1, "AB")
    assert alone.answer() == asked


def test_message_under_way_when_the_terminal_restarts_does_not_hold_up_the_rest(alone: Alone) -> None:
    alone.link.store_message(1, "AB")
    assert alone.answer() == ["614#2b 00 21 01 41 42 00 00"]
    alone.answer("714#00")
    assert alone.errors.error == CAN_ERROR
    alone.answer(HEARTBEAT_WRITTEN)
    alone.link.store_message(1, "CD")
    assert alone.answer() == ["614#2b 00 21 01 43 44 00 00"]
    alone.link.print_text(1, None)
    assert alone.answer(STORED) == ["514#00 00 00 00 01 00 01"]


@pytest.mark.parametrize("answer", ["594#80 00 21 01 00 00 06 06", "594#80 00 21 01 30 00 09 06"])
def test_message_that_the_terminal_refuses_is_error_6_and_the_next_goes_on(alone: Alone, answer: str) -> None:
    alone.link.store_message(1, "AB")
    alone.link.print_text(1, None)
    alone.answer()
    assert alone.answer(answer) == ["514#00 00 00 00 01 00 01"]
    assert alone.errors.error == CAN_ERROR


def test_reset_of_the_program_forgets_what_waits_but_for_messages(alone: Alone) -> None:
    alone.link.store_message(1, "AB")
    alone.link.show_text(Shown(2, 1, 1, 1))
    alone.link.print_text(1, None)
    alone.link.release()
    assert alone.answer() == ["614#2b 00 21 01 41 42 00 00"]
    assert alone.answer(STORED) == []


# Edited values that are ignored: frame and reason.
NOT_EDITED = [
    ("294#01 01 00 10 27 00 00", "counter 0: the terminal has started"),
    ("294#02 01 01 10 27 00 00", "there is no text at this place"),
    ("294#01 01 01 00 ca 9a 3b", "1 000 000 000 is not a value of a variable"),
    ("294#01 01 01 10 27 00", "too short"),
    ("294#01 01 01 10 27 00 00 00", "too long"),
]


@pytest.mark.parametrize(("frame", "why"), NOT_EDITED)
def test_edit_that_can_not_be_changes_nothing(alone: Alone, frame: str, why: str) -> None:
    alone.answer(frame)
    assert not any(alone.card.V)


def test_repeated_frame_of_an_edit_counts_once(alone: Alone) -> None:
    alone.answer("294#01 01 01 10 27 00 00")
    assert alone.card.V[1] == 10_000
    alone.card.V[1] = 0
    alone.answer("294#01 01 01 10 27 00 00")
    assert alone.card.V[1] == 0
    alone.answer("294#01 01 02 10 27 00 00")
    assert alone.card.V[1] == 10_000


def test_value_that_may_not_be_changed_is_not(alone: Alone) -> None:
    alone.link.show_text(Shown(1, 1, 1, 1, 1))
    alone.answer()
    alone.answer("294#01 01 01 10 27 00 00")
    assert alone.card.V[1] == 0


@pytest.mark.parametrize("frame", ["194#01", "194#01 00 00 00 00", "194#"])
def test_keys_of_another_length_are_dropped(alone: Alone, frame: str) -> None:
    alone.answer(frame)
    assert alone.card.F[225:257] == [0] * 32


# ---- no terminal


@pytest.mark.parametrize("alone", [Alone(None), Alone(NODE_ID, has_can=False)])
@pytest.mark.manual("ARP-064")
def test_without_a_terminal_its_flags_are_the_users_and_instructions_error_6(alone: Alone) -> None:
    alone.card.F[218:257] = [1] * 39
    assert alone.answer() == []
    assert alone.card.F[218:257] == [1] * 39
    assert alone.errors.error == 0
    asks: list[Callable[[], None]] = [
        lambda: alone.link.store_message(1, "A"),
        alone.link.clear_screen,
        lambda: alone.link.erase_text(1, 1),
        lambda: alone.link.show_text(Shown(1, 1, 1, 1)),
        lambda: alone.link.print_text(0, None),
    ]
    for ask in asks:
        alone.errors.clear()
        ask()
        assert alone.errors.error == CAN_ERROR
    alone.link.release()
    assert alone.answer() == []
