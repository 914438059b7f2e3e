"""Captures of the scope take a constant memory."""

from scope_rows import rows

from fieldrig_page.scope.captures import MOST, Captures, Trace
from fieldrig_page.scope.setup import Setup
from fieldrig_page.scope.store import Track


def test_the_oldest_captures_go_and_a_number_is_never_given_twice() -> None:
    captures, track = Captures(), Track(1)
    track.add(rows([0, 1], [0.0, 1.0]))
    trace = Trace("io/a", "number", "V", (), False, track, 0)
    numbers = [captures.add(Setup(), 0, 1, None, {"io/a": trace}).number for _ in range(3 * MOST)]
    assert numbers == list(range(1, 3 * MOST + 1))
    assert [capture.number for capture in captures.all()] == numbers[-MOST:]
