"""Traces of a debugger: recordings of the kernel beside each other, with the values as the program has them."""

from array import array
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plc_bench import PlcBench, task_of
from program_traces import RigTraces

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict, load
from fieldrig.errors import ControlError
from fieldrig.recording.reader import OnRows, Rows
from fieldrig.recording.signals import Column, Sort
from fieldrig.virtual.rig import Rig
from fieldrig_devices.languages.debugging.adapter import Adapter
from fieldrig_devices.languages.debugging.framing import Framer, framed
from fieldrig_devices.languages.debugging.traces import Traces, with_traces

CONFIGS = Path(__file__).parents[4] / "configs"
TEXT = """\
PROGRAM Main
VAR n : INT; on : BOOL; s : STRING := 'cold'; r : REAL; END_VAR
n := n + 1;
on := n > 3;
r := n / 2.0;
IF n = 5 THEN s := 'hot'; END_IF
END_PROGRAM
""" + task_of("Main", ms=4)


class Stub:
    """A recording whose rows the test gives."""

    def __init__(self, columns: Sequence[Column]) -> None:
        self.columns = columns
        self.is_over = False
        self.keys: list[str] = []
        self.put: OnRows

    def begin(self, keys: Sequence[str], on_rows: OnRows) -> "Stub":
        self.keys, self.put = list(keys), on_rows
        return self

    def end(self) -> None:
        self.is_over = True


def read(message: Any) -> dict[str, Any]:
    assert message["command"] == "read"
    values = {"n": 7, "x": 0.5, "group": None}
    return {
        "variables": [{"value": values[name]} if name in values else {"error": "unknown"} for name in message["names"]]
    }


def test_values_are_those_of_the_program(tmp_path: Path) -> None:
    ask = RigTraces(PlcBench(tmp_path, TEXT).run(100).rig, "max4")
    ask({"command": "write", "values": {"Main.n": 0}})
    ask({"command": "record", "names": ["Main.n", "Main.on", "Main.r", "Main.s", "Main.n"], "depth": 6})
    ask.rig.run_for(24 * MS)
    samples = [sample[1:] for sample in ask({"command": "samples"})["samples"]]
    assert samples[2:] == [[n, n > 3, n / 2, "hot" if n >= 5 else "cold", n] for n in (3, 4, 5, 6)]
    assert [type(value) for value in samples[0]] == [int, bool, float, str, int]


def test_whole_numbers_of_64_bits_have_all_their_digits(tmp_path: Path) -> None:
    """Above 2^53 a 64-bit float has no odd whole number (IEEE 754)."""
    program = tmp_path / "count.st"
    program.write_text(
        "PROGRAM PLC_PRG\nVAR n : LINT := 9007199254740900; u : ULINT := 18446744073709551000; END_VAR\n"
        "n := n + 1;\nu := u + 1;\nEND_PROGRAM\n"
    )
    scu = {"kind": "hmiscu", "model": "HMISCU6A5", "program": str(program)}
    with Rig(from_dict({"time": "virtual", "devices": {"scu": scu}}, tmp_path)) as rig:
        rig.run_for(250 * MS)
        ask = RigTraces(rig, "scu")
        ask({"command": "write", "values": {"PLC_PRG.n": 2**53 - 2, "PLC_PRG.u": 2**64 - 10}})
        ask({"command": "record", "names": ["PLC_PRG.n", "PLC_PRG.u"], "depth": 6})
        rig.run_for(70 * MS)
        samples = [sample[1:] for sample in ask({"command": "samples"})["samples"]]
    first = samples[0][0] - (2**53 - 2)
    assert samples == [[2**53 - 2 + first + step, 2**64 - 10 + first + step] for step in range(6)]


def test_traces_of_two_debuggers_are_beside_each_other_and_end_with_them(tmp_path: Path) -> None:
    rig = PlcBench(tmp_path, TEXT).run(100).rig
    hash_before = rig.trace_hash()
    one, two = RigTraces(rig, "max4"), RigTraces(rig, "max4")
    with with_traces(one, one.begin) as ask, with_traces(two, two.begin) as ask_too:
        ask({"command": "record", "trace": "a", "names": ["Main.n"]})
        ask_too({"command": "record", "trace": "a", "names": ["Main.r", "Main.n"]})
        ask({"command": "record", "trace": "b", "names": ["Main.on"]})
        assert (len(one.recordings), len(two.recordings)) == (2, 1)
        ask({"command": "record", "trace": "b", "names": []})
        assert len(one.recordings) == 1
        rig.run_for(40 * MS)
        for recordings in (one.recordings, two.recordings):
            recordings[0].flush()
        found = [each({"command": "samples", "trace": "a"}) for each in (ask, ask_too)]
        assert [sample[-1] for sample in found[0]["samples"]] == [sample[-1] for sample in found[1]["samples"]]
        assert len(found[0]["samples"]) == 10
    assert one.recordings == two.recordings == []
    assert hash_before == rig.trace_hash(), "a trace is no event"


def test_an_editor_traces_by_requests_of_the_adapter(tmp_path: Path) -> None:
    rig = PlcBench(tmp_path, TEXT).run(100).rig
    traces = RigTraces(rig, "max4")
    adapter = Adapter(traces)

    def request(command: str, **arguments: Any) -> Any:
        message = {"seq": 1, "type": "request", "command": command, "arguments": arguments}
        (response,) = Framer().feed(adapter.feed(framed(message)))
        return response["body"] if response["success"] else response["message"]

    assert request("fieldrig.record", names=["Main.n"], depth=3) == {"names": ["Main.n"]}
    rig.run_for(40 * MS)
    samples = request("fieldrig.samples")["samples"]
    assert [sample[1] - samples[0][1] for sample in samples] == [0, 1, 2]
    assert "not a variable" in request("fieldrig.record", names=["Main.x"])
    assert request("fieldrig.record", names=[]) == {"names": []}
    assert not traces.recordings


@pytest.mark.long
@pytest.mark.parametrize(
    ("file", "device", "counts", "cycle_ms"),
    [
        ("feeder.yaml", "feeder", "PLC_PRG.uiStep", 10),
        ("pam-machine.yaml", "pam", "IFV_Run", 2),
        ("arp-cell.yaml", "line", "V1", 2),
    ],
)
def test_a_trace_has_a_sample_in_each_cycle_in_every_language(
    file: str, device: str, counts: str, cycle_ms: int
) -> None:
    with Rig(load(CONFIGS / file, ["time=virtual"])) as rig:
        rig.run_for(250 * MS)
        ask = RigTraces(rig, device)
        ask({"command": "record", "names": [counts], "depth": 1_000})
        rig.run_for(100 * MS)
        times = [sample[0] for sample in ask({"command": "samples"})["samples"]]
        assert {after - before for before, after in pairwise(times)} == {cycle_ms * MS}
        assert len(times) == 100 // cycle_ms


def test_what_is_lost_is_counted_and_a_value_that_is_gone_is_none() -> None:
    stub = Stub([Column("plc/program:n", Sort.NUMBER, "", []), Column("plc/program:x", Sort.NUMBER, "", [])])
    traces = Traces(read, stub.begin)
    traces.answer({"command": "record", "names": ["n"], "trigger": {"name": "x", "level": 1, "before": 1}, "depth": 3})
    assert stub.keys == ["program:n", "program:x"]
    times, n, x = array("q", [10, 20, 30, 40]), array("d", [1, float("nan"), 3, 4]), array("d", [0, 1, 2, 3])
    stub.put(Rows("plc", (0, 1), 0, 2, times, [n, x]))
    answer = traces.answer({"command": "samples"})
    assert answer is not None
    assert (answer["lost"], answer["state"], answer["triggered_ns"]) == (2, "full", 30)
    assert answer["samples"] == [[20, None], [30, 3], [40, 4]]
    traces.end()
    assert stub.is_over


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ({"command": "samples"}, "no trace was begun"),
        ({"command": "record", "names": ["y"]}, "unknown"),
        ({"command": "record", "names": ["group"]}, "a group of values"),
        ({"command": "record", "names": ["n"], "trigger": {"name": "n", "edge": "up"}}, "expected rising, falling"),
        ({"command": "record", "names": ["n"], "trace": "t" * 65}, "expected at most 64"),
        ({"command": "record", "names": ["n"] * 33}, "expected at most 32"),
    ],
)
def test_a_wrong_question_begins_nothing(message: Any, expected: str) -> None:
    stub = Stub([])
    with pytest.raises((ValueError, ControlError), match=expected):
        Traces(read, stub.begin).answer(message)
    assert not stub.keys


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
KEYS = st.sampled_from(["trace", "names", "every", "depth", "trigger", "after"])


@given(st.sampled_from(["record", "samples"]), st.dictionaries(KEYS, JSON, max_size=4))
def test_no_question_raises_anything_but_value_error(command: str, keys: dict[str, Any]) -> None:
    traces = Traces(read, Stub([]).begin)
    traces.answer({"command": "record", "names": ["n"]})
    try:
        assert isinstance(traces.answer({**keys, "command": command}), dict)
    except (ValueError, ControlError):
        return
