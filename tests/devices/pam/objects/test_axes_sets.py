"""Axes sets: orders to several axes, switches and ratios behind a converter, subsets, and groups in one frame."""

from typing import Any

import pytest
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pamring.frames import (
    AxisOrder,
    AxisReport,
    EndOfPipe,
    Group,
    Move,
    Read,
    SetPoint,
    SetPointMode,
)
from fieldrig_devices.pamring.registers import Parameter, parameter_address

GROUP = -1
"""Frames to group 1, as the port records them."""


def axes(count: int, optimize: str = "NO", subsets: tuple[int, ...] = ()) -> str:
    text = HEADER
    for n in range(1, count + 1):
        text += f"NODE NOD_{n}; ADDRESS = {n}; TYPE = ST1; END\n"
        text += f"AXIS AXI_{n}; NODE = NOD_{n}; PULSES_PER_UNIT = 100; TRAVEL_SPEED = 10; ACCELERATION = 20;"
        text += " INITIAL_POSITION = 0; POSITION_RANGE = -1 1; END\n"
    text += f"AXES_SET AXS_All; OPTIMIZE = {optimize};\n"
    for n in range(1, count + 1):
        text += f"  AXIS = AXI_{n}{f' SUBSET = {subsets[n - 1]}' if subsets else ''};\n"
    return (
        text
        + """END
TMP_GENERATOR TMP_Master; TRAVEL_SPEED = 100; ACCELERATION = 1000; INITIAL_POSITION = 0; POSITION_RANGE = 0 1;
  PERIOD = 0.001; ANTI_DELAY = NO; END
CONVERTER CNV_All; DESTINATION = AXS_All; MODE = POSITION; END
CONVERTER CNV_Speed; DESTINATION = AXS_All; MODE = SPEED; END
"""
    )


def analysed(text: str, other_axis: int = 0, parameter: Parameter = Parameter.CKV, **settings: Any) -> Bench:
    """A machine whose PAM has read the parameters of all axes; `other_axis` may have another one of them."""
    bench = Bench(text, **settings)
    bench.st1(*range(1, 33))
    if other_axis:
        bench.nodes[other_axis].registers[parameter_address(parameter)] = 50
    bench.cycle(3)
    forget(bench)
    return bench


def connected(text: str, converter: str = "CNV_All", **settings: Any) -> Bench:
    """A machine whose set is behind a pipe at position 0, without what was sent for that."""
    bench = analysed(text, **settings)
    bench.connect(converter, "TMP_Master")
    bench.cycle(6)
    forget(bench)
    return bench


def forget(bench: Bench) -> None:
    bench.port.sent.clear()
    bench.delivered = 0


def at(bench: Bench, position: float, cycles: int = 1) -> None:
    bench.do("TMP_Master", "position", position)
    bench.cycle(cycles)


def position(value: float) -> SetPoint:
    return SetPoint(SetPointMode.POSITION, round(value * 100))


@pytest.mark.manual("PAML-041")
@pytest.mark.manual("PAML-160")
@pytest.mark.manual("PAML-161")
def test_orders_to_a_set_go_to_all_its_axes() -> None:
    bench = Bench(axes(3))
    bench.do("AXS_All", "power_on")
    bench.do("AXS_All", "relative_move", 5)
    moves = [(n, AxisOrder(2, Move.RELATIVE_MOVE, 500, 1000, 2000, 2000)) for n in (1, 2, 3)]
    assert bench.port.sent == [*((n, AxisOrder(1, Move.POWER_ON)) for n in (1, 2, 3)), *moves]
    bench.kernel.touched_names.clear()
    for n in (1, 3):
        bench.objects.on_report(n, AxisReport(1, 0, 2, 500))
    assert not bench.ask("AXS_All", "ready")
    assert bench.kernel.touched_names == {"AXI_1", "AXI_3", "AXS_All"}
    bench.objects.on_report(2, AxisReport(1 | 16, 0x80000000, 2, 500))
    assert bench.ask("AXS_All", "ready")
    assert bench.ask("AXS_All", "error")
    assert (bench.ask("AXS_All", "error_code"), bench.ask("AXS_All", "status")) == (0x80000000, 17)
    assert [bench.ask("AXS_All", "status", mask) for mask in (16, 2)] == [True, False]
    assert bench.ask("AXS_All", "position") == 5


@pytest.mark.manual("PAML-166")
def test_each_axis_of_a_set_gets_its_own_frame() -> None:
    bench = connected(axes(3))
    at(bench, 2)
    assert bench.port.sent == [(n, position(2)) for n in (1, 2, 3)]


@pytest.mark.manual("PAML-168")
@pytest.mark.manual("PAML-169")
def test_subsets_are_served_in_turn_and_other_axes_always() -> None:
    bench = connected(axes(5, subsets=(1, 1, 2, 4, 0)))
    bench.do("TMP_Master", "run", 100)
    bench.cycle(100)
    served = []
    for _ in range(8):
        count = len(bench.port.sent)
        bench.cycle()
        served.append([address for address, _ in bench.port.sent[count:]])
    turns = [[5, 1, 2], [5, 3], [5, 4]]  # the subsets of the declaration: 1, 2 and 4
    first = turns.index(served[0])
    assert served == [turns[(first + cycle) % 3] for cycle in range(8)]


@pytest.mark.manual("PAML-171")
@pytest.mark.manual("PAMS-021")
@pytest.mark.manual("PAMS-023")
def test_a_disconnected_axis_stays_so_until_it_is_connected() -> None:
    bench = connected(axes(2))
    at(bench, 2)
    bench.do("CNV_All", "disconnect", bench.item("AXI_2"))
    assert bench.sent(2)[-1] == EndOfPipe(SetPointMode.POSITION)
    at(bench, 3)
    assert [bench.ask(name, "position") for name in ("AXI_1", "AXI_2")] == [3, 2]
    bench.do("CNV_All", "disactivate")
    bench.connect("CNV_All", "TMP_Master")
    at(bench, 4)
    assert [bench.ask(name, "position") for name in ("AXI_1", "AXI_2")] == [4, 2]
    bench.do("CNV_All", "connect", bench.item("AXI_2"))
    bench.cycle()
    assert [bench.ask(name, "position") for name in ("AXI_1", "AXI_2")] == [4, 4]  # it jumps
    bench.do("CNV_All", "disconnect_all")
    count = len(bench.port.sent)
    at(bench, 5)
    assert len(bench.port.sent) == count
    bench.do("CNV_All", "connect_all")
    bench.cycle()
    assert bench.port.sent[count:] == [(1, position(5)), (2, position(5))]


@pytest.mark.manual("PAMS-023")
def test_a_disconnected_axis_in_speed_mode_goes_to_speed_zero() -> None:
    bench = connected(axes(2), "CNV_Speed")
    at(bench, 2)
    assert bench.sent(2)[-1] == SetPoint(SetPointMode.SPEED, 200)
    bench.do("CNV_Speed", "disconnect", bench.item("AXI_2"))
    assert bench.sent(2)[-1] == EndOfPipe(SetPointMode.SPEED)
    assert [bench.ask(name, "speed") for name in ("AXI_1", "AXI_2")] == [2, 0]


@pytest.mark.manual("PAML-172")
@pytest.mark.manual("PAMS-020")
def test_ratios_scale_one_axis_or_all() -> None:
    bench = connected(axes(2))
    bench.do("CNV_All", "change_ratio", bench.item("AXI_2"), 0.5)
    at(bench, 4)
    assert bench.port.sent == [(1, position(4)), (2, position(2))]
    bench.do("CNV_All", "change_all_ratios", 2)
    bench.cycle(20)  # the pipe is at rest, and its axes follow nevertheless
    assert bench.port.sent[2:] == [(1, position(8)), (2, position(8))]


@pytest.mark.manual("PAML-057")
def test_a_stop_of_one_axis_stops_the_set() -> None:
    bench = connected(axes(2))
    at(bench, 2)
    bench.do("AXI_1", "stop")
    stop = AxisOrder(1, Move.STOP, 0, 0, 2000, 2000)
    assert bench.port.sent[2:] == [(1, stop), (2, stop)]
    at(bench, 3)
    assert len(bench.port.sent) == 4
    bench.do("CNV_All", "connect_all")
    bench.cycle()
    assert bench.port.sent[4:] == [(1, position(3)), (2, position(3))]


@pytest.mark.manual("PAML-162")
@pytest.mark.manual("PAML-163")
def test_identical_axes_get_their_set_points_in_one_frame() -> None:
    bench = analysed(axes(4, "YES"), other_axis=4)
    bench.connect("CNV_All", "TMP_Master")
    assert bench.port.sent == [(n, Group(1)) for n in (1, 2, 3)]
    bench.cycle()
    at(bench, 2)
    assert bench.port.sent[3:] == [(4, position(0)), (GROUP, position(0)), (4, position(2)), (GROUP, position(2))]
    assert [bench.ask(f"AXI_{n}", "position") for n in (1, 2, 3, 4)] == [2] * 4
    bench.do("AXS_All", "relative_move", 1)
    move = AxisOrder(1, Move.RELATIVE_MOVE, 100, 1000, 2000, 2000)
    assert bench.port.sent[7:] == [(GROUP, move), (4, move)]
    bench.do("CNV_All", "disactivate")
    assert bench.port.sent[9:] == [
        *((n, EndOfPipe(SetPointMode.POSITION)) for n in (1, 2, 3, 4)),
        *((n, Group(0)) for n in (1, 2, 3)),
    ]


@pytest.mark.manual("PAML-165")
def test_an_axis_without_power_stays_in_its_group_until_the_application_removes_it() -> None:
    bench = connected(axes(3, "YES"))
    bench.do("AXI_2", "power_off")
    forget(bench)
    at(bench, 2)
    assert bench.port.sent == [(GROUP, position(2))]
    forget(bench)
    bench.do("CNV_All", "disconnect", bench.item("AXI_2"))
    assert bench.port.sent[0] == (2, EndOfPipe(SetPointMode.POSITION))
    assert bench.port.sent[1:] == [*((n, Group(0)) for n in (1, 2, 3)), *((n, Group(1)) for n in (1, 3))]


@pytest.mark.manual("PAML-063")
@pytest.mark.manual("PAMS-031")
def test_grouped_axes_are_always_motionless() -> None:
    bench = connected(axes(3, "YES"), other_axis=3)
    seen: list[bool] = []
    bench.do("TMP_Master", "run", 10)
    bench.cycle(10)
    names = ("AXI_1", "AXI_2", "AXI_3", "AXS_All")
    bench.cycle(work=lambda: seen.extend(bench.ask(name, "pipe_motionless") for name in names))
    assert seen == [True, True, False, False]


@pytest.mark.manual("PAML-163")
@pytest.mark.parametrize("name", ["CKV", "CKA", "CKR", "CKH", "EQUIP"])
def test_an_axis_with_another_parameter_is_in_no_group(name: str) -> None:
    bench = analysed(axes(3, "YES"), other_axis=3, parameter=Parameter[name])
    bench.connect("CNV_All", "TMP_Master")
    assert [(n, order) for n, order in bench.port.sent if isinstance(order, Group)] == [(1, Group(1)), (2, Group(1))]


@pytest.mark.manual("PAML-163")
def test_axes_whose_nodes_do_not_answer_are_in_no_group() -> None:
    bench = Bench(axes(4, "YES"))
    bench.st1(1, 2)
    bench.cycle(101)
    bench.connect("CNV_All", "TMP_Master")
    assert [n for n, order in bench.port.sent if isinstance(order, Group)] == [1, 2]
    assert ("07..E021", (3,)) in bench.kernel.reports


@pytest.mark.manual("PAML-163")
def test_a_group_is_formed_when_the_parameters_are_known() -> None:
    bench = Bench(axes(3, "YES"))
    bench.st1(1, 2, 3)
    bench.connect("CNV_All", "TMP_Master")
    bench.cycle()
    reads = [order for order in bench.sent(1) if isinstance(order, Read)]
    assert [read.register - 0x600 for read in reads] == [*[*Parameter][:4], Parameter.EQUIP]
    assert not any(isinstance(order, Group) for order in bench.sent(1))
    bench.cycle(2)
    assert Group(1) in bench.sent(1)


@pytest.mark.manual("PAML-163")
def test_an_axis_with_another_ratio_leaves_its_group() -> None:
    bench = connected(axes(3, "YES"))
    bench.do("CNV_All", "change_ratio", bench.item("AXI_2"), 2)
    left = [(n, order.number) for n, order in bench.port.sent if isinstance(order, Group)]
    assert left == [(1, 0), (2, 0), (3, 0), (1, 1), (3, 1)]
    forget(bench)
    at(bench, 3)
    assert bench.port.sent == [(2, position(6)), (GROUP, position(3))]
    bench.do("CNV_All", "disconnect", bench.item("AXI_1"))
    forget(bench)
    at(bench, 4)
    assert bench.port.sent == [(2, position(8)), (3, position(4))]


@pytest.mark.manual("PAML-164")
def test_a_sixteenth_group_is_not_built() -> None:
    subsets = tuple(1 + n // 2 for n in range(32))
    bench = analysed(axes(32, "YES", subsets))
    bench.connect("CNV_All", "TMP_Master")
    groups = {order.number for _, order in bench.port.sent if isinstance(order, Group)}
    assert groups == set(range(1, 16))
    bench.cycle(16)
    single = {address for address, order in bench.port.sent if isinstance(order, SetPoint) and address > 0}
    assert single == {31, 32}
