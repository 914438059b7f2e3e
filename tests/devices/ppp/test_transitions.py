"""The automaton against the table of RFC 1661 4.1, cell by cell."""

from typing import Final

import pytest

from fieldrig.clock import S, VirtualClock
from fieldrig_devices.ppp.automaton import TIMED, Automaton
from fieldrig_devices.ppp.packets import Packet
from fieldrig_devices.ppp.transitions import TRANSITIONS, Event, PppState

# The two halves of the table as the RFC prints them.
FIRST_STATES: Final = """
 Up   |    2     irc,scr/6     -         -         -         -
 Down |    -         -         0       tls/1       0         1
 Open |  tls/1       1     irc,scr/6     3r        5r        5r
 Close|    0       tlf/0       2         2         4         4
  TO+ |    -         -         -         -       str/4     str/5
  TO- |    -         -         -         -       tlf/2     tlf/3
 RCR+ |    -         -       sta/2 irc,scr,sca/8   4         5
 RCR- |    -         -       sta/2 irc,scr,scn/6   4         5
 RCA  |    -         -       sta/2     sta/3       4         5
 RCN  |    -         -       sta/2     sta/3       4         5
 RTR  |    -         -       sta/2     sta/3     sta/4     sta/5
 RTA  |    -         -         2         3       tlf/2     tlf/3
 RUC  |    -         -       scj/2     scj/3     scj/4     scj/5
 RXJ+ |    -         -         2         3         4         5
 RXJ- |    -         -       tlf/2     tlf/3     tlf/2     tlf/3
 RXR  |    -         -         2         3         4         5
"""
LAST_STATES: Final = """
 Up   |    -         -         -           -
 Down |    1         1         1         tld/1
 Open |    6         7         8           9r
 Close|irc,str/4 irc,str/4 irc,str/4 tld,irc,str/4
  TO+ |  scr/6     scr/6     scr/8         -
  TO- | tlf/3p    tlf/3p    tlf/3p         -
 RCR+ |  sca/8   sca,tlu/9   sca/8   tld,scr,sca/8
 RCR- |  scn/6     scn/7     scn/6   tld,scr,scn/6
 RCA  |  irc/7     scr/6x  irc,tlu/9   tld,scr/6x
 RCN  |irc,scr/6   scr/6x  irc,scr/8   tld,scr/6x
 RTR  |  sta/6     sta/6     sta/6   tld,zrc,sta/5
 RTA  |    6         6         8       tld,scr/6
 RUC  |  scj/6     scj/7     scj/8       scj/9
 RXJ+ |    6         6         8           9
 RXJ- |  tlf/3     tlf/3     tlf/3   tld,irc,str/5
 RXR  |    6         7         8         ser/9
"""
PACKET = Packet(9, 1)
REPLY = Packet(10, 1)
COUNTERS = ("irc", "zrc", "tls")  # what no layer sees: the timer shows the first two, and the third has no effect


def rows(half: str) -> dict[str, list[str]]:
    return {
        name.strip(): cells.split() for name, _, cells in (line.partition("|") for line in half.strip().split("\n"))
    }


FIRST, LAST = rows(FIRST_STATES), rows(LAST_STATES)
CELLS = [
    (PppState(state), Event(name), cell.rstrip("rpx"))
    for name in FIRST
    for state, cell in enumerate(FIRST[name] + LAST[name])
]


class NotingLayer:
    """Notes its actions, in the abbreviations of the RFC."""

    def __init__(self) -> None:
        self.noted: list[str] = []

    def layer_up(self, event: Event) -> None:
        self.noted.append("tlu")

    def layer_down(self, event: Event) -> None:
        self.noted.append("tld")

    def layer_finished(self, event: Event) -> None:
        self.noted.append("tlf")

    def send_request(self) -> None:
        self.noted.append("scr")

    def send_terminate_request(self) -> None:
        self.noted.append("str")

    def send_answer(self, answer: Packet) -> None:
        assert answer is REPLY
        self.noted.append("answer")

    def send_terminate_ack(self, cause: Packet) -> None:
        assert cause is PACKET
        self.noted.append("sta")

    def send_code_reject(self, cause: Packet) -> None:
        assert cause is PACKET
        self.noted.append("scj")


def automaton_in(state: PppState) -> tuple[Automaton, NotingLayer, VirtualClock]:
    layer, clock = NotingLayer(), VirtualClock()
    automaton = Automaton(clock, layer, 3 * S, 10)
    automaton.state = state
    return automaton, layer, clock


def test_the_whole_table_is_compared() -> None:
    assert len(CELLS) == len(set(PppState)) * len(set(Event)) == 160


@pytest.mark.parametrize(("state", "event", "cell"), CELLS)
def test_cell_is_as_in_the_table(state: PppState, event: Event, cell: str) -> None:
    if cell == "-":
        assert (state, event) not in TRANSITIONS
        return
    automaton, layer, _ = automaton_in(state)
    automaton.handle(event, PACKET, REPLY)
    actions, _, following = cell.rpartition("/")
    seen = [
        "answer" if action in ("sca", "scn", "ser") else action
        for action in actions.split(",")
        if action and action not in COUNTERS
    ]
    assert (layer.noted, automaton.state) == (seen, int(following))


@pytest.mark.parametrize(("state", "event", "cell"), [row for row in CELLS if "scr" in row[2] or "str" in row[2]])
def test_request_starts_the_restart_timer(state: PppState, event: Event, cell: str) -> None:
    automaton, _, clock = automaton_in(state)
    automaton.handle(event, PACKET, REPLY)
    assert clock.next_ns() == 3 * S


@pytest.mark.parametrize("state", sorted(set(PppState) - TIMED))
def test_timer_stops_in_states_without_one(state: PppState) -> None:
    automaton, _, clock = automaton_in(PppState.CLOSED)
    automaton.handle(Event.OPEN)
    assert clock.next_ns() is not None
    automaton.state = PppState.ACK_SENT if state is PppState.OPENED else PppState.REQ_SENT
    leaving = {
        PppState.OPENED: Event.ACK,
        PppState.STOPPED: Event.FATAL_REJECT,
        PppState.STARTING: Event.DOWN,
    }
    if state in leaving:
        automaton.handle(leaving[state])
    else:
        automaton.handle(Event.CLOSE)
        automaton.handle(Event.TERMINATE_ACK if state is PppState.CLOSED else Event.DOWN)
    assert automaton.state is state
    assert clock.next_ns() is None


def test_a_request_is_sent_ten_times_and_then_the_layer_is_finished() -> None:
    automaton, layer, clock = automaton_in(PppState.STARTING)
    automaton.handle(Event.UP)
    clock.advance_to(29 * S)
    assert layer.noted == ["scr"] * 10
    clock.advance_to(30 * S)
    assert (layer.noted[10:], automaton.state) == (["tlf"], PppState.STOPPED)


def test_a_terminate_request_is_sent_twice() -> None:
    automaton, layer, clock = automaton_in(PppState.OPENED)
    automaton.handle(Event.CLOSE)
    clock.advance_to(6 * S)
    assert (layer.noted, automaton.state) == (["tld", "str", "str", "tlf"], PppState.CLOSED)


def test_the_end_asked_for_by_the_peer_waits_for_one_period() -> None:
    automaton, layer, clock = automaton_in(PppState.OPENED)
    automaton.handle(Event.TERMINATE_REQUEST, PACKET)
    clock.advance_to(3 * S - 1)
    assert automaton.state is PppState.STOPPING
    clock.advance_to(3 * S)
    assert (layer.noted, automaton.state) == (["tld", "sta", "tlf"], PppState.STOPPED)


def test_an_event_that_an_action_causes_is_handled_after_the_step() -> None:
    automaton, layer, _ = automaton_in(PppState.ACK_RCVD)
    layer.layer_up = lambda event: automaton.handle(Event.CLOSE)  # type: ignore[method-assign]
    automaton.handle(Event.GOOD_REQUEST, PACKET, REPLY)
    assert (layer.noted, automaton.state) == (["answer", "tld", "str"], PppState.CLOSING)
