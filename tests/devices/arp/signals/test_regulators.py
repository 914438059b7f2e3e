"""The PID instruction (manual 5.8, 5.13.3)."""

from collections.abc import Callable

import pytest
from arp_listings import TEST_PID
from arp_signals import SignalsBench, SignalsCard
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.parameters import Kind, ParX
from fieldrig_devices.arp.readings import Readings

# Manual 5.8.1, in its order.
INPUTS = (
    *("REFPID", "SGLOFF", "DELTAR", "OFFREF", "KMIS", "OFFMIS", "KFF", "KERR", "MAXERR", "MAXPID", "MINPID"),
    *("KREG", "KOUT", "MAXDAC", "MINDAC", "OFFDAC", "SWCVEL", "KVEL"),
)
DIAGNOSTICS = ("DG_MIS", "DG_REF", "DG_ERR", "DG_PID", "DG_OUT", "DG_VEL", "DG_DAC")
NAMES = (*INPUTS, *DIAGNOSTICS)
FIRST = 50
# A plain regulator: everything at scale 1, clamps without effect, the reference reached within a loop.
PLAIN = {
    **dict.fromkeys(NAMES, 0.0),
    "DELTAR": 999_999.0,
    "KMIS": 1.0,
    "KERR": 1.0,
    "MAXERR": 999.0,
    "MAXPID": 999.0,
    "MINPID": -999.0,
    "KREG": 1.0,
    "KOUT": 1.0,
    "MAXDAC": 10.0,
    "MINDAC": -10.0,
}
PERIOD_S = 0.001


class Bench:
    """PID 1, 2, V50 on a card whose load cell 1 reads up to 10 mV; gains of axis 2."""

    def __init__(self, kp: float = 0, ki: float = 0, kd: float = 0, readings: Readings | None = None, **table: float):
        self.card = SignalsCard({2: 1, 4: 1000}, readings)
        self.card.set_kind(2, Kind.PID)
        self.gains(kp, ki, kd)
        for name, value in {**PLAIN, **table}.items():
            self[name] = value
        self.measure(0)
        self.card.regulate(1, 2, FIRST)

    def gains(self, kp: float, ki: float, kd: float, axis: int = 2) -> None:
        for number, value in ((ParX.KP, kp), (ParX.KI, ki), (ParX.KD, kd)):
            assert self.card.real_parameters.set_ram(axis, number, round(value * 1_000))

    def measure(self, microvolt: float) -> None:
        """Set the load cell, with its filter settled."""
        self.card.inputs.take(1, microvolt * 1e-6)
        self.card.inputs.start()
        self.card.loop(1)

    def __setitem__(self, name: str, value: float) -> None:
        self.card.V[FIRST + NAMES.index(name)] = round(value * 1_000)

    def __getitem__(self, name: str) -> float:
        return self.card.V[FIRST + NAMES.index(name)] / 1_000

    def run(self, ms: int = 1) -> "Bench":
        self.card.loop(ms)
        return self

    def start(self) -> "Bench":
        self.card.F[303] = 1
        return self

    @property
    def volts(self) -> float:
        return self.card.outputs.volts(2)

    @property
    def flags(self) -> tuple[int, ...]:
        """Start, Stop, Reset, Exec."""
        return tuple(self.card.F[303:307])


# ---- the instruction and its flags


@pytest.mark.manual("ARP-113")
def test_the_table_has_25_variables() -> None:
    assert len(NAMES) == 25
    bench = Bench(kp=1, REFPID=3, OFFDAC=1)
    bench.card.V[FIRST - 1] = bench.card.V[FIRST + 25] = 77
    given = bench.card.V[FIRST : FIRST + 18]
    bench.start().run(5)
    assert (bench.card.V[FIRST - 1], bench.card.V[FIRST + 25]) == (77, 77)
    assert bench.card.V[FIRST : FIRST + 18] == given
    assert bench["DG_DAC"] == 3


@pytest.mark.manual("ARP-113")
@pytest.mark.parametrize(("first", "warning"), [(976, 0), (977, 203)])
def test_the_table_ends_with_v1000(first: int, warning: int) -> None:
    bench = SignalsBench(f"@PAR1[4] == 3\nPID 2, 1, V{first}").run(3)
    assert (bench.card.F[274], bench.card.errors.warning) == (1 - bool(warning), warning)


@pytest.mark.manual("ARP-113")
@pytest.mark.manual("ARP-022")
@pytest.mark.parametrize("kind", Kind)
def test_the_axis_of_the_output_must_be_of_kind_3(kind: Kind) -> None:
    card = SignalsCard()
    card.set_kind(1, Kind.PID)
    card.set_kind(2, kind)
    card.V[FIRST + INPUTS.index("OFFDAC")] = 2_500
    card.regulate(1, 2, FIRST)
    card.loop(5)
    is_executed = kind is Kind.PID
    assert card.F[303:307] == [0, 0, int(is_executed), int(is_executed)]
    assert card.F[271:275] == [0, 0, 0, 0]
    assert card.outputs.volts(2) == (2.5 if is_executed else 0.0)
    assert card.errors.error == card.errors.warning == 0


@pytest.mark.manual("ARP-113")
def test_it_ends_when_the_axis_is_of_kind_3_no_longer() -> None:
    bench = Bench(OFFDAC=4).run(2)
    bench.card.set_kind(2, Kind.ENCODER)
    bench.run()
    assert (bench.flags, bench.volts) == ((0, 0, 0, 0), 0.0)


@pytest.mark.manual("ARP-074")
@pytest.mark.parametrize(("output", "start"), [(1, 271), (2, 303)])
def test_start_stop_reset_and_exec(output: int, start: int) -> None:
    card = SignalsCard({2: 1})
    card.set_kind(output, Kind.PID)
    stop, reset, present = start + 1, start + 2, start + 3
    for name, value in {
        **PLAIN,
        "REFPID": 100,
        "SGLOFF": 20,
        "DELTAR": 40,
        "OFFDAC": -1.5,
        "KREG": 0,
        "KFF": 0.05,
    }.items():
        card.V[FIRST + NAMES.index(name)] = round(value * 1_000)
    card.regulate(1, output, FIRST)
    assert (card.F[reset], card.F[present]) == (1, 1)
    card.loop(10)
    assert (card.F[reset], card.F[present], card.outputs.volts(output)) == (1, 1, -1.5)
    card.F[start] = 1
    card.loop(2_500)  # 100 at 40 per second
    assert (card.F[reset], card.F[present]) == (0, 1)
    assert card.outputs.volts(output) == pytest.approx(5)
    card.F[start] = 0
    card.loop(1_999)
    assert card.F[reset] == 0
    assert card.outputs.volts(output) == pytest.approx(20.04 * 0.05)
    card.loop(1)  # down to 20 in 2.000 s
    assert (card.F[reset], card.F[present], card.outputs.volts(output)) == (1, 1, -1.5)
    card.F[stop] = 1
    card.loop(1)
    assert (card.F[stop], card.F[reset], card.F[present], card.outputs.volts(output)) == (0, 0, 0, 0.0)
    card.write_analog(output, 3_000, 0)  # the output is free
    assert (card.outputs.volts(output), card.errors.warning) == (3.0, 0)
    assert not any(card.F)


@pytest.mark.manual("ARP-074")
def test_stop_ends_a_regulator_that_regulates() -> None:
    bench = Bench(kp=1, REFPID=3).start().run(2)
    assert bench.volts == 3
    bench.card.F[304] = 1
    bench.run()
    assert (bench.flags, bench.volts) == ((1, 0, 0, 0), 0.0)
    assert bench.run(10).volts == 0.0


def test_started_again_on_its_way_down_it_goes_up_again() -> None:
    bench = Bench(REFPID=100, SGLOFF=0, DELTAR=100).start().run(1_000)
    bench.card.F[303] = 0
    bench.run(500)
    assert bench["DG_REF"] == 50
    bench.start().run(500)
    assert (bench["DG_REF"], bench.flags) == (100, (1, 0, 0, 1))


@pytest.mark.manual("ARP-113")
@pytest.mark.manual("ARP-120")
def test_executed_again_it_goes_on_and_with_other_numbers_it_begins_again() -> None:
    bench = Bench(ki=1, REFPID=1).start().run(1_000)
    bench.card.regulate(1, 2, FIRST)
    assert bench.run()["DG_PID"] == 1.001
    bench.card.V[200:225] = bench.card.V[FIRST : FIRST + 25]
    bench.card.regulate(1, 2, 200)
    bench.run()
    assert bench.card.V[200 + NAMES.index("DG_PID")] == 1
    assert bench["DG_PID"] == 1.001  # the old table is unchanged


@pytest.mark.manual("ARP-113")
def test_the_other_load_cell_is_another_regulator() -> None:
    bench = Bench(ki=1, REFPID=1).start().run(1_000)
    bench.card.regulate(2, 2, FIRST)
    assert bench.run()["DG_PID"] == 0.001


@pytest.mark.manual("ARP-074")
def test_executed_with_start_high_it_regulates_at_once() -> None:
    bench = Bench(KFF=0.01, REFPID=300)
    bench.card.regulators.reset()
    bench.start().card.regulate(1, 2, FIRST)
    assert bench.flags == (1, 0, 0, 1)
    assert bench.run().volts == 3


def test_a_loop_twice_at_the_same_instant_is_one() -> None:
    bench = Bench(ki=1, kd=1, REFPID=1).start().run(10)
    bench.card.regulators.control(bench.card.time_ns)
    assert bench["DG_PID"] == 0.01


def test_reset_ends_every_regulator() -> None:
    bench = Bench(OFFDAC=4)
    bench.card.set_kind(1, Kind.PID)
    bench.card.regulate(2, 1, 100)
    bench.run(2)
    bench.card.regulators.reset()
    assert (bench.flags, bench.card.F[273:275]) == ((0, 0, 0, 0), [0, 0])
    assert bench.run(2).volts == 0.0


@pytest.mark.manual("ARP-113")
def test_dac_does_not_reach_the_output_of_a_regulator() -> None:
    bench = Bench(OFFDAC=4)
    bench.card.write_analog(2, 1_000, 0)
    assert (bench.run().volts, bench.card.errors.warning) == (4, 203)


# ---- what it computes


@pytest.mark.manual("ARP-113")
def test_the_filter_on_a_constant_error() -> None:
    bench = Bench(kp=2, ki=4, kd=0.5, REFPID=1).start()
    assert bench.run()["DG_PID"] == pytest.approx(2.004)  # no jump of the error before the start
    assert bench.run(249)["DG_PID"] == pytest.approx(2 + 4 * 0.25)
    assert bench.run(750)["DG_PID"] == pytest.approx(2 + 4 * 1.0)
    bench.gains(1, 0, 0)
    assert bench.run()["DG_PID"] == 1
    bench.gains(5, 5, 5, axis=1)  # not the axis of the output
    assert bench.run()["DG_PID"] == 1


@pytest.mark.manual("ARP-113")
def test_the_differential_part_sees_the_slope_of_the_error() -> None:
    bench = Bench(kd=0.5, REFPID=8, DELTAR=3, MAXERR=999).start().run(100)
    assert bench["DG_PID"] == pytest.approx(0.5 * 3)
    assert bench.run(3_000)["DG_PID"] == 0


@pytest.mark.manual("ARP-113")
def test_the_reference_ramps_at_deltar() -> None:
    bench = Bench(REFPID=100, DELTAR=40).start()
    assert bench.run()["DG_REF"] == 0.04
    assert bench.run(999)["DG_REF"] == 40
    assert bench.run(1_499)["DG_REF"] == 99.96
    assert bench.run()["DG_REF"] == 100
    assert bench.run(10)["DG_REF"] == 100
    bench["REFPID"] = -100
    assert bench.run(2_500)["DG_REF"] == 0
    for bench["DELTAR"] in (0, -40):
        assert bench.run(100)["DG_REF"] == 0


@pytest.mark.manual("ARP-113")
def test_the_ramp_takes_its_time_at_any_control_period() -> None:
    bench = Bench(REFPID=100, DELTAR=40).start()
    bench.card.loop(1_000, 10)
    assert bench["DG_REF"] == 40


def test_with_the_other_reading_the_ramp_begins_at_sgloff() -> None:
    for start, expected in (("zero", 1.0), ("sgloff", 21.0)):
        readings = Readings.model_validate({"pid_ramp_start": start})
        bench = Bench(readings=readings, REFPID=100, SGLOFF=20, DELTAR=10).start()
        assert bench.run(100)["DG_REF"] == expected


@pytest.mark.manual("ARP-113")
@pytest.mark.manual("ARP-121")
def test_scales_offsets_and_clamps_one_by_one() -> None:
    bench = Bench(kp=2, REFPID=50, OFFREF=3, KMIS=0.01, OFFMIS=-4, KERR=0.1, MAXERR=2.5).start()
    bench.measure(1_234.5)
    expected = {"DG_MIS": 8.345, "DG_REF": 53.0, "DG_ERR": 2.5, "DG_PID": 5.0, "DG_OUT": 5.0, "DG_DAC": 5.0}
    assert {name: bench[name] for name in expected} == expected
    bench["MAXERR"], bench["MAXPID"] = 100, 6  # error (53 - 8.345) * 0.1
    bench.run()
    assert bench["DG_ERR"] in (4.465, 4.466)
    assert bench["DG_PID"] == 6
    bench["KREG"], bench["KFF"], bench["KOUT"] = 0.5, 0.1, 0.25
    bench.run()
    assert (bench["DG_OUT"], bench["DG_DAC"], round(bench.volts, 9)) == (8.3, 2.075, 2.075)
    bench["MAXDAC"] = 2
    assert (bench.run().volts, bench["DG_DAC"]) == (2, 2)
    bench["REFPID"], bench["MINPID"], bench["MINDAC"] = -500, -7, -0.75
    bench.run()
    assert (bench["DG_PID"], bench["DG_DAC"], bench.volts) == (-7, -0.75, -0.75)
    bench["MINDAC"], bench["KOUT"] = -50, 1
    assert (bench.run().volts, bench["DG_DAC"]) == (-10, -10)


@pytest.mark.manual("ARP-113")
def test_the_source_of_the_speed() -> None:
    bench = Bench(KVEL=0.02).start()
    bench.card.speeds.update({1: 100_000, 2: -250_000})
    for source, speed in ((0, 0), (1, 2), (2, -5)):
        bench["SWCVEL"] = source
        bench.run()
        assert (bench["DG_VEL"], bench["DG_OUT"], bench.volts) == (speed, speed, speed)
        assert bench.card.errors.warning == 0
    for wrong in (3.0, -1.0, 0.5):
        bench["SWCVEL"] = wrong
        assert (bench.run()["DG_VEL"], bench.card.errors.warning) == (0, 203)


@pytest.mark.manual("ARP-121")
def test_in_reset_measure_and_speed_are_still_published() -> None:
    bench = Bench(kp=1, REFPID=5, OFFDAC=0.5, KMIS=0.5, KVEL=2, SWCVEL=1, OFFMIS=1)
    bench.card.speeds[1] = 3_000
    bench.measure(20)
    assert [bench[name] for name in DIAGNOSTICS] == [11, 0, 0, 0, 0, 6, 0.5]
    bench.measure(30)
    assert bench["DG_MIS"] == 16


def test_a_diagnostic_variable_out_of_range_is_its_limit_with_w02() -> None:
    bench = Bench(kp=1, REFPID=900_000, DELTAR=999_999, MAXERR=999_999, MAXPID=999_999, KREG=-2).start().run(1_000)
    assert (bench["DG_OUT"], bench.volts, bench.card.errors.warning) == (-999_999.999, -10, 202)


@pytest.mark.long
@pytest.mark.manual("ARP-113")
@pytest.mark.parametrize("sign", [1, -1])
def test_the_integrator_is_frozen_at_a_clamp(sign: int) -> None:
    bench = Bench(ki=1, REFPID=sign, MAXPID=2, MINPID=-2).start()
    assert bench.run(1_900)["DG_PID"] == pytest.approx(sign * 1.9)
    assert bench.run(10_000)["DG_PID"] == sign * 2
    bench["REFPID"] = -sign
    assert bench.run(500)["DG_PID"] == pytest.approx(sign * 1.5, abs=0.002)  # and not still at the clamp


@pytest.mark.manual("ARP-113")
def test_a_clamp_moved_over_the_sum_does_not_lock_it() -> None:
    bench = Bench(ki=1, REFPID=1).start().run(3_000)
    bench["MAXPID"], bench["REFPID"] = 1, -1
    assert bench.run(1_000)["DG_PID"] == 1
    assert bench.run(1_500)["DG_PID"] == pytest.approx(0.5, abs=0.002)


@pytest.mark.manual("ARP-113")
def test_the_sum_begins_at_0_after_a_reset() -> None:
    bench = Bench(ki=1, REFPID=1).start().run(1_000)
    assert bench["DG_PID"] == pytest.approx(1)
    bench.card.F[303] = 0
    bench.run(2)
    assert bench.start().run()["DG_PID"] == 0.001


@pytest.mark.manual("ARP-113")
def test_after_a_reset_the_slope_of_the_error_begins_again() -> None:
    bench = Bench(kd=1, REFPID=10).start().run(10)
    bench.card.F[303] = 0
    bench.run(10)
    bench["REFPID"] = 500
    assert bench.start().run()["DG_PID"] == 0


@pytest.mark.manual("ARP-113")
@pytest.mark.parametrize(("offdac", "volts"), [(-2.5, -2.5), (12, 10), (-12, -10)])
def test_switched_off_the_output_is_at_offdac(offdac: float, volts: float) -> None:
    bench = Bench(OFFDAC=offdac, MAXDAC=1, MINDAC=0).run(2)
    assert (bench.volts, bench["DG_DAC"]) == (volts, volts)


# ---- closed loop, and everything against a second computation


def in_a_loop(bench: Bench, ms: int, plant: Callable[[float], float]) -> list[float]:
    """Tension after each period; `plant` receives the volts and returns the tension."""
    bench.card.V[FIRST + INPUTS.index("KMIS")] = 1_000
    tensions = []
    for _ in range(ms):
        tension = plant(bench.volts)
        bench.card.inputs.take(1, tension * 1e-6)
        bench.run()
        tensions.append(tension)
    return tensions


@pytest.mark.manual("ARP-113")
def test_with_an_integral_part_the_tension_comes_to_its_reference() -> None:
    bench = Bench(kp=0.01, ki=0.1, REFPID=400, DELTAR=999_999, MAXERR=1_000).start()
    state = 0.0

    def lag(volts: float) -> float:
        nonlocal state
        state += (100 * volts - state) * PERIOD_S / 0.2  # 100 uV per volt, 0.2 s
        return state

    tensions = in_a_loop(bench, 4_000, lag)
    assert max(tensions) < 1.1 * 400
    assert tensions[-1] == pytest.approx(400, abs=1)
    assert bench.volts == pytest.approx(4, abs=0.01)


@pytest.mark.manual("ARP-113")
def test_without_one_a_proportional_part_leaves_the_error_of_its_gain() -> None:
    bench = Bench(kp=0.04, REFPID=100, MAXERR=1_000).start()
    state = 0.0

    def lag(volts: float) -> float:
        nonlocal state
        state += (100 * volts - state) * PERIOD_S / 0.5
        return state

    assert in_a_loop(bench, 3_000, lag)[-1] == pytest.approx(100 * 4 / 5, abs=0.1)  # loop gain 4


def computed(
    table: dict[str, float], gains: tuple[float, float, float], runs: list[tuple[float, float]]
) -> list[float]:
    """DG_... of the last period of a regulator that is started at once, by digest 14 line by line."""
    kp, ki, kd = gains
    ref = integral = 0.0
    old: float | None = None
    published: list[float] = []
    for cell, speed in runs:
        mis = cell * table["KMIS"] + table["OFFMIS"]
        way = table["REFPID"] - ref
        ref += min(abs(way), table["DELTAR"] * PERIOD_S) * (1 if way > 0 else -1)
        dg_ref = ref + table["OFFREF"]
        err = sorted([-table["MAXERR"], (dg_ref - mis) * table["KERR"], table["MAXERR"]])[1]
        raised = integral + err * PERIOD_S
        pid = kp * err + ki * raised + (kd * (err - old) / PERIOD_S if old is not None else 0.0)
        old = err
        if pid > table["MAXPID"]:
            pid, raised = table["MAXPID"], min(raised, integral)
        elif pid < table["MINPID"]:
            pid, raised = table["MINPID"], max(raised, integral)
        integral = raised
        vel = table["KVEL"] * speed if table["SWCVEL"] else 0.0
        out = pid * table["KREG"] + dg_ref * table["KFF"] + vel
        dac = sorted([table["MINDAC"], out * table["KOUT"], table["MAXDAC"]])[1]
        published = [mis, dg_ref, err, pid, out, vel, sorted([-10.0, dac, 10.0])[1]]
    return published


def thousandths(low: int, high: int) -> st.SearchStrategy[float]:
    return st.integers(low, high).map(lambda raw: raw / 1_000)


TABLES = st.fixed_dictionaries(
    {
        **dict.fromkeys(("REFPID", "SGLOFF", "OFFREF", "OFFMIS"), thousandths(-200_000, 200_000)),
        **dict.fromkeys(("DELTAR", "MAXERR"), thousandths(0, 500_000)),
        **dict.fromkeys(("KMIS", "KFF", "KERR", "KREG", "KOUT", "KVEL"), thousandths(-2_000, 2_000)),
        **dict.fromkeys(("MAXPID", "MAXDAC"), thousandths(0, 12_000)),
        **dict.fromkeys(("MINPID", "MINDAC"), thousandths(-12_000, 0)),
        "OFFDAC": thousandths(-10_000, 10_000),
        "SWCVEL": st.sampled_from((0.0, 1.0)),
    }
)


@pytest.mark.long
@pytest.mark.manual("ARP-121")
@settings(max_examples=60, deadline=None)
@given(
    TABLES,
    st.tuples(*[thousandths(0, 5_000)] * 3),
    st.lists(st.tuples(st.integers(-9_000, 9_000), thousandths(-50_000, 50_000)), min_size=1, max_size=30),
)
def test_every_diagnostic_is_that_of_a_second_computation(
    table: dict[str, float], gains: tuple[float, float, float], runs: list[tuple[float, float]]
) -> None:
    bench = Bench(*gains)
    for name, value in table.items():
        bench[name] = value
    bench.start()
    for index, (cell, speed) in enumerate(runs):
        bench.card.speeds[1] = round(speed * 1_000)
        bench.measure(cell)
        expected = computed(table, gains, [(cell, speed) for cell, speed in runs[: index + 1]])
        # rounded to a thousandth, and the load cell itself to a thousandth of a microvolt
        assert [bench[name] for name in DIAGNOSTICS] == pytest.approx(expected, abs=0.00051, rel=1e-9)
        assert bench.volts == pytest.approx(expected[-1], abs=1e-6)
        assert table["MINDAC"] <= bench.volts <= table["MAXDAC"]
        assert abs(bench.volts) <= 10


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.integers(-(2**31), 2**31 - 1), min_size=18, max_size=18), st.booleans(), st.integers(-20_000, 20_000)
)
def test_no_table_breaks_it(raw: list[int], is_started: bool, cell: int) -> None:
    """Variables may contain any bits."""
    bench = Bench(kp=999_999, ki=999_999, kd=999_999)
    bench.measure(cell)
    bench.card.V[FIRST : FIRST + 18] = raw
    bench.card.F[303] = int(is_started)
    bench.run(3)
    bench.card.F[303] = 0
    bench.run(3)
    assert abs(bench.volts) <= 10
    assert all(abs(bench[name]) <= 999_999.999 for name in DIAGNOSTICS)


# ---- the program of the manual


@pytest.mark.manual("ARP-074")
@pytest.mark.manual("ARP-113")
@pytest.mark.manual("ARP-121")
def test_a16_test_pid_shows_the_tension_on_the_other_output() -> None:
    bench = SignalsBench(TEST_PID, SignalsCard({2: 1, 4: 1000}))
    card = bench.card
    for name, value in {**PLAIN, "KMIS": 0.05, "REFPID": 300, "OFFDAC": 1}.items():
        card.V[FIRST + NAMES.index(name)] = round(value * 1_000)
    card.inputs.take(1, 0.005)  # 5000 uV: a tension of 250
    bench.run(100)
    assert card.F[303:307] == [0, 0, 1, 1]
    assert (card.V[10], card.V[68], card.V[11]) == (5_000_000, 250_000, 5_000)
    assert (card.outputs.volts(1), card.outputs.volts(2)) == (5.0, 1.0)
    card.F[303] = 1
    assert bench.run(2).card.F[303:307] == [1, 0, 0, 1]
    assert card.outputs.volts(2) == 10.0  # KP is 1 by itself: 300 - 250, and MAXDAC
    card.inputs.take(1, -0.003)
    assert bench.run(100).card.outputs.volts(1) == -3.0
    assert card.errors.warning == 0
