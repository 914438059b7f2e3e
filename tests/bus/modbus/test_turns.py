"""Clients that ask a unit for more than it can have at a time."""

from collections import deque

from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.modbus.turns import Turns


class Asking:
    """A client with requests to these units."""

    def __init__(self, turns: Turns, name: str, sent: list[tuple[str, int]], *units: int) -> None:
        self._turns, self._name, self._sent = turns, name, sent
        self.units = deque(units)

    def go_on(self) -> None:
        while self.units and self._turns.begin(self.units[0], self):
            self._sent.append((self._name, self.units.popleft()))


def test_a_client_that_pipelines_and_one_that_does_not_take_turns() -> None:
    turns, sent = Turns(2), list[tuple[str, int]]()
    greedy, modest = Asking(turns, "greedy", sent, *[1] * 100), Asking(turns, "modest", sent, 1)
    greedy.go_on()
    modest.go_on()
    assert sent == [("greedy", 1)] * 2
    turns.end(1)
    turns.end(1)
    assert sent[2:] == [("greedy", 1), ("modest", 1)]


def test_a_unit_that_does_not_answer_delays_no_other_one() -> None:
    turns, sent = Turns(2), list[tuple[str, int]]()
    Asking(turns, "greedy", sent, *[7] * 100).go_on()
    Asking(turns, "modest", sent, 1).go_on()
    assert sent[-1] == ("modest", 1)


def test_who_leaves_is_asked_no_more() -> None:
    turns, sent = Turns(1), list[tuple[str, int]]()
    clients = [Asking(turns, name, sent, 1) for name in "abc"]
    for client in clients:
        client.go_on()
    turns.leave(clients[1])
    turns.end(1)
    assert sent == [("a", 1), ("c", 1)]


@given(st.lists(st.lists(st.integers(1, 3), max_size=20), min_size=1, max_size=5), st.integers(1, 4))
def test_every_request_gets_its_turn_and_no_unit_has_too_many(wanted: list[list[int]], most: int) -> None:
    turns, sent = Turns(most), list[tuple[str, int]]()
    clients = [Asking(turns, str(number), sent, *units) for number, units in enumerate(wanted)]
    for client in clients:
        client.go_on()
    answered = 0
    while answered < len(sent):
        open_now = [unit for _, unit in sent[answered:]]
        assert all(open_now.count(unit) <= most for unit in (1, 2, 3))
        answered += 1
        turns.end(sent[answered - 1][1])
    assert len(sent) == sum(map(len, wanted))
