"""The controller as Modbus client: values of other units in its tree, in both directions, and units that are lost."""

import itertools
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from max4_faces_bench import FacesBench, Type
from pymodbus.client.mixin import ModbusClientMixin

from fieldrig.errors import ConfigError
from fieldrig_bus.modbus.message import ModbusMessage, ModbusResponse

LOST, BACK = 6570, 8571
Answer = Callable[[bytes], bytes | None]


def words(value: Any, type: Type) -> str:
    """The registers of a value by pymodbus."""
    return b"".join(word.to_bytes(2, "big") for word in ModbusClientMixin.convert_to_registers(value, type)).hex()


def value(name: str, type: str = "u16") -> dict[str, str]:
    return {"name": name, "type": type}


READ = {
    "what": "input_registers",
    "address": 0x10,
    "values": [value("level"), value("flow", "f32"), value("count", "s32")],
    "every_ms": 100,
}
WRITE = {"address": 0x20, "values": [value("speed"), value("place", "s32")]}


class Bench:
    """Unit 7 is played by the test; what it answers is up to `answer`."""

    def __init__(self, answer: Answer, client: dict[str, Any] | None = None, **unit: Any) -> None:
        modbus_client = {"units": {"pump": {"unit": 7, "reads": [READ], **unit}}, **(client or {})}
        self.rig = FacesBench(modbus_client=modbus_client)
        self.asked: list[tuple[int, str]] = []
        self.answer = answer
        self.rig.outside.link("mb").on_receive(self._on_request, [7])

    def _on_request(self, request: ModbusMessage) -> None:
        if isinstance(request, ModbusResponse):
            self.rig.answers.append(request)
            return
        self.asked.append((self.rig.outside.clock.now_ns() // 1_000_000, request.pdu.hex()))
        answer = self.answer(request.pdu)
        if answer is not None:
            self.rig.outside.link("mb").send(ModbusResponse(7, answer, request.exchange))

    def get(self, key: str) -> Any:
        return self.rig.get(f"pump.{key}")


def answering(data: str) -> Answer:
    def answer(pdu: bytes) -> bytes:
        return pdu[:5] if pdu[0] in (15, 16) else bytes((pdu[0], len(data) // 2)) + bytes.fromhex(data)

    return answer


LEVEL = words(1234, Type.UINT16) + words(2.5, Type.FLOAT32) + words(-70_000, Type.INT32)


@pytest.mark.manual("PD-209", "PD-306")
def test_values_are_read_cyclically_into_the_tree() -> None:
    bench = Bench(answering(LEVEL))
    bench.rig.run(450)
    assert [pdu for _, pdu in bench.asked] == ["0400100005"] * 5
    times = [ms for ms, _ in bench.asked]
    assert [after - before for before, after in itertools.pairwise(times)] == [100] * 4
    assert (bench.get("level"), bench.get("flow"), bench.get("count")) == (1234, 2.5, -70_000)
    assert (bench.get("Requests"), bench.get("Errors"), bench.get("IsRunning")) == (5, 0, True)


def test_values_are_written_when_they_have_changed() -> None:
    bench = Bench(answering(""), reads=[], writes=[WRITE])
    bench.rig.run(200)
    assert [pdu for _, pdu in bench.asked] == ["100020000306000000000000"]  # what they are after the boot
    bench.rig.set("pump.speed", 500).set("pump.place", -2)
    bench.rig.run(200)
    assert [pdu for _, pdu in bench.asked[1:]] == ["100020000306" + words(500, Type.UINT16) + words(-2, Type.INT32)]


def test_values_are_written_again_and_again_if_so_set() -> None:
    bench = Bench(answering(""), reads=[], writes=[{**WRITE, "every_ms": 50}])
    bench.rig.run(320)
    assert len(bench.asked) in (6, 7)
    before = len(bench.asked)
    bench.rig.set("pump.speed", 1).run(15)
    assert bench.asked[before][1].endswith("000100000000")


def test_bits() -> None:
    read = {"what": "discrete_inputs", "address": 3, "values": [value("low", "bool"), value("high", "bool")]}
    write = {"what": "coils", "address": 9, "values": [value("run", "bool"), value("fill", "bool")]}
    bench = Bench(answering("02"), reads=[read], writes=[write])
    bench.rig.run(30)
    bench.rig.set("pump.fill", True).run(30)
    assert (bench.get("low"), bench.get("high")) == (False, True)
    assert [pdu for _, pdu in bench.asked] == ["0200030002", "0f000900020100", "0f000900020102"]


def test_a_device_of_the_rig_is_asked_on_a_serial_line(tmp_path: Any) -> None:
    table = tmp_path / "pump.yaml"
    table.write_text(
        "holding_registers:\n- {address: 32, name: speed, type: u16}\n- {address: 33, name: place, type: s32}\n"
        "input_registers:\n- {address: 16, name: level, type: u16, initial: 77}\n"
    )
    rig = FacesBench(
        buses={"line": {"kind": "modbus.virtual", "baud": 19200}},
        devices={"pump": {"kind": "modbus.device", "unit_id": 7, "table": str(table), "links": {"modbus": "line"}}},
        modbus_buses=("mb", "line"),
        modbus_client={
            "link": 2,
            "units": {"pump": {"unit": 7, "reads": [{**READ, "values": [value("level")]}], "writes": [WRITE]}},
        },
    ).boot()
    rig.set("pump.place", -5).run(100)
    assert rig.get("pump.level") == 77
    assert rig.rig.get("pump", "place") == -5
    assert rig.ask("03 0000 0001") == "03 02 4d 34"  # and it is a server all the while


def test_a_silent_unit_is_lost_and_comes_back() -> None:
    bench = Bench(answering(LEVEL), {"timeout_ms": 50, "retries": 2, "pause_ms": 400})
    bench.rig.run(210)
    bench.answer = lambda _pdu: None
    bench.rig.run(400)
    asked = len(bench.asked)
    times = [ms for ms, _ in bench.asked[-3:]]
    assert [after - before for before, after in itertools.pairwise(times)] == [50, 50]
    assert bench.rig.codes()[-1] == LOST
    assert (bench.rig.get("DiagCode"), bench.rig.get("DiagExtCode")) == (LOST, "Modbus 7")
    assert (bench.get("Errors"), bench.get("IsRunning"), bench.get("level")) == (3, False, 0)
    bench.rig.run(410)
    assert asked < len(bench.asked) <= asked + 2  # one try, and then a pause
    bench.answer = answering(LEVEL)
    bench.rig.run(900)
    assert bench.rig.codes()[-1] == BACK
    assert (bench.get("IsRunning"), bench.get("level")) == (True, 1234)


def test_values_of_a_lost_unit_may_be_held() -> None:
    bench = Bench(answering(LEVEL), {"timeout_ms": 20, "retries": 0}, lost_inputs="hold")
    bench.rig.run(150)
    bench.answer = lambda _pdu: None
    bench.rig.run(300)
    assert (bench.get("IsRunning"), bench.get("level")) == (False, 1234)


def test_a_unit_that_is_back_gets_its_values_again() -> None:
    bench = Bench(answering(""), {"timeout_ms": 20, "retries": 0, "pause_ms": 100}, reads=[], writes=[WRITE])
    bench.rig.run(100)
    bench.answer = lambda _pdu: None
    bench.rig.set("pump.speed", 3).run(300)
    assert bench.get("IsRunning") is False
    bench.answer = answering("")
    bench.rig.run(300)
    assert bench.get("IsRunning") is True
    assert bench.asked[-1][1] == "100020000306000300000000"


def test_an_exception_is_counted_and_no_loss() -> None:
    bench = Bench(lambda pdu: bytes((pdu[0] | 0x80, 2)), {"pause_ms": 200})
    bench.rig.run(900)
    assert (bench.get("Exceptions"), bench.get("LastException"), bench.get("Errors")) == (5, 2, 0)
    assert LOST not in bench.rig.codes()
    assert bench.get("IsRunning") is True


@pytest.mark.parametrize("code", [0x0A, 0x0B])
def test_a_gateway_that_speaks_for_a_unit_is_no_answer_of_the_unit(code: int) -> None:
    bench = Bench(lambda pdu: bytes((pdu[0] | 0x80, code)), {"pause_ms": 200, "retries": 1})
    bench.rig.run(100)
    assert (bench.get("Exceptions"), bench.get("LastException"), bench.get("Errors")) == (2, code, 2)
    assert (bench.rig.get("DiagCode"), bench.get("IsRunning")) == (LOST, False)
    bench.answer = answering(LEVEL)
    bench.rig.run(300)
    assert (bench.rig.codes()[-1], bench.get("level")) == (BACK, 1234)


@pytest.mark.parametrize("answer", ["", "04", "0402", "040a" + "00" * 9, "030a" + LEVEL, "84", "8402ff"])
def test_wrong_answers_are_errors(answer: str) -> None:
    bench = Bench(lambda _pdu: bytes.fromhex(answer) or b"\x00", {"retries": 0})
    bench.rig.run(200)
    assert bench.get("Errors") == 1
    assert LOST in bench.rig.codes()


def test_an_answer_that_comes_too_late_is_none() -> None:
    held: list[int] = []
    bench = Bench(lambda _pdu: None, {"timeout_ms": 50, "retries": 5})
    bench.rig.outside.link("mb").on_receive(lambda request: held.append(request.exchange), [7])
    bench.rig.run(80)
    assert len(held) == 2
    bench.rig.outside.link("mb").send(ModbusResponse(7, bytes.fromhex("040a" + LEVEL), held[0]))
    bench.rig.run(20)
    assert bench.get("level") == 0


def test_without_power_it_asks_nothing() -> None:
    bench = Bench(answering(LEVEL))
    bench.rig.run(150)
    number = bench.rig.rig.add_fault("max4", {"what": "power_off"})
    bench.rig.run(10)
    before = len(bench.asked)
    bench.rig.run(500)
    assert len(bench.asked) == before
    bench.rig.rig.clear_fault("max4", number)
    bench.rig.run(200)
    assert len(bench.asked) > before


@pytest.mark.parametrize(
    ("client", "wrong"),
    [
        ({"link": 2, "units": {}}, "link: expected 1 to 1, one of links.modbus, got 2"),
        ({"units": {"belt": {"unit": 7}}}, "expected each name once"),
        ({"units": {"p": {"unit": 7, "reads": [{**READ, "what": "coils"}]}}}, "type bool"),
        ({"units": {"p": {"unit": 7, "reads": [READ, READ]}}}, "each name once"),
        ({"units": {"p": {"unit": 7, "reads": [{**READ, "address": 0xFFFF}]}}}, "end at 65535 or below"),
        (
            {"units": {"p": {"unit": 7, "writes": [{**WRITE, "values": [value(f"v{n}") for n in range(124)]}]}}},
            "at most 123",
        ),
    ],
)
def test_wrong_settings_are_refused(client: dict[str, Any], wrong: str) -> None:
    with pytest.raises(ConfigError, match=wrong):
        FacesBench(modbus_client=client)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.binary(min_size=1, max_size=20) | st.binary(min_size=10, max_size=10).map(lambda data: b"\x04\x0a" + data)
    )
)
def test_no_answer_upsets_the_client(answers: list[bytes]) -> None:
    waiting = iter(answers)
    bench = Bench(lambda _pdu: next(waiting, None), {"timeout_ms": 5, "pause_ms": 5, "retries": 0})
    bench.rig.run(200)
    for key in ("level", "flow", "count"):
        bench.get(key)
    bench.rig.write(200, bench.rig.parameter("pump.flow").address, Type.UINT32)
    assert bench.rig.ask("03 00d2 0006").startswith("03 0c")
