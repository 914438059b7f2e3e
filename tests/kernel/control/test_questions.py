"""Questions that come faster than they are answered."""

import time
from collections import deque
from collections.abc import Callable

from fieldrig.clock import VirtualClock
from fieldrig.control.questions import AT_ONCE, MOST_QUESTIONS, Questions
from fieldrig.loop.pace import SLICE_NS, Pace


class Loop:
    def __init__(self) -> None:
        self.calls: deque[Callable[[], None]] = deque()
        self.answered: list[int] = []
        self.questions = Questions[int]("control endpoint", self.calls.append, self.answered.append)

    def turn(self) -> None:
        for _ in range(len(self.calls)):
            self.calls.popleft()()


def test_only_so_many_questions_wait_and_the_others_are_refused_at_once() -> None:
    loop = Loop()
    taken = [loop.questions.put(number) for number in range(MOST_QUESTIONS + 5)]
    assert taken == [True] * MOST_QUESTIONS + [False] * 5
    assert len(loop.calls) == 1
    assert loop.questions.reached.figures() == {"questions over the limit": 5.0}


def test_a_turn_of_the_loop_answers_some_and_every_question_has_its_turn() -> None:
    loop = Loop()
    for number in range(2 * AT_ONCE + 1):
        loop.questions.put(number)
    loop.turn()
    assert loop.answered == list(range(AT_ONCE))
    loop.turn()
    loop.turn()
    assert loop.answered == list(range(2 * AT_ONCE + 1))
    loop.turn()
    assert not loop.calls


def test_questions_wait_while_the_process_has_something_else_to_do() -> None:
    loop, clock = Loop(), VirtualClock()
    pace = loop.questions.pace = Pace(clock)
    pace.spent(time.monotonic_ns() - SLICE_NS)
    loop.questions.put(1)
    loop.turn()
    assert loop.answered == []
    clock.advance_to(time.monotonic_ns() + SLICE_NS)
    loop.turn()
    assert loop.answered == [1]
