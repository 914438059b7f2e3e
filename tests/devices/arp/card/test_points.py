"""Access to a card by `fieldrig get` and `set`, and its rules."""

import pytest
from arp_bench import CardBench

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig_devices.arp.card_access import CardState

LOOP = "LOOP:\nGOTO LOOP"


def test_the_state_and_what_is_wrong() -> None:
    bench = CardBench("V1 == 1 / V2\nPST 1, 2, V10\nLOOP:\nGOTO LOOP")
    assert bench.get("state") == "init"
    bench.run_for(50)
    keys = ("state", "error", "warning", "error_axis", "program", "program.state", "program.line")
    assert [bench.get(key) for key in keys] == ["run", 113, 201, 1, "program", "running", 5]


def test_a_card_without_a_program_has_no_line() -> None:
    bench = CardBench().run_for(20)
    assert [bench.get(key) for key in ("state", "program", "program.state", "program.line")] == [
        "blocked",
        "",
        "none",
        0,
    ]


def test_run_stop_and_reset_by_hand() -> None:
    bench = CardBench(LOOP).run_for(20)
    for command, state in (("stop", "stopped"), ("run", "run"), ("reset", "reset_command"), ("run", "run")):
        bench.set("state", command)
        assert bench.get("state") == state
    for command in ("run", "go"):
        with pytest.raises(ControlError):
            bench.set("state", command)


def test_axes_in_engineering_units() -> None:
    bench = CardBench("PVC 1, 50\nLOOP:\nGOTO LOOP", {"axis1": {4: 1, 7: 100, 8: 1000}, "axis2": {1: 10}}).run_for(510)
    bench.drive("encoder2", 55).run_for(1)
    assert bench.get("axis1.speed") == 50.0
    assert bench.get("axis1.position") == bench.position(1) > 20
    assert bench.get("axis2.position") == 5.5
    assert bench.get("axis1.error") == 0.0


@pytest.mark.manual("ARP-052")
@pytest.mark.parametrize(
    ("value", "raw"), [(2.5, 2_500), (0.1, 100), (-999999.999, -999_999_999), (7, 7_000), (0.001, 1)]
)
def test_variables_in_engineering_units(value: float, raw: int) -> None:
    bench = CardBench(LOOP)
    bench.set("V1000", value)
    assert bench.access.V[1000] == raw
    assert bench.get("V1000") == value


@pytest.mark.long
@pytest.mark.parametrize("value", [1e6, 0.0001, "x", True, float("nan")])
def test_what_no_variable_can_hold_is_refused(value: Value) -> None:
    with pytest.raises(ControlError):
        CardBench(LOOP).set("V1", value)


@pytest.mark.manual("ARP-053", "ARP-060")
def test_inputs_and_outputs_as_words() -> None:
    bench = CardBench("LOOP:\nV1 == #INP1 & H0082\nV2 == #INP2 & HFFFF0000\n@OUT3 == V2\nV3 == @OUT3\nGOTO LOOP")
    for number in (217, 232):
        bench.access.I[number] = 1
    bench.set("I102", True)
    bench.run_for(20)
    assert [bench.access.V[number] for number in (1, 2, 3)] == [0x82, 0x10000 - 2**31, 0x10000 - 2**31]
    assert [number for number in range(301, 333) if bench.access.O[number]] == [317, 332]


@pytest.mark.manual("ARP-053")
def test_flags_one_by_one_and_as_words() -> None:
    bench = CardBench("LOOP:\nV1 == @FLAG1\nV2 == @FLAG1 & H00FF\nGOTO LOOP")
    for flag in (1, 3, 9, 32):
        bench.set(f"F{flag}", True)
    bench.run_for(20)
    assert (bench.access.V[1], bench.access.V[2]) == (0x105 - 2**31, 5)
    assert bench.get("F3") is True


def test_a_flag_of_the_system_can_only_be_read() -> None:
    with pytest.raises(ControlError, match="only be read"):
        CardBench(LOOP).set("F260", True)
    assert not CardBench(LOOP).access.set_flag(260, 1)


def test_outputs_can_be_set_while_they_are_not_held() -> None:
    bench = CardBench(LOOP, is_enabled=False).run_for(20)
    with pytest.raises(ControlError, match="held at 0 in state reset_enable"):
        bench.set("O101", True)
    bench.drive("I108", True).run_for(20)
    bench.set("O101", True)
    assert bench.run_for(2).last_sent("O101") is True


@pytest.mark.manual("ARP-005")
def test_parameters_in_engineering_units() -> None:
    bench = CardBench(LOOP, {"axis1": {7: 12.5}}).run_for(20)
    assert (bench.get("par.1"), bench.get("par1.7"), bench.get("par2.25")) == (1.0, 12.5, 10.0)
    bench.set("par1.7", 99.5)
    assert bench.access.parameters.ram[1][7] == 99_500
    assert bench.access.parameters.flash[1][7] == 12_500
    assert bench.card.points()["par1.7"].unit == "unit/s"


@pytest.mark.parametrize(
    ("key", "value", "right"), [("par1.4", 4, "0, 1, 2, 3"), ("par.1", 11, "1 to 10 ms"), ("par.6", 300, "125, 250")]
)
def test_a_wrong_parameter_is_refused_with_its_range(key: str, value: float, right: str) -> None:
    with pytest.raises(ControlError, match=right):
        CardBench(LOOP).set(key, value)


@pytest.mark.long
def test_every_point_can_be_read() -> None:
    bench = CardBench(LOOP, with_can=True).run_for(20)
    points = bench.card.points()
    assert all(isinstance(point.read(), bool | int | float | str) for point in points.values())
    assert {f"V{n}" for n in (1, 1000)} | {f"F{n}" for n in (1, 320)} | {
        "I101",
        "I332",
        "O101",
        "O332",
    } <= points.keys()
    assert bench.state is CardState.RUN
