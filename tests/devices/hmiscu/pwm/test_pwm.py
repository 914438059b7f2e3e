"""PWM outputs: frequency, duty, enable, synchronisation and errors (manual 1470 to 1680, digest 10)."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, NEVER_NS, S
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_devices.hmiscu.blocks.pwm_block import PWM
from fieldrig_devices.hmiscu.enumerations import ErrorId
from fieldrig_devices.hmiscu.pwm.channel import PwmChannel
from fieldrig_devices.hmiscu.pwm.settings import PwmSettings

BANDS = ((1_000, 0.1), (10_000, 1.0), (200_000, 5.0), (450_000, 10.0), (650_000, 15.0))
"""Manual 1560 to 1572: the largest error of the duty in per cent, up to a frequency in 0.1 Hz."""


class Bench:
    def __init__(self, **settings: Any) -> None:
        self.signals: list[Pwm] = []
        self.channel = PwmChannel(PwmSettings.model_validate({"mode": "pwm"} | settings), self.signals.append)
        self.block = PWM(self.channel)
        self.now_ns = 0

    def cycle(self, after_ns: int = 0, **pins: int) -> set[str]:
        """Call the block later, with these pins; return the status pins that are TRUE."""
        self.now_ns += after_ns
        self.block.inputs.update(pins)
        self.block.call(self.now_ns)
        return {name for name in ("InFrequency", "Busy", "Error") if self.block.outputs[name]}

    def until(self, before_ns: int) -> list[tuple[int, bool]]:
        """Return all edges of the output up to an instant, as the wire has them."""
        while self.channel.next_ns < before_ns:
            self.channel.advance(self.channel.next_ns)
        ends = [*(signal.start_ns for signal in self.signals[1:]), before_ns]
        return [
            edge
            for signal, end_ns in zip(self.signals, ends, strict=True)
            for edge in signal.edges(signal.start_ns, end_ns)
        ]


# Pin Frequency, duty, period and pulse in ns (digest 10).
WAVES = [
    (100, 25, 100_000_000, 25_000_000),
    (10_000, 50, 1_000_000, 500_000),
    (500_000, 50, 20_000, 10_000),
    (650_000, 15, 15_385, 2_308),
]


@pytest.mark.manual("SCU-006", "SCU-069", "SCU-070", "SCU-071")
@pytest.mark.parametrize(("frequency", "duty", "period_ns", "pulse_ns"), WAVES)
def test_period_and_pulse_follow_from_the_pins(frequency: int, duty: int, period_ns: int, pulse_ns: int) -> None:
    bench = Bench()
    assert bench.cycle(F_Enable=1, Frequency=frequency, Duty=duty) == {"InFrequency"}
    edges = bench.until(1000 * period_ns)
    assert edges[:3] == [(0, True), (pulse_ns, False), (period_ns, True)]
    tenth_s = 10 * S // frequency
    assert all(abs(instant - number * 10 * S / frequency) <= 1 for number, (instant, _) in enumerate(edges[::2]))
    assert tenth_s <= period_ns


@pytest.mark.manual("SCU-072")
@given(st.integers(100, 650_000), st.integers(0, 100))
def test_the_duty_is_within_the_error_of_its_band(frequency: int, duty: int) -> None:
    bench = Bench()
    assert bench.cycle(F_Enable=1, Frequency=frequency, Duty=duty) == {"InFrequency"}  # never refused
    period_ns = 10 * S / frequency
    edges = bench.until(int(period_ns))
    high_ns = edges[1][0] if len(edges) > 1 else 0
    if 0 < duty < 100:
        assert abs(100 * high_ns / period_ns - duty) <= next(error for upto, error in BANDS if frequency <= upto)
    else:
        assert edges == []
        assert bench.channel.signal.level_at(0) == (duty == 100)


@pytest.mark.manual("SCU-070", "SCU-071", "SCU-074")
@pytest.mark.parametrize(("frequency", "duty"), [(99, 50), (650_001, 50), (0, 50), (10_000, 101), (10_000, 255)])
def test_values_out_of_range_are_an_error_until_they_are_legal(frequency: int, duty: int) -> None:
    bench = Bench()
    assert bench.cycle(F_Enable=1, Frequency=frequency, Duty=duty) == {"Error"}
    assert bench.block.outputs["ErrID"] == ErrorId.PTO_INVALID_PARAMETER
    assert bench.signals == []
    assert bench.cycle(10 * MS, Frequency=10_000, Duty=50) == {"InFrequency"}
    assert bench.block.outputs["ErrID"] == ErrorId.NO_ERROR
    assert bench.cycle(10 * MS, Frequency=frequency, Duty=duty) == {"Error"}
    assert bench.channel.signal.value == 50  # the last wave goes on


@pytest.mark.manual("SCU-069", "SCU-067", "SCU-074")
@pytest.mark.parametrize("filter_ms", [3, 12])
def test_the_input_enables_if_it_is_configured_and_allowed(filter_ms: int) -> None:
    bench = Bench(enable_input=True, enable_filter_ms=filter_ms)
    bench.cycle(Frequency=10_000, Duty=50)
    bench.channel.put_enable(0, True)
    assert bench.cycle(20 * MS) == set()  # not allowed
    bench.cycle(EN_Enable=1)
    assert bench.cycle() == {"InFrequency"}
    bench.channel.put_enable(bench.now_ns, False)
    assert bench.cycle(filter_ms * MS - 1) == {"InFrequency"}
    assert bench.cycle(1) == set()
    assert bench.signals[-1].value == 0
    assert bench.signals[-1].start_ns == bench.now_ns


def test_an_input_that_is_not_configured_enables_nothing() -> None:
    bench = Bench()
    bench.channel.put_enable(0, True)
    assert bench.cycle(20 * MS, EN_Enable=1, Frequency=10_000, Duty=50) == set()
    assert bench.signals == []


@pytest.mark.manual("SCU-074")
def test_a_change_takes_effect_with_the_next_period() -> None:
    bench = Bench()
    bench.cycle(F_Enable=1, Frequency=100, Duty=25)  # 100 ms
    assert bench.cycle(30 * MS, Frequency=200, Duty=50) == {"Busy"}
    assert bench.cycle(69 * MS) == {"Busy"}
    assert bench.cycle(1 * MS) == {"InFrequency"}
    assert bench.until(160 * MS) == [
        (0, True),
        (25 * MS, False),
        (100 * MS, True),
        (125 * MS, False),
        (150 * MS, True),
    ]


@pytest.mark.manual("SCU-074")
def test_the_next_period_counts_from_where_the_signal_has_begun() -> None:
    bench = Bench()
    bench.cycle(60 * MS, F_Enable=1, Frequency=100, Duty=25)  # 100 ms
    assert bench.cycle(90 * MS, Frequency=200) == {"Busy"}
    assert bench.cycle(9 * MS) == {"Busy"}
    assert bench.cycle(1 * MS) == {"InFrequency"}
    assert bench.signals[-1].start_ns == 160 * MS


def test_a_change_at_the_end_of_a_period_is_immediate_and_one_that_is_taken_back_does_nothing() -> None:
    bench = Bench()
    bench.cycle(F_Enable=1, Frequency=100, Duty=25)
    assert bench.cycle(100 * MS, Duty=50) == {"InFrequency"}
    assert bench.cycle(10 * MS, Duty=75) == {"Busy"}
    assert bench.cycle(10 * MS, Duty=50) == {"InFrequency"}
    assert bench.channel.next_ns == NEVER_NS


@pytest.mark.parametrize(("after_ns", "status"), [(15_384, "Busy"), (15_385, "InFrequency"), (15_386, "Busy")])
def test_a_period_begins_at_its_rounded_instant(after_ns: int, status: str) -> None:
    bench = Bench()
    bench.cycle(F_Enable=1, Frequency=650_000, Duty=50)
    assert bench.cycle(after_ns, Duty=0) == {status}
    bench.until(31_000)
    assert bench.signals[-1].start_ns == (15_385 if after_ns <= 15_385 else 30_770)


def test_busy_and_in_frequency_go_with_the_enable() -> None:
    bench = Bench()
    bench.cycle(F_Enable=1, Frequency=100, Duty=25)
    assert bench.cycle(10 * MS, Duty=50) == {"Busy"}
    assert bench.cycle(10 * MS, F_Enable=0) == set()
    assert bench.until(200 * MS) == [(0, True)]  # low from 20 ms on


def test_a_restart_in_the_instant_in_which_the_output_goes_off_puts_nothing_on_the_wire() -> None:
    bench = Bench()
    bench.cycle(F_Enable=1, Frequency=100, Duty=25)
    bench.cycle(30 * MS, F_Enable=0, F_Sync=1)
    assert [(signal.start_ns, signal.value) for signal in bench.signals[1:]] == [(30 * MS, 0)]


@pytest.mark.manual("SCU-068", "SCU-067")
def test_a_rising_f_sync_restarts_the_period() -> None:
    bench = Bench()
    bench.cycle(F_Enable=1, Frequency=100, Duty=25)
    bench.cycle(40 * MS, F_Sync=1)
    bench.cycle(20 * MS)  # the level does nothing
    assert bench.until(150 * MS) == [(0, True), (25 * MS, False), (40 * MS, True), (65 * MS, False), (140 * MS, True)]


# Edge, instants at which the period begins if the input rises at 40 ms and falls at 60 ms, behind a filter of 3 ms.
SYNC_EDGES = [("rising", [0, 43]), ("falling", [0, 63]), ("both", [0, 43, 63])]


@pytest.mark.manual("SCU-068", "SCU-073")
@pytest.mark.parametrize(("edge", "starts_ms"), SYNC_EDGES)
def test_the_sync_input_restarts_the_period_at_its_edge(edge: str, starts_ms: list[int]) -> None:
    bench = Bench(sync_input=True, sync_edge=edge)
    bench.cycle(F_Enable=1, EN_Sync=1, Frequency=100, Duty=25)
    bench.channel.put_sync(40 * MS, True)
    bench.channel.put_sync(60 * MS, False)
    bench.until(90 * MS)
    assert [signal.start_ns for signal in bench.signals] == [start * MS for start in starts_ms]


@pytest.mark.parametrize(("settings", "allowed"), [({"sync_input": False}, 1), ({"sync_input": True}, 0)])
def test_the_sync_input_needs_the_configuration_and_the_pin(settings: dict[str, bool], allowed: int) -> None:
    bench = Bench(**settings)
    bench.cycle(F_Enable=1, EN_Sync=allowed, Frequency=100, Duty=25)
    bench.channel.put_sync(40 * MS, True)
    bench.until(90 * MS)
    assert len(bench.signals) == 1
