"""Captures of the scope take a constant memory."""

from scope_rows import rows

from fieldrig_page.scope.captures import MOST, Captures, Trace
from fieldrig_page.scope.export import exported
from fieldrig_page.scope.setup import Setup
from fieldrig_page.scope.store import Track


def test_signals_are_in_the_order_of_the_set_up_whatever_process_they_come_from() -> None:
    traces = {name: Trace(name, "number", "V", (), False, Track(1), 0) for name in ("io/b", "io/c", "io/a")}
    capture = Captures().add(Setup(signals=("io/a", "io/b", "io/c")), 0, 1, None, traces)
    assert list(capture.traces) == ["io/a", "io/b", "io/c"]


def test_the_oldest_captures_go_and_a_number_is_never_given_twice() -> None:
    captures, track = Captures(), Track(1)
    track.add(rows([0, 1], [0.0, 1.0]))
    trace = Trace("io/a", "number", "V", (), False, track, 0)
    numbers = [captures.add(Setup(signals=("io/a",)), 0, 1, None, {"io/a": trace}).number for _ in range(3 * MOST)]
    assert numbers == list(range(1, 3 * MOST + 1))
    assert [capture.number for capture in captures.all()] == numbers[-MOST:]


def test_a_value_that_holds_since_before_the_picture_is_in_its_files() -> None:
    track = Track(1)
    track.add(rows([0, 7], [0.0, 1.0]))
    track.known_ns = 40
    traces = {
        "wires/lamp": Trace("wires/lamp", "truth", "", (), True, track.cut([0], 10, 40), 0),
        "io/mode": Trace("io/mode", "text", "", ("off", "on"), True, track.cut([0], 10, 40), 0),
        "io/volts": Trace("io/volts", "number", "V", (), False, track.cut([0], 10, 40), 0),
    }
    capture = Captures().add(Setup(signals=tuple(traces)), 10, 40, None, traces)
    assert exported(capture, "csv").decode().split() == [
        "time_s,wires/lamp,io/mode,io/volts",
        "[V]",
        "0.000000000,1,on,",
    ]
    assert exported(capture, "vcd").endswith(b'$end\n1!\nson "\n')
