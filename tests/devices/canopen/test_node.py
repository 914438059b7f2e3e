"""The node in a rig: signals on wires, points, tools, and wrong settings."""

import json
import shlex
from pathlib import Path
from typing import Any

import pytest
from canopen_bench import EDS, IO32, LEVEL_SENSOR, CanopenBench
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.config.wording import explain
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.node import CanopenNode, CanopenSettings


def test_outputs_with_signals_are_sent_at_the_start_and_when_they_change() -> None:
    bench = CanopenBench(
        signals={
            "6200:01.0": "pump",
            "6200:01.7": {"wire": "alarm"},
            "6411:01": {"wire": "valve", "unit": "1", "scale": 0.001, "offset": -0.5},
        }
    )
    assert bench.wires.take() == [Signal("pump", False), Signal("alarm", False), Signal("valve", -0.5, "1")]
    bench.write("2f 00 62 01 81 00 00 00", "2b 11 64 01 f4 01 00 00")
    assert bench.wires.take() == [Signal("pump", True), Signal("alarm", True), Signal("valve", 0.0, "1")]
    bench.write("2f 00 62 01 83 00 00 00")
    assert bench.wires.take() == []


@pytest.mark.parametrize("no_number", ["00 00 c0 7f", "00 00 80 7f", "00 00 80 ff"])
def test_a_wire_keeps_its_value_when_a_master_writes_what_is_no_number(no_number: str) -> None:
    bench = CanopenBench(LEVEL_SENSOR, signals={"6148:01": {"wire": "span", "unit": "m"}})
    bench.wires.take()
    bench.write("23 48 61 01 00 00 80 3f", f"23 48 61 01 {no_number}")
    assert bench.wires.take() == [Signal("span", 1.0, "m")]


def test_inputs_with_signals_follow_their_wires() -> None:
    bench = CanopenBench(
        signals={
            "6000:01.0": "full",
            "6000:01.7": "empty",
            "6401:01": {"wire": "level", "unit": "m", "scale": 0.001},
            "6401:02": {"wire": "level", "scale": 0.01, "offset": 1.0},
        }
    )
    assert bench.wires.interest == ["empty", "full", "level"]
    bench.send("000#01 05")
    bench.wires.deliver(Signal("empty", True))
    bench.wires.deliver(Signal("full", True))
    bench.wires.deliver(Signal("level", 1.2345, "m"))
    assert bench.after(0) == ["185#81 00 00 00"]
    assert (bench.point("6401:01"), bench.point("6401:02")) == (1234, 23)
    bench.wires.deliver(Signal("full", False))
    assert bench.after(0) == ["185#80 00 00 00"]


@pytest.mark.parametrize(("value", "raw"), [(1e9, 32767), (-1e9, -32768), (0.0004, 0), (True, 1000)])
def test_input_is_rounded_and_kept_within_its_type(value: float, raw: int) -> None:
    bench = CanopenBench(signals={"6401:01": {"wire": "level", "scale": 0.001}})
    bench.wires.deliver(Signal("level", value))
    assert bench.point("6401:01") == raw


@pytest.mark.parametrize("signal", [Signal("level", float("nan"), "m"), Signal("level", 1.0, "ft"), Signal("other", 1)])
def test_signal_that_makes_no_sense_changes_nothing(signal: Signal) -> None:
    bench = CanopenBench(signals={"6401:01": {"wire": "level", "unit": "m"}})
    bench.wires.deliver(signal)
    assert bench.point("6401:01") == 0


def test_level_sensor_sends_its_level() -> None:
    bench = CanopenBench(
        LEVEL_SENSOR,
        signals={
            "6130:01": {"wire": "level", "unit": "m"},
            "9130:01": {"wire": "level", "unit": "m", "scale": 0.001},
        },
    )
    assert bench.send("000#01 05") == ["705#00", "185#00 00 00 00 00"]
    bench.wires.deliver(Signal("level", 1.5, "m"))
    assert bench.after(10) == ["185#dc 05 00 00 00"]
    assert bench.sdo("40 30 61 01 00 00 00 00") == "43 30 61 01 00 00 c0 3f"
    assert bench.after(1000) == ["185#dc 05 00 00 00"]


def test_direction_can_be_told() -> None:
    bench = CanopenBench(
        signals={"6200:01": {"wire": "in", "direction": "in"}, "6000:01": {"wire": "o", "direction": "out"}}
    )
    assert bench.wires.take() == [Signal("o", 0)]
    bench.wires.deliver(Signal("in", 5))
    assert bench.point("6200:01") == 5


def test_points_show_every_variable_and_set_what_the_network_may_not(bench: CanopenBench) -> None:
    assert bench.point("1008:00") == "IO32"
    assert bench.point("nmt.state") == "pre_operational"
    bench.set("6000:01", 3)
    assert bench.sdo("40 00 60 01 00 00 00 00") == "4f 00 60 01 03 00 00 00"
    assert bench.node.points()["6000:01"].about == "Read inputs byte 1"


@pytest.mark.parametrize(
    ("key", "value"),
    [("6000:01", 256), ("6000:01", -1), ("6000:01", 1.5), ("6000:01", "1"), ("1008:00", 5), ("6443:01", 2)],
)
def test_points_refuse_what_the_variable_cant_hold(bench: CanopenBench, key: str, value: Any) -> None:
    with pytest.raises(ValueError, match=r"is not|beyond|of at most"):
        bench.set(key, value)


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"node_id": 0}, "greater than or equal to 1"),
    ({"node_id": 128}, "less than or equal to 127"),
    ({"eds": "nowhere.eds"}, "no such file"),
    ({"signals": {"6200": "wire"}}, r"expected '6200:01', or '6200:01\.3'"),
    ({"signals": {"6200:05": "wire"}}, "object 6200h has 6200:00, 6200:01, 6200:02, 6200:03, 6200:04"),
    (
        {"signals": {"6201:01": "wire"}},
        "nearest objects are 6200h, 6202h, 6206h|nearest objects are 6008h, 6200h, 6202h",
    ),
    ({"signals": {"6200:01.8": "wire"}}, "UNSIGNED8 has no bit 8; expected 0 to 7"),
    ({"signals": {"1008:00": "wire"}}, "VISIBLE_STRING; expected an object that holds a number"),
    ({"signals": {"6411:01": {"wire": "w", "scale": 0}}}, "scale other than 0"),
    (
        {"objects": {"1017:00": 70000}},
        r"objects\.1017:00: 70000 is not UNSIGNED16: expected a whole number from 0 to 65535",
    ),
    ({"objects": {"1017": 1}}, "such as '6200:01'"),
    ({"speed": 1}, "Extra inputs are not permitted"),
]


@pytest.mark.parametrize(("wrong", "message"), WRONG)
def test_wrong_settings_are_refused_with_what_was_expected(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        CanopenSettings.model_validate({"node_id": 5, "eds": str(IO32)} | wrong, context={"folder": EDS})


def test_every_wrong_object_and_signal_is_reported_at_its_key() -> None:
    wrong = {
        "node_id": 5,
        "eds": str(IO32),
        "objects": {"1017": 1, "1017:00": 500, "5555:00": 3},
        "signals": {"6200:01.8": "a", "6200:01.7": "b", "6401:01": {"wire": "c", "scale": 0}},
    }
    with pytest.raises(ValidationError) as caught:
        CanopenSettings.model_validate(wrong, context={"folder": EDS})
    found = explain(caught.value, wrong, CanopenSettings)
    assert [mistake.path for mistake in found] == [
        ("objects", "1017"),
        ("objects", "5555:00"),
        ("signals", "6200:01.8"),
        ("signals", "6401:01"),
    ]


def test_settings_put_values_in_place_of_the_eds() -> None:
    bench = CanopenBench(serial_number=4711, objects={"1017:00": 500, "1008:00": "press"})
    bench.play(
        [
            ("40 18 10 04 00 00 00 00", "43 18 10 04 67 12 00 00"),
            ("40 17 10 00 00 00 00 00", "4b 17 10 00 f4 01 00 00"),
        ]
    )
    assert bench.point("1008:00") == "press"


class Reachable:
    def python_can(self) -> dict[str, Any]:
        return {"interface": "socketcand", "host": "127.0.0.1", "port": 29536, "channel": "can0"}


class Unreachable:
    def python_can(self) -> None:
        return None


def test_tools_are_complete_shell_lines(tmp_path: Path) -> None:
    links: Any = {"can": Reachable()}
    read, start = CanopenNode.tools("io", CanopenBench().settings, links)
    program, option, code = shlex.split(read.line)
    assert (program, option) == ("python", "-c")
    assert code == (
        "import canopen; n = canopen.Network(); "
        "n.connect(interface='socketcand', host='127.0.0.1', port=29536, channel='can0'); "
        f"node = n.add_node(5, '{IO32.absolute()}'); print(node.sdo[0x1008].raw); n.disconnect()"
    )
    assert "node.nmt.state = 'OPERATIONAL'; n.disconnect()" in start.line


def test_node_without_a_number_is_given_one_by_its_line(tmp_path: Path) -> None:
    settings = CanopenSettings.model_validate({"node_id": None, "eds": str(IO32), "serial_number": 7})
    links: Any = {"can": Reachable()}
    (tool,) = CanopenNode.tools("io", settings, links)
    assert tool.label == "node-ID 127 by LSS"
    assert "n.lss.send_switch_state_selective(0, 32, 65536, 7); n.lss.configure_node_id(127); " in tool.line


@pytest.mark.parametrize("links", [{}, {"can": object()}, {"can": Unreachable()}])
def test_no_tools_without_a_way_in(links: Any) -> None:
    assert CanopenNode.tools("io", CanopenBench().settings, links) == []


def test_odd_file_names_are_quoted(tmp_path: Path) -> None:
    odd = tmp_path / 'it\'s "$HOME".eds'
    odd.write_bytes(IO32.read_bytes())
    links: Any = {"can": Reachable()}
    line = CanopenNode.tools("io", CanopenBench(odd).settings, links)[0].line
    assert json.dumps(odd.name)[1:-1].replace("\\", "") in shlex.split(line)[2].replace("\\", "")


SIGNALS = {"6401:01": {"wire": "level", "scale": 0.5}, "6000:01.3": "bit"}


@pytest.mark.long
@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(["level", "bit"]), st.one_of(st.booleans(), st.integers(), st.floats()))))
def test_no_signal_raises(values: list[tuple[str, Any]]) -> None:
    bench = CanopenBench(signals=SIGNALS)
    for name, value in values:
        bench.wires.deliver(Signal(name, value))
    level = bench.point("6401:01")
    assert isinstance(level, int)
    assert -32768 <= level <= 32767
