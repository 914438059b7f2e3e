"""Waveforms as a value change dump.  The expected text follows IEEE 1364-2005, clause 18; vcdvcd reads it back."""

import io
import re
import signal
from itertools import groupby
from math import isnan
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from vcd_reader import VCDVCD

from fieldrig.errors import RigError
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.vcd_text import legal_paths
from fieldrig_bus.signals.codec import encode
from fieldrig_bus.traces import vcd
from fieldrig_bus.wires import Motion, Signal

DAY_NS = 1_700_000_000_123_456_789
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_$]*")
"""A simple identifier, IEEE 1364-2005, A.9.3."""


def entry(time_ns: int, signal: Signal, bus: str = "wires") -> TraceEntry:
    return TraceEntry(time_ns, bus, "wires", "plant", encode(signal))


def written(*entries: TraceEntry) -> str:
    file = io.BytesIO()
    vcd.write(entries, file, 0)
    return file.getvalue().decode("ascii")


def read_back(text: str) -> dict[str, Any]:
    """The variables of a file by their full names, as another library reads them."""
    found: Any = VCDVCD(vcd_string=text)
    return {name: found[name] for name in found.references_to_ids}


def test_the_file_is_as_the_standard_writes_it() -> None:
    text = written(
        entry(0, Signal("cell.valve", True)),
        entry(5, Signal("cell.valve", False)),
        entry(1_000_000_007, Signal("cell.count", -2)),
        entry(2_000_000_000, Signal("level", 0.25, "m")),
    )
    assert text.partition("$end\n")[2] == (
        "$timescale 1 ns $end\n"
        "$version fieldrig $end\n"
        "$scope module wires $end\n"
        "$var real 64 # level $end\n"
        "$scope module cell $end\n"
        "$var wire 1 ! valve $end\n"
        '$var integer 32 " count $end\n'
        "$upscope $end\n"
        "$upscope $end\n"
        "$enddefinitions $end\n"
        "#0\n"
        "$dumpvars\n"
        "x!\n"
        'bx "\n'
        "rnan #\n"
        "$end\n"
        "1!\n"
        "#5\n"
        "0!\n"
        "#1000000007\n"
        'b11111111111111111111111111111110 "\n'
        "#2000000000\n"
        "r0.25 #\n"
    )


def test_the_comment_has_names_units_and_the_instant_of_time_0() -> None:
    text = written(entry(DAY_NS, Signal("belt speed $end", 1.5, "m/s")))
    assert text.startswith(
        f"$comment\n\tfieldrig: instant 0 is {DAY_NS} ns\n"
        '\twires.belt_speed__end is "belt speed \\u0024end" of "wires" in "m/s"\n$end\n'
    )
    assert "#0\n" in text


def test_virtual_time_counts_from_the_start_of_the_rig() -> None:
    assert read_back(written(entry(7, Signal("a", True))))["wires.a"].tv[-1] == (7, "1")


def test_the_file_lasts_until_the_last_message_of_any_bus() -> None:
    assert written(entry(0, Signal("a", True)), TraceEntry(99, "can0", "can", "", b"")).endswith("#99\n")


def test_messages_that_are_not_values_of_wires_are_left_out() -> None:
    damaged = TraceEntry(3, "wires", "wires", "plant", b"[")
    frame = TraceEntry(4, "can0", "can", "io", b"\x01")
    file = io.BytesIO()
    assert vcd.write([entry(0, Signal("a", 1)), damaged, frame], file, 0) == 1
    assert vcd.write([], file, 0) == 0


def test_buses_that_were_recorded_side_by_side_come_into_order() -> None:
    found = read_back(written(entry(9, Signal("a", True)), entry(4, Signal("b", True), bus="other")))
    assert (found["wires.a"].tv[-1], found["other.b"].tv[-1]) == ((9, "1"), (4, "1"))


def test_a_motion_is_seen_with_its_value_at_each_new_segment() -> None:
    segments = [Motion("shaft", 0.0, "rev", 0, 2.0), Motion("shaft", 1.0, "rev", 500_000_000, -4.0)]
    text = written(*(entry(segment.time_ns, segment) for segment in segments))
    assert read_back(text)["wires.shaft"].tv[1:] == [(0, "0.0"), (500_000_000, "1.0")]


@pytest.mark.parametrize(
    ("values", "size"),
    [([1, 2], 32), ([-(2**31), True], 32), ([2**31], 64), ([-(2**63), 2**63 - 1], 64), ([2**64 - 1, -1], 65)],
)
def test_an_integer_has_bits_for_all_its_values_and_their_sign(values: list[int], size: int) -> None:
    text = written(*(entry(number, Signal("n", value)) for number, value in enumerate(values)))
    assert f"$var integer {size} " in text


def test_a_file_of_values_is_not_read_as_a_trace() -> None:
    with pytest.raises(RigError, match=r"a \.vcd file has values of wires, and no messages"):
        vcd.read(io.BytesIO())


WHOLE = st.integers(-(2**63), 2**64 - 1)
VALUES = st.one_of(
    st.lists(st.booleans(), min_size=1, max_size=8),
    st.lists(WHOLE | st.booleans(), min_size=1, max_size=8),
    st.lists(WHOLE | st.booleans() | st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=8),
)
WIRES = st.dictionaries(st.from_regex(r"[a-z_]{1,3}(\.[a-z0-9_]{1,3})?", fullmatch=True), VALUES, max_size=6)


@pytest.mark.long
@given(WIRES, st.data())
def test_every_value_survives_at_its_instant(wires: dict[str, list[Any]], data: st.DataObject) -> None:
    sent: dict[str, list[tuple[int, Any]]] = {}
    for name, values in wires.items():
        instants = data.draw(st.lists(st.integers(0, 10**15), min_size=len(values), max_size=len(values)))
        sent[name] = list(zip(sorted(instants), values, strict=True))
    entries = [entry(time_ns, Signal(name, value)) for name in sent for time_ns, value in sent[name]]
    found = read_back(written(*entries))
    paths = legal_paths(("wires", name) for name in sent)
    assert found.keys() == {".".join(path) for path in paths}
    for path, changes in zip(paths, sent.values(), strict=True):
        variable = found[".".join(path)]
        assert _is_unknown(variable.tv[0][1])
        assert [(time_ns, _number(variable, text)) for time_ns, text in variable.tv[1:]] == _without_repeats(changes)


def _is_unknown(text: str) -> bool:
    return text == "x" or isnan(float(text))


def _number(variable: Any, text: str) -> float:
    """A value as a reader takes it that knows the standard only."""
    if variable.var_type == "real":
        return float(text)
    number, size = int(text, 2), int(variable.size)
    return number - (1 << size) if variable.var_type == "integer" and number >> (size - 1) else number


def _without_repeats(changes: list[tuple[int, Any]]) -> list[tuple[int, float]]:
    """The changes of a value; a real is the nearest double."""
    is_real = any(isinstance(value, float) for _, value in changes)
    numbers = [(time_ns, float(value) if is_real else int(value)) for time_ns, value in changes]
    return [next(equal) for _, equal in groupby(numbers, key=lambda change: change[1])]


@given(st.lists(st.tuples(st.sampled_from(["w", "w.1", ""]), st.text(max_size=6)), unique=True, max_size=8))
def test_every_wire_has_a_legal_name_of_its_own(names: list[tuple[str, str]]) -> None:
    paths = legal_paths(names)
    assert len(set(paths)) == len(names)
    assert all(IDENTIFIER.fullmatch(word) for path in paths for word in path)


@given(st.text(max_size=12), st.text(max_size=8))
def test_no_name_or_unit_breaks_the_file(name: str, unit: str) -> None:
    try:
        signal = entry(0, Signal(name, True, unit))
    except ValueError:  # half of a surrogate pair
        return
    assert [variable.tv[-1] for variable in read_back(written(signal)).values()] == [(0, "1")]


def test_the_foreign_reader_leaves_broken_pipes_to_python() -> None:
    assert signal.getsignal(signal.SIGPIPE) is signal.SIG_IGN
