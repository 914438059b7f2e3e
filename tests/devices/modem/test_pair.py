"""Two modems at a telephone network: calls from terminal to terminal, and data that nothing loses or doubles."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from modem_bench import Desk, Pair

from fieldrig_bus.serial.message import ControlLines

EVERY_BYTE = bytes(range(256))


def test_one_modem_dials_and_the_other_answers_by_itself() -> None:
    pair = Pair()
    pair.b.type("AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2\r")
    pair.a.type("ATE0\r")
    pair.run(1)
    pair.a.take()
    pair.b.take()
    pair.a.type("ATDT200\r")
    pair.until(lambda: bool(pair.b.got))
    assert pair.now_ms == pytest.approx(1100 + 1000 + 570, abs=20)  # dial tone and digits
    pair.until(lambda: "CONNECT" in pair.a.text and "CONNECT" in pair.b.text)
    # the second ring ends 6 s after the first began, 2 s of silence, 3 s of training
    assert pair.now_ms == pytest.approx(2670 + 6000 + 2000 + 3000, abs=60)
    pair.run(0.1)
    assert pair.a.text == "\r\nCONNECT 33600\r\n"
    assert pair.b.text == "\r\nRING\r\n\r\nRING\r\n\r\nCONNECT 33600\r\n"
    assert (pair.a.lines.dcd, pair.b.lines.dcd) == (True, True)


def test_every_byte_passes_both_ways() -> None:
    pair = Pair().connected()
    pair.a.type(EVERY_BYTE)
    pair.b.type(EVERY_BYTE[::-1])
    pair.run(2)
    assert pair.b.take() == EVERY_BYTE
    assert pair.a.take() == EVERY_BYTE[::-1]


def test_hanging_up_is_seen_at_the_other_end() -> None:
    pair = Pair().connected()
    pair.run(2).a.type("+++")
    pair.run(2)
    assert pair.b.take() == b"+++"
    pair.a.type("ATH\r")
    pair.run(1)
    assert pair.a.text.endswith("\r\nOK\r\n")
    assert pair.b.text == "\r\nNO CARRIER\r\n"
    assert (pair.a.lines.dcd, pair.b.lines.dcd) == (False, False)


def test_dropping_dtr_ends_the_call() -> None:
    pair = Pair().connected()
    pair.a.submit("terminal", ControlLines(dtr=False, rts=True))
    pair.run(1)
    assert pair.b.text == "\r\nNO CARRIER\r\n"


def test_a_call_to_itself_or_to_a_line_in_use_is_busy() -> None:
    pair = Pair()
    pair.a.type("ATE0DT100\r")
    pair.run(10)
    assert pair.a.text.endswith("\r\nBUSY\r\n")


RATES = [(300, "300", 10), (2400, "2400", 8), (9600, "9600", 8), (33_600, "33600", 8)]


@pytest.mark.parametrize(("highest_bps", "shown", "bits"), RATES)
def test_data_take_the_time_of_the_carrier(highest_bps: int, shown: str, bits: int) -> None:
    pair = Pair(highest_bps=highest_bps, baud=115_200)
    pair.connected("ATE0S0=1" + ("\\N0" if bits == 10 else ""))
    assert pair.a.modem.points()["rate"].read() == int(shown)
    begin_ms = pair.now_ms
    data = EVERY_BYTE * 4
    pair.a.type(data)
    pair.until(lambda: len(pair.b.got) >= len(data))
    assert pair.b.take() == data
    line_ms = len(data) * bits * 1000 / highest_bps
    assert pair.now_ms - begin_ms == pytest.approx(line_ms + 20, abs=12)  # the delay, and both serial lines


@pytest.mark.parametrize("correction", [0, 3])
def test_noise_and_drop_outs_hit_only_modems_without_error_correction(correction: int) -> None:
    pair = Pair().connected(f"ATE0S0=1\\N{correction}")
    pair.net.add_fault(pair.clock.now_ns(), {"what": "noise", "bit_error_rate": 0.001})
    pair.net.add_fault(pair.clock.now_ns(), {"what": "dropout", "start_ms": 200, "duration_ms": 500})
    data = EVERY_BYTE * 16
    pair.a.type(data)
    pair.run(30)
    assert (pair.b.take() == data) is (correction == 3)


@pytest.mark.manual("PD-275")
def test_a_drop_out_longer_than_s10_ends_the_call_at_both_ends() -> None:
    pair = Pair().connected()
    pair.net.add_fault(pair.clock.now_ns(), {"what": "dropout", "duration_ms": 2000})
    pair.run(5)
    assert pair.a.text == pair.b.text == "\r\nNO CARRIER\r\n"


@pytest.mark.manual("PD-275")
def test_the_pulses_of_a_meter_disturb_but_do_not_end_a_call_if_they_are_short() -> None:
    pair = Pair().connected()
    pair.net.add_fault(pair.clock.now_ns(), {"what": "dropout", "period_ms": 1000, "length_ms": 300})
    pair.a.type(EVERY_BYTE * 16)
    pair.run(20)
    assert pair.b.take() == EVERY_BYTE * 16


def test_a_modem_that_loses_its_power_ends_the_call_and_can_be_called_again() -> None:
    pair = Pair().connected()
    pair.a.modem.add_fault({"what": "power_off", "duration_ms": 1000})
    pair.run(3)
    assert pair.b.text == "\r\nNO CARRIER\r\n"
    assert pair.connected() is pair


class Slow:
    """A terminal that reads in portions, with RTS off in between; it honours CTS when it sends."""

    def __init__(self, desk: Desk, data: bytes) -> None:
        self.desk, self.left = desk, data

    def turn(self, count: int, is_reading: bool) -> None:
        self.desk.submit("terminal", ControlLines(dtr=True, rts=is_reading))
        if self.desk.lines.rts:
            self.desk.type(self.left[:count])
            self.left = self.left[count:]


turns = st.lists(st.tuples(st.integers(0, 600), st.booleans(), st.integers(0, 300), st.integers(0, 600)), max_size=25)
contents = st.binary(max_size=40).map(lambda seed: (seed + EVERY_BYTE) * 8)


@settings(deadline=None, max_examples=20)
@given(
    contents,
    turns,
    st.sampled_from([(115_200, 9600), (300, 33_600), (38_400, 33_600), (9600, 2400)]),
    st.booleans(),
    st.booleans(),
)
@pytest.mark.long
def test_nothing_is_lost_or_doubled_over_any_pacing_and_flow_control(
    data: bytes, said: list[tuple[int, bool, int, int]], rates: tuple[int, int], is_noisy: bool, is_paced: bool
) -> None:
    baud, bps = rates
    pair = Pair(paced=is_paced, baud=baud, highest_bps=bps).connected("ATE0S0=1\\N2&K3S2=128")
    if is_noisy:
        pair.net.add_fault(pair.clock.now_ns(), {"what": "noise", "bit_error_rate": 0.0002})
    first, second = Slow(pair.a, data), Slow(pair.b, data[::-1])
    for count, is_reading, other_count, pause_ms in said:
        first.turn(count, is_reading)
        second.turn(other_count, True)
        pair.run(pause_ms / 1000)
    while first.left or second.left:
        first.turn(400, True)
        second.turn(400, True)
        pair.run(0.5)
    first.turn(0, True)
    second.turn(0, True)
    pair.until(lambda: len(pair.a.got) >= len(data) and len(pair.b.got) >= len(data), 10_000).run(5)
    assert bytes(pair.b.got) == data
    assert bytes(pair.a.got) == data[::-1]
