"""Changes of points at their instants: those of a reaction, and those between the instructions of a program."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from fieldrig import MS, ArgumentError, ControlError, Rig, RigError, S, Value, from_dict

HERE = Path(__file__).parents[1]
DICE: dict[str, Any] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {
        "dice": {"kind": "rig_kinds:Dice", "links": {"wires": "wires"}},
        "slow": {"kind": "rig_kinds:Dice", "period_ms": 25, "links": {"wires": "wires"}},
    },
}
PROGRAM = """\
beg STATES
V2 == 0
LOOP:
V1 == 1
V1 == 2
V1 == 3
V2 == V2 + 1
if V2 < 20, LOOP
call COUNT
wait 0.002
V1 == 0
V2 == 0
goto LOOP
end

BEG COUNT
V3 == V3 + 1
V4 == V3 * 2
END
"""


@pytest.fixture
def rig() -> Iterator[Rig]:
    with Rig(from_dict(DICE, HERE)) as rig:
        rig.run_for(5 * MS)
        yield rig


def told(rig: Rig, point: str) -> tuple[list[tuple[int, Value]], Callable[[], None]]:
    """Return the changes of a point with their instants, and the function that ends the watch."""
    changes: list[tuple[int, Value]] = []
    return changes, rig.on_change(point, lambda value: changes.append((rig.now_ns // MS, value)))


@pytest.mark.long
@pytest.mark.parametrize("processes", ["one", "each"])
def test_each_change_is_told_at_its_instant(processes: str) -> None:
    with Rig(from_dict({**DICE, "processes": processes}, HERE)) as rig:
        dice, _ = told(rig, "dice/throws")
        slow, _ = told(rig, "slow/throws")
        rig.run_until(35 * MS)
        assert dice == [(10, 2), (20, 3), (30, 4)]
        assert slow == [(25, 2)]


def test_a_value_that_a_test_writes_is_told_at_once(rig: Rig) -> None:
    changes, _ = told(rig, "dice/throws")
    rig.set("dice/throws", 7)
    rig.set("dice/throws", 7)
    assert changes == [(5, 7)]


def test_nothing_is_told_after_the_end_of_a_watch(rig: Rig) -> None:
    changes, end = told(rig, "dice/throws")
    others, _ = told(rig, "dice/throws")
    rig.run_until(10 * MS)
    end()
    end()
    rig.run_until(20 * MS)
    assert (changes, others) == ([(10, 2)], [(10, 2), (20, 3)])


def test_a_call_may_write_points_but_not_run_the_rig(rig: Rig) -> None:
    rig.on_change("dice/throws", lambda value: rig.set("slow/throws", int(value) * 100))
    rig.run_until(10 * MS)
    assert rig.get("slow/throws") == 200
    rig.on_change("slow/throws", lambda _: rig.run_for(MS))
    with pytest.raises(RigError, match="a call of on_change or on_instant cannot run the rig"):
        rig.run_until(20 * MS)


def test_a_watch_needs_a_point_and_a_function(rig: Rig) -> None:
    with pytest.raises(ControlError, match=r"dice has no value 'throw'\n  did you mean throws\?"):
        rig.on_change("dice/throw", print)
    with pytest.raises(ArgumentError, match="on_change cannot call 5\n  expected a function"):
        rig.on_change("dice/throws", 5)  # type: ignore[arg-type]


# ---- the program of a card


def card(folder: Path) -> Rig:
    (folder / "states.I01").write_text(PROGRAM)
    wires = {"wires": "wires"}
    entry = {"kind": "arp", "program": "states.I01", "links": wires, "inputs": {"I108": True}}
    data = {"time": "virtual", "buses": {"wires": {"kind": "wires.virtual"}}, "devices": {"card": entry}}
    return Rig(from_dict(data, folder))


def test_states_of_a_program_that_last_no_millisecond_are_told(tmp_path: Path) -> None:
    with card(tmp_path) as rig:
        states: list[Value] = []
        rig.on_change("card/V1", states.append)
        rig.until(lambda: rig.get("card/V3") == 2, within=S)
    assert states[: 3 * 20] == [1.0, 2.0, 3.0] * 20
    assert states[60:63] == [0.0, 1.0, 2.0]


def test_a_fault_begins_when_the_program_reaches_a_line(tmp_path: Path) -> None:
    with card(tmp_path) as rig:
        lines: dict[Value, int] = {}

        def note(line: Value) -> None:
            lines.setdefault(line, rig.now_ns)

        rig.on_change("card/program.line", note)
        rig.until(lambda: rig.get("card/V3") == 2, within=S)
    line, at_ns = list(lines.items())[-1]
    with card(tmp_path) as rig:
        fault = {"what": "drop_out", "wire": "card.enable", "when": f"card/program.line == {line}"}
        number = rig.add_fault("wires", fault)
        rig.run_until(at_ns - 1)
        assert rig.faults("wires")[number]["state"] == "waiting"
        rig.run_until(at_ns)
        assert rig.faults("wires")[number]["state"] == "on"


@pytest.mark.long
def test_a_watch_changes_nothing(tmp_path: Path) -> None:
    """A program without a watch, with one, or with one that comes and goes is at the same place each millisecond."""

    def run(watch: Callable[[Rig, int], object]) -> list[list[Value]]:
        with card(tmp_path) as rig:
            rows = []
            for number in range(300):
                watch(rig, number)
                rig.run_for(MS)
                rows.append([rig.get(f"card/{key}") for key in ("V1", "V2", "V3", "V4", "program.line", "cycles")])
            return rows

    ends: list[Callable[[], None]] = []

    def coming_and_going(rig: Rig, number: int) -> None:
        if number % 14 == 3:
            ends.append(rig.on_change("card/V1", lambda _: None))
        elif number % 14 == 8:
            ends.pop()()

    plain = run(lambda _rig, _number: None)
    assert len({tuple(row[:5]) for row in plain}) > 20
    assert run(lambda rig, number: number or rig.on_change("card/V1", lambda _: None)) == plain
    assert run(coming_and_going) == plain
