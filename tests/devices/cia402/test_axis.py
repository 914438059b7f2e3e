"""An axis on the bus: state machine and objects through SDO and PDO, PDOs of axis n, option codes, faults, units."""

import math

import pytest
from cia402_bench import Cia402Bench
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.canopen.service import Reset
from fieldrig_devices.cia402.objects import ROWS, Row

pytestmark = pytest.mark.long

PP, PV, PT, HM, IP, CSP, CSV, CST = 1, 3, 4, 6, 7, 8, 9, 10


@pytest.fixture
def bench() -> Cia402Bench:
    return Cia402Bench()


def test_the_device_type_says_several_axes_and_each_axis_its_own(bench: Cia402Bench) -> None:
    assert bench.get(0x1000) & 0xFFFF_FFFF == 0xFFFF_0192
    assert bench.get(0x67FF) == 0x0002_0192


def test_supported_modes_are_those_of_the_profile(bench: Cia402Bench) -> None:
    # pp, vl, pv, tq, hm, ip, csp, csv, cst: bits 0 to 3, 5 to 9
    assert bench.get(0x6502) == 0x0000_03EF


def test_the_way_to_operation_and_back_by_sdo(bench: Cia402Bench) -> None:
    assert bench.status() == 0x0250  # switch on disabled, voltage, remote
    for word, status in ((0x06, 0x0231), (0x07, 0x0233), (0x0F, 0x0237), (0x07, 0x0237)):
        assert bench.control(word).status() == status
    assert bench.cycles(1).status() == 0x0233
    assert bench.control(0x00).status() == 0x0250
    assert bench.motor.wanted[-2:] == [False, False]


def test_enabling_waits_for_the_brake(bench: Cia402Bench) -> None:
    bench.motor.lifting = 25
    bench.control(0x06).control(0x0F)
    assert bench.cycles(25).status(0x6F) == 0x23
    assert bench.cycles(1).status(0x6F) == 0x27


def test_rpdo_1_and_tpdo_1_carry_the_words(bench: Cia402Bench) -> None:
    assert bench.send("205#06 00") == ["185#31 02", "285#31 02 00"]
    assert bench.send("205#0F 00") == ["185#37 02", "285#37 02 00"]


def test_rpdo_2_carries_the_mode_and_tpdo_2_shows_it(bench: Cia402Bench) -> None:
    assert bench.send("305#00 00 08") == ["285#50 02 08"]


@pytest.mark.parametrize("sync", [[], ["080#"]])
def test_a_control_word_acts_with_the_target_of_its_rpdo(bench: Cia402Bench, sync: list[str]) -> None:
    """RPDO 3 carries 6040h first and 607Ah behind it."""
    bench.put(0x1402, 1 if sync else 255, 2).put(0x607A, 7).enabled(PP)
    bench.send("405#1F 00 10 27 00 00", *sync)
    assert bench.cycles(60).motor.position == 10_000


def test_a_control_word_acts_with_the_targets_of_its_sync(bench: Cia402Bench) -> None:
    """RPDO 1 has the control word, RPDO 5 here the target; all count with the SYNC at once."""
    bench.put(0x1400, 1, 2).put(0x1404, 1, 2).put(0x1604, 0, 0).put(0x1604, 0x607A_0020, 1).put(0x1604, 1, 0)
    bench.put(0x1404, 0x0000_0215, 1).put(0x607A, 7).enabled(PP)
    bench.send("205#1F 00", "215#10 27 00 00", "080#")
    assert bench.cycles(60).motor.position == 10_000


def test_a_control_word_acts_in_the_mode_of_its_rpdo(bench: Cia402Bench) -> None:
    """RPDO 2 carries 6040h first and 6060h behind it: homing is begun, method 35."""
    bench.enabled(PP)
    assert sorted(bench.send("305#1F 00 06")) == ["185#37 16", "285#37 16 06"]


def test_tpdo_3_answers_sync_with_the_position(bench: Cia402Bench) -> None:
    bench.motor.position = 0x01020304
    bench.cycles(1).take()
    assert bench.send("080#") == ["385#50 02 04 03 02 01", "485#50 02 00 00 00 00"]


def test_axis_2_is_800h_higher_and_its_pdos_64() -> None:
    bench = Cia402Bench(axes=2)
    bench.put(0x1440, 0x0000_0215, 1).put(0x1840, 0x0000_0195, 1)
    bench.take()
    assert bench.send("215#06 00") == ["195#31 02"]
    assert (bench.status(axis=0), bench.status(axis=1)) == (0x0250, 0x0231)
    assert bench.get(0x67FF, axis=1) == 0x0002_0192


def test_axes_that_are_not_there_are_not_ready() -> None:
    bench = Cia402Bench(axes=2)
    bench.motors[1].is_there = False
    bench.axes[1].restart()
    bench.cycles(1)
    assert (bench.status(axis=1), bench.get(0x67FF, axis=1)) == (0, 0)


def test_pdos_of_further_axes_are_not_valid_at_first(bench: Cia402Bench) -> None:
    for index in (0x1404, 0x1440, 0x1443, 0x1804, 0x1840, 0x15C0, 0x19C0):
        assert bench.get(index, 1) & 0xFFFF_FFFF == 0x8000_0000, hex(index)


def test_a_mode_that_the_motor_can_not_follow_is_refused(bench: Cia402Bench) -> None:
    assert bench.try_put(0x6060, 5) == "06090030"  # reserved
    assert bench.try_put(0x6060, -1) == "06090030"
    assert bench.put(0x6060, CSV).get(0x6061) == CSV


@pytest.mark.parametrize(
    ("option", "rate"), [(1, 10_000_000), (2, 100_000_000), (3, 1_000_000_000), (5, 10_000_000), (6, 100_000_000)]
)
def test_quick_stop_ramps_by_its_option(bench: Cia402Bench, option: int, rate: int) -> None:
    bench.put(0x605A, option).put(0x60FF, 5_000_000).enabled(PV).cycles(200)
    assert bench.get(0x606C) == 5_000_000
    bench.control(0x02)
    assert bench.status(0x6F) == 0x07
    begin = bench.motor.position
    count = bench.cycles_until(lambda: bench.motor.velocity == 0)
    way = 5_000_000**2 / (2 * rate)
    assert bench.motor.position - begin == pytest.approx(way + 5_000_000 * 0.004, abs=5_000_000 * 0.004)
    assert count == pytest.approx(5_000_000 / rate / 0.004, abs=3)
    assert bench.cycles(1).status(0x6F) == (0x07 if option > 4 else 0x40)


def test_out_of_quick_stop_back_to_operation(bench: Cia402Bench) -> None:
    bench.put(0x605A, 6).put(0x60FF, 5_000_000).enabled(PV).cycles(200)
    bench.control(0x02).cycles(100)
    assert bench.get(0x606C) == 0
    assert bench.control(0x0F).status(0x6F) == 0x27
    assert bench.cycles(200).get(0x606C) == 5_000_000


@pytest.mark.parametrize(("option", "rate"), [(1, 10_000_000), (2, 100_000_000)])
def test_halt_and_on_again(bench: Cia402Bench, option: int, rate: int) -> None:
    bench.put(0x605D, option).put(0x60FF, 5_000_000).enabled(PV).cycles(200)
    bench.control(0x010F).cycles(round(5_000_000 / rate / 0.004) + 2)
    assert (bench.get(0x606C), bench.status(0x046F)) == (0, 0x0427)
    assert bench.control(0x0F).cycles(200).get(0x606C) == 5_000_000


def test_the_axis_does_not_jump_when_it_is_enabled_again_elsewhere(bench: Cia402Bench) -> None:
    bench.enabled(PP).control(0x06).cycles(1)
    bench.motor.position = 123_456
    bench.control(0x0F).cycles(10)
    assert bench.motor.position == 123_456
    assert bench.get(0x6062) == 123_456


def test_without_power_the_demand_is_where_the_axis_is(bench: Cia402Bench) -> None:
    bench.put(0x60FF, 5_000_000).enabled(PV).cycles(200).control(0x00)
    assert (bench.status(0x6F), bench.get(0x606B)) == (0x40, 0)
    bench.cycles(5)
    bench.motor.position = 123_456
    assert (bench.get(0x6062), bench.get(0x60FC), bench.get(0x606B)) == (123_456, 123_456, 0)


def test_an_error_of_the_motor_is_a_fault_until_it_is_reset(bench: Cia402Bench) -> None:
    errors: list[tuple[list[int], list[int]]] = []
    bench.axis.on_errors = lambda new, gone: errors.append(([*new], [*gone]))
    bench.enabled(PP)
    bench.motor.errors, bench.motor.is_following = (0x7305,), False
    bench.cycles(1)
    assert (bench.status(0x4F), bench.get(0x603F), errors) == (0x08, 0x7305, [([0x7305], [])])
    bench.control(0x80).cycles(1)
    assert (bench.status(0x4F), bench.get(0x603F), errors) == (0x40, 0x7305, [([0x7305], []), ([], [0x7305])])


def test_603f_is_the_last_error_until_power_on(bench: Cia402Bench) -> None:
    for error in (0x7305, 0x4210):
        bench.motor.errors = (error,)
        bench.cycles(1)
        assert bench.get(0x603F) == error
        bench.motor.errors = ()
        bench.control(0x00).control(0x80).cycles(1)
        assert (bench.status(0x4F), bench.get(0x603F)) == (0x40, error)
    bench.axis.reset(Reset.NODE)
    assert bench.get(0x603F) == 0


def test_a_following_error_is_a_fault_with_the_reaction_of_605e(bench: Cia402Bench) -> None:
    bench.put(0x6065, 10_000).put(0x6066, 100).put(0x60FF, 5_000_000).enabled(PV).cycles(100)
    bench.motor.lag = 20_000
    bench.cycles(24)
    assert bench.status(0x4F) == 0x07
    bench.cycles(4)
    assert (bench.status(0x4F), bench.get(0x603F)) == (0x0F, 0x8611)
    bench.cycles(20)
    assert (bench.status(0x4F), bench.motor.is_following) == (0x08, False)


def test_bit_13_shows_the_following_error_in_pp(bench: Cia402Bench) -> None:
    bench.put(0x6065, 10_000).put(0x605E, 1).put(0x607A, 9_000_000).put(0x6081, 5_000_000).enabled(PP).control(0x1F)
    bench.cycles(100)
    bench.motor.lag = 20_000
    bench.cycles(2)
    assert bench.status(0x2000) == 0x2000
    assert bench.get(0x60F4) >= 20_000
    bench.cycles(200)
    bench.motor.lag = 0
    assert bench.status(0x204F) == 0x2008
    assert bench.control(0x80).status(0x204F) == 0x0040


def test_lost_power_disables(bench: Cia402Bench) -> None:
    bench.enabled(PP)
    bench.motor.is_following = bench.motor.is_ready = False
    assert bench.cycles(1).status() == 0x0240


def test_a_warning_is_bit_7(bench: Cia402Bench) -> None:
    bench.motor.has_warning = True
    assert bench.status(0x80) == 0x80


# 6007h, when a master stops the node.
@pytest.mark.parametrize(("option", "status"), [(0, 0x27), (1, 0x08), (2, 0x40), (3, 0x07)])
def test_abort_connection(bench: Cia402Bench, option: int, status: int) -> None:
    bench.put(0x6007, option).put(0x605A, 6).enabled(PP)
    bench.send("000#02 05")
    bench.cycles(3)
    bench.send("000#01 05")
    assert bench.status(0x6F) == status


def test_a_lost_heartbeat_aborts_the_connection(bench: Cia402Bench) -> None:
    bench.put(0x1016, 0x0063_0064, 1).put(0x6007, 3).put(0x605A, 6).enabled(PP)
    bench.send("763#05")
    bench.after(101)
    assert bench.cycles(1).status(0x6F) == 0x07


def test_reset_node_takes_power_away_and_puts_parameters_back(bench: Cia402Bench) -> None:
    bench.put(0x6081, 77).enabled(PP)
    bench.send("000#81 05")
    bench.cycles(1)
    assert (bench.status(0x6F), bench.get(0x6081), bench.get(0x6061)) == (0x40, 1_000_000, 0)
    assert not bench.motor.is_following


def test_parameters_are_stored_and_targets_are_not(bench: Cia402Bench) -> None:
    bench.put(0x6081, 77).put(0x607A, 99).put(0x6060, PP).put(0x1010, 0x6576_6173, 1)
    again = Cia402Bench(store=bench.store)
    assert (again.get(0x6081), again.get(0x607A), again.get(0x6060)) == (77, 0, 0)


def test_units_of_the_user(bench: Cia402Bench) -> None:
    """A gear of 10 to 1 and a pitch of 5 mm in 0.001 mm: 2000 increments are 1 um."""
    bench.put(0x6091, 10, 1).put(0x6092, 5_000, 1)
    bench.motor.position = 20_000_000
    assert bench.cycles(1).get(0x6064) == 10_000
    assert bench.get(0x6063) == 20_000_000
    bench.put(0x607E, 0x80)
    assert bench.get(0x6064) == -10_000


def test_the_polarity_turns_positions_and_velocities(bench: Cia402Bench) -> None:
    bench.put(0x607E, 0xC0).put(0x60FF, 1_000_000).enabled(PV).cycles(200)
    assert bench.motor.velocity == -1_000_000
    assert bench.get(0x606C) == 1_000_000
    assert bench.get(0x6064) == -bench.motor.position > 0


@pytest.mark.parametrize(("polarity", "following_error"), [(0x00, 20_000), (0x80, -20_000)])
def test_the_following_error_has_the_sign_of_the_users_positions(
    bench: Cia402Bench, polarity: int, following_error: int
) -> None:
    """It is 6062h less 6064h; the motor lags behind on its way up."""
    bench.put(0x607E, polarity).put(0x60FF, 1_000_000).enabled(PV)
    bench.motor.lag = 20_000
    bench.cycles(2)
    assert bench.get(0x60F4) == bench.get(0x6062) - bench.get(0x6064) == following_error


def test_positions_count_on_over_32_bits(bench: Cia402Bench) -> None:
    bench.motor.position = 0x7FFF_FF00
    bench.put(0x607A, 0x200).enabled(1).control(0x5F).cycles(100)  # relative, over the end
    assert (bench.motor.position, bench.get(0x6064)) == (0x8000_0100, -0x8000_0000 + 0x100)
    bench.put(0x607A, -0x8000_0000 + 0x300).control(0x0F).control(0x1F).cycles(100)  # absolute, on this turn
    assert bench.motor.position == 0x8000_0300


@pytest.mark.parametrize("mode", [CSP, IP])
def test_cyclic_set_points_go_on_over_the_end_of_the_range(bench: Cia402Bench, mode: int) -> None:
    bench.motor.position = 0x7FFF_FF00
    bench.put(0x60C2, 4, 1).enabled(mode).control(0x1F)
    for shown in (0x7FFF_FF80, -0x8000_0000 + 0x10):
        bench.put(*((0x607A, shown) if mode == CSP else (0x60C1, shown, 1))).cycles(1)
    assert (bench.motor.position, bench.get(0x6064)) == (0x8000_0010, -0x8000_0000 + 0x10)


def test_a_rotary_axis_shows_its_turn_and_takes_the_shortest_way(bench: Cia402Bench) -> None:
    """607Bh and 60F2h: 3600 units a turn of 1 000 000 increments."""
    bench.put(0x6092, 3_600, 1).put(0x607B, 0, 1).put(0x607B, 3_599, 2).put(0x60F2, 0x00C0)
    bench.put(0x6081, 36_000).put(0x6083, 360_000).put(0x6084, 360_000).put(0x6067, 1)
    bench.motor.position = 10_000_000
    bench.put(0x607A, 3_500).enabled(PP).control(0x1F).control(0x0F)
    bench.cycles_until(lambda: bench.status(0x0400) != 0)
    assert bench.get(0x6064) == 3_500
    assert bench.motor.position == pytest.approx(9_972_222, abs=1)
    bench.put(0x607A, 100).control(0x1F).cycles(1)
    bench.cycles_until(lambda: bench.status(0x0400) != 0)
    assert bench.get(0x6064) == 100
    assert bench.motor.position == pytest.approx(10_027_778, abs=1)


@pytest.mark.parametrize("option", [3, 4, 0x10, 0xC3, 0x100])
def test_positioning_options_that_are_not_there_are_refused(bench: Cia402Bench, option: int) -> None:
    assert bench.try_put(0x60F2, option) in ("06090030", "06090031")


def test_inputs_and_outputs(bench: Cia402Bench) -> None:
    bench.motor.switches = lambda position: 0x0001_0005
    assert bench.get(0x60FD) == 0x0001_0005
    bench.put(0x60FE, 0x0003_0000, 2).put(0x60FE, 0x0006_0000, 1)
    assert bench.motor.outputs == 0x0002_0000


def test_reset_node_puts_outputs_back_with_their_object(bench: Cia402Bench) -> None:
    bench.put(0x60FE, 0x0003_0000, 2).put(0x60FE, 0x0002_0000, 1)
    bench.send("000#82 05")
    assert (bench.get(0x60FE, 1), bench.motor.outputs) == (0x0002_0000, 0x0002_0000)
    bench.send("000#81 05")
    assert (bench.get(0x60FE, 1), bench.motor.outputs) == (0, 0)


def test_the_motor_tells_its_torque(bench: Cia402Bench) -> None:
    bench.motor.torque = -1_234
    assert (bench.get(0x6077), bench.get(0x6076)) == (-1_234, 2_500)


@settings(deadline=None, max_examples=40)
@given(
    st.lists(
        st.tuples(
            st.sampled_from([row for row in ROWS if row.access != "ro"])
            | st.sampled_from([row for row in ROWS if row.index in (0x6040, 0x6060, 0x607A, 0x60FF)]),
            st.sampled_from([0, 1, 3, 6, 7, 8, 9, 0x0F, 0x1F, 0x3F, 0x80, 0x010F, -1])
            | st.integers(-(2**31), 2**31 - 1),
            st.integers(0, 5),
        ),
        max_size=40,
    )
)
def test_whatever_a_master_writes_set_values_are_numbers(orders: list[tuple[Row, int, int]]) -> None:
    bench = Cia402Bench()
    bench.motor.switches = lambda position: (position < -50_000) | (position > 50_000) << 1 | (position > 0) << 2
    bench.control(0x06).control(0x07)
    for row, value, cycles in orders:
        bench.try_put(row.index, value, row.subindex or 0)
        bench.cycles(cycles)
        assert math.isfinite(bench.axis.drive.set_value)
        assert bench.get(0x6061) in (0, 1, 2, 3, 4, 6, 7, 8, 9, 10)


@pytest.mark.parametrize("mode", [PP, PV, HM, IP, CSP, CSV])
def test_a_control_word_that_is_repeated_in_every_cycle_changes_nothing(mode: int) -> None:
    """A move, a halt, its end, and a quick stop, with each word once and with each word in every cycle."""

    def seen(repeats: bool) -> list[tuple[int, int, float]]:
        bench = Cia402Bench()
        bench.put(0x6098, 33).put(0x60FF, 500_000).put(0x607A, 300_000).enabled(mode)
        found = []
        for word in (0x1F, 0x11F, 0x1F, 0x0F, 0x02, 0x0F):
            bench.control(word)
            for cycle in range(30):
                if repeats and cycle:
                    bench.control(word)
                bench.cycles(1)
                found.append((bench.motor.position, bench.axis.status_word, bench.axis.drive.set_value))
        return found

    assert seen(repeats=True) == seen(repeats=False)
