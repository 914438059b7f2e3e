"""The telephone network as a function of time: calls, tones, ringing, carriers, and what its faults do to them."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from telephone_bench import A, B, C, Exchange

from fieldrig.bus import Delivery
from fieldrig.clock import MS
from fieldrig.faults.note import FaultNote
from fieldrig_bus.telephone.faults import MODELS
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, Ring, TelephoneMessage, Tone
from fieldrig_bus.telephone.modulation import everything

DIAL, RINGING, BUSY = Heard(Tone.DIAL), Heard(Tone.RINGING), Heard(Tone.BUSY)
UNOBTAINABLE, SILENCE = Heard(Tone.UNOBTAINABLE), Heard(Tone.SILENCE)


def test_a_seized_line_gives_the_dial_tone() -> None:
    assert Exchange().say(A, Hook(True)).take(A) == [DIAL]


def test_the_called_line_rings_in_the_cadence_until_it_is_answered() -> None:
    net = Exchange(ring_on_ms=1000, ring_off_ms=4000).say(A, Hook(True), Dial("200")).run_to(5500)
    on, off = Ring(True, "100"), Ring(False, "100")
    assert net.heard[B] == [(0, on), (1000, off), (5000, on)]
    net.say(B, Hook(True)).run_to(20_000)
    assert net.heard[B][3:] == [(5500, off)]
    assert net.take(A) == [DIAL, RINGING, SILENCE]


def test_a_caller_that_hangs_up_ends_the_ringing() -> None:
    net = Exchange().say(A, Hook(True), Dial("200")).run_to(500).say(A, Hook(False)).run_to(10_000)
    assert net.heard[B] == [(0, Ring(True, "100")), (500, Ring(False, "100"))]


def test_a_number_may_come_digit_by_digit() -> None:
    net = Exchange().say(A, Hook(True), Dial("2"), Dial("0")).run_to(1000)
    assert net.take(B) == []
    assert net.say(A, Dial("0")).take(B) == [Ring(True, "100")]


def test_a_number_that_is_not_there_is_unobtainable() -> None:
    assert Exchange().say(A, Hook(True), Dial("9")).take(A) == [DIAL, UNOBTAINABLE]


def test_a_prefix_gives_the_second_dial_tone() -> None:
    net = Exchange(outside_prefix="0").say(A, Hook(True), Dial("0"))
    assert net.take(A) == [DIAL, DIAL]
    assert net.say(A, Dial("200")).take(A) == [RINGING]


def test_a_line_in_use_is_busy() -> None:
    net = Exchange().connected()
    assert net.say(C, Hook(True), Dial("200")).take(C) == [DIAL, BUSY]
    assert net.say(A, Hook(False)).run_to(1000).say(A, Hook(True), Dial("100")).take(A) == [DIAL, BUSY]


def test_the_other_end_hears_the_busy_tone_when_a_call_ends() -> None:
    net = Exchange(delay_ms=10).connected().say(A, b"last", Hook(False)).run_to(200)
    assert net.take(B) == [BUSY]  # the rest of the data is lost with the carrier
    assert net.say(B, Hook(False), Hook(True)).take(B) == [DIAL]


def test_what_is_under_way_when_a_call_ends_arrives() -> None:
    net = Exchange(delay_ms=30).connected(9600).say(A, b"0123456789").run_to(111)  # 10 characters take 10.4 ms
    net.say(A, Hook(False)).run_to(300)
    assert net.heard[B] == [(pytest.approx(134.17, abs=0.01), b"0123"), (pytest.approx(138.33, abs=0.01), b"4567"),
                            (pytest.approx(140.42, abs=0.01), b"89"), (141, BUSY)]  # fmt: skip


@given(
    st.sampled_from([{"bps": 300}, {"bps": 9600, "is_corrected": True}]),
    st.lists(st.tuples(st.sampled_from([A, B]), st.binary(max_size=40), st.integers(0, 90)), max_size=6),
    st.sampled_from([Hook(False), Hook(True), Carrier(0), Carrier(1200), Ready(False), b"more"]),
    st.sampled_from([A, B]),
)
def test_a_host_that_looks_late_hears_the_same(
    carrier: dict[str, Any], said: list[tuple[str, bytes, int]], last: TelephoneMessage, sender: str
) -> None:
    in_time, late = (Exchange(delay_ms=5).connected(**carrier) for _ in range(2))
    for member, data, pause_ms in said:
        for net in (in_time, late):
            net.say(member, data)
            net.now_ns += pause_ms * MS + 7  # nothing happens at the very instant of a message
        in_time.run_to(in_time.now_ns / MS)
    for net in (in_time, late):
        net.say(sender, last).run_to(5000)
    assert late.heard == in_time.heard


@pytest.mark.parametrize(("bps", "is_corrected", "bits"), [(300, False, 10), (9600, False, 10), (33_600, True, 8)])
def test_data_take_the_time_of_the_carrier_to_the_bit(bps: int, is_corrected: bool, bits: int) -> None:
    net = Exchange(delay_ms=10).connected(bps, is_corrected).say(A, bytes(1000)).run_to(60_000)
    instant, _ = net.heard[B][-1]
    assert instant == pytest.approx(100 + 10 + 1000 * bits * 1000 / bps, abs=0.001)


def test_both_directions_are_independent() -> None:
    net = Exchange(delay_ms=0).connected(9600).say(A, bytes(96)).say(B, b"x" * 96).run_to(1000)
    assert [net.heard[A][-1][0], net.heard[B][-1][0]] == [pytest.approx(200, abs=0.001)] * 2


def test_an_unpaced_network_takes_no_time_for_data() -> None:
    net = Exchange(delay_ms=10, paced=False).connected().say(A, bytes(5000)).run_to(110)
    assert len(net.data(B)) == 5000


def test_without_a_carrier_data_are_lost() -> None:
    net = Exchange().say(A, Hook(True), Dial("200")).say(B, Hook(True)).say(A, b"lost").run_to(100)
    assert net.data(B) == b""


def test_an_offer_carries_the_quality_of_the_line() -> None:
    net = Exchange(highest_bps=14_400, delay_ms=5).say(A, Hook(True), Dial("200")).say(B, Hook(True))
    net.take(A)
    net.say(B, Offer(everything())).run_to(5)
    assert net.take(A) == [Offer(everything(), 0, 14_400)]


def test_a_slow_line_lowers_the_offers_over_it() -> None:
    net = Exchange(faults=[{"what": "slow", "line": B, "highest_bps": 2400}], delay_ms=0)
    net.say(A, Hook(True), Dial("200")).say(B, Hook(True)).take(A)
    assert net.say(B, Offer(())).take(A) == [Offer((), 0, 2400)]


def test_a_cut_line_has_no_dial_tone_and_ends_its_call() -> None:
    net = Exchange(delay_ms=0).connected()
    number = net.model.add_fault(net.now_ns, {"what": "cut", "line": "b"})
    assert net.run_to(101).take(A) == [BUSY]
    assert net.say(B, Hook(False), Hook(True)).take(B) == [Carrier(0)]
    assert net.say(A, Hook(False), Hook(True), Dial("200")).take(A) == [DIAL, BUSY]
    net.say(B, Hook(False)).say(A, Hook(False), Hook(True), Dial("200"))
    assert net.take(A) == [DIAL, RINGING]  # the exchange does not know it
    assert net.take(B) == []
    net.model.clear_fault(net.now_ns, number)
    assert net.say(B, Hook(True)).take(B) == [DIAL]


def test_faults_of_calls_say_what_the_caller_hears() -> None:
    net = Exchange(faults=[{"what": "busy", "line": B}, {"what": "no_ringing", "line": C}])
    assert net.say(A, Hook(True), Dial("200")).take(A) == [DIAL, BUSY]
    assert net.say(A, Hook(False), Hook(True), Dial("301")).take(A) == [DIAL, RINGING]
    assert net.run_to(20_000).take(C) == []


def test_without_dial_tone_no_digits_are_taken() -> None:
    net = Exchange(faults=[{"what": "no_dial_tone"}]).say(A, Hook(True), Dial("200")).run_to(5000)
    assert net.take(A) == net.take(B) == []


@pytest.mark.parametrize("what", ["no_dial_tone", "cut"])
def test_a_line_that_stays_seized_gets_its_dial_tone_when_the_fault_is_over(what: str) -> None:
    net = Exchange(faults=[{"what": what, "duration_ms": 1000}]).say(A, Hook(True))
    net.say(B, Hook(True), Hook(False)).run_to(2000)
    assert net.heard[A][-1] == (1000, DIAL)
    assert DIAL not in net.take(B)
    assert net.say(A, Dial("200")).take(B) == [Ring(True, "100")]


def test_an_exchange_without_dial_tone_takes_no_digits_of_a_line_that_had_one() -> None:
    net = Exchange().say(A, Hook(True))
    number = net.model.add_fault(net.now_ns, {"what": "no_dial_tone", "line": A})
    net.say(A, Dial("200")).run_to(100)
    assert (net.take(A), net.take(B)) == ([DIAL, SILENCE], [])
    net.model.clear_fault(net.now_ns, number)
    assert net.say(A, Dial("200")).take(A) == [DIAL, RINGING]


@pytest.mark.parametrize("what", [*MODELS])
def test_the_trace_shows_the_begin_of_a_fault_and_it_counts_once(what: str) -> None:
    keys: dict[str, dict[str, float]] = {
        "noise": {"bit_error_rate": 0.1},
        "slow": {"highest_bps": 300},
        "delay": {"delay_ms": 1},
    }
    net = Exchange()
    seen: list[Delivery[Any]] = []
    net.model.add_fault(0, {"what": what, "line": B, "start_ms": 100, "duration_ms": 200, **keys.get(what, {})})
    assert net.model.all_faults(0)[1]["applied"] == 0
    while (next_ns := net.model.next_ns()) is not None:
        seen += net.model.collect(next_ns)
    assert [(each.time_ns // MS, each.sender, each.message) for each in seen] == [(100, B, FaultNote(1, what))]
    assert net.model.all_faults(300 * MS)[1]["applied"] == 1


def test_a_drop_out_takes_the_carriers_away_and_gives_them_back() -> None:
    net = Exchange(delay_ms=0).connected(9600)
    net.model.add_fault(net.now_ns, {"what": "dropout", "start_ms": "100", "duration_ms": "300"})
    net.run_to(1000)
    assert net.heard[A] == net.heard[B] == [(200, Carrier(0)), (500, Carrier(9600))]


def test_drop_outs_may_repeat_as_the_pulses_of_a_meter_do() -> None:
    net = Exchange(delay_ms=0).connected(9600)
    net.model.add_fault(net.now_ns, {"what": "dropout", "line": "a", "period_ms": 1000, "length_ms": 100})
    net.run_to(2150)
    assert [(time, bool(message.bps)) for time, message in net.heard[A] if isinstance(message, Carrier)] == [
        (100, False), (200, True), (1100, False), (1200, True), (2100, False)]  # fmt: skip


@pytest.mark.parametrize("is_corrected", [False, True])
def test_modems_without_error_correction_lose_what_is_sent_in_a_drop_out(is_corrected: bool) -> None:
    net = Exchange(delay_ms=0).connected(9600, is_corrected)
    net.model.add_fault(net.now_ns, {"what": "dropout", "start_ms": 50, "duration_ms": 100})
    sent = bytes(range(256)) * 2
    got = net.say(A, sent).run_to(5000).data(B)
    assert (got == sent) is is_corrected
    assert len(got) == (512 if is_corrected else 512 - 96)


@pytest.mark.parametrize("is_corrected", [False, True])
def test_noise_spoils_data_or_slows_them(is_corrected: bool) -> None:
    net = Exchange(delay_ms=0).connected(9600, is_corrected)
    net.model.add_fault(net.now_ns, {"what": "noise", "bit_error_rate": 0.01})
    net.say(A, bytes(960)).run_to(60_000)
    instant = net.heard[B][-1][0]
    got = net.data(B)
    assert len(got) == 960
    if is_corrected:
        assert got == bytes(960)
        assert instant > 100 + 1200
    else:
        assert 40 < sum(byte.bit_count() for byte in got) < 120  # 76.8 on average
        assert instant == pytest.approx(1100, abs=0.001)


def test_delays_add_up_and_data_do_not_overtake() -> None:
    net = Exchange(delay_ms=10).connected(9600)
    number = net.model.add_fault(net.now_ns, {"what": "delay", "delay_ms": 250})
    net.say(A, b"far").run_to(110)
    net.model.clear_fault(net.now_ns, number)
    net.say(A, b"near").run_to(1000)
    assert net.heard[B][0][0] == pytest.approx(100 + 3.125 + 260)
    assert net.data(B) == b"farnear"


def test_a_fault_of_a_line_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="there is no line of 'x'"):
        Exchange().model.add_fault(0, {"what": "cut", "line": "x"})


def test_a_member_that_leaves_ends_its_call() -> None:
    net = Exchange(delay_ms=0).connected()
    net.model.leave(A)
    assert net.run_to(200).take(B) == [BUSY]


def test_an_interest_in_data_leaves_out_the_signals() -> None:
    net = Exchange(delay_ms=0).connected()
    net.model.listen(net.now_ns, B, ["data"])
    net.say(A, Ready(False), b"data").run_to(200)
    assert net.take(B) == [b"data"]


portions = st.lists(st.tuples(st.sampled_from("ab"), st.binary(max_size=40), st.integers(0, 30)), max_size=30)


@given(portions, st.booleans(), st.sampled_from([300, 2400, 33_600]))
def test_data_arrive_once_and_in_order_in_both_directions(
    said: list[tuple[str, bytes, int]], is_corrected: bool, bps: int
) -> None:
    net = Exchange().connected(bps, is_corrected)
    if is_corrected:
        net.model.add_fault(net.now_ns, {"what": "noise", "bit_error_rate": 0.0005})
    for member, data, pause_ms in said:
        net.say(member, data).run_to(net.now_ns / 1e6 + pause_ms)
    net.run_to(net.now_ns / 1e6 + 1_000_000)
    assert net.data(B) == b"".join(data for member, data, _ in said if member == A)
    assert net.data(A) == b"".join(data for member, data, _ in said if member == B)


@given(st.lists(st.tuples(st.sampled_from("abc"), st.sampled_from([
    Hook(True), Hook(False), Dial("100"), Dial("200"), Dial("3"), Offer(everything()), Carrier(9600), Carrier(0),
    Ready(True), b"data",
]), st.integers(0, 2000)), max_size=40))  # fmt: skip
def test_members_may_say_anything_at_any_time(said: list[tuple[str, object, int]]) -> None:
    net = Exchange()
    for member, message, pause_ms in said:
        net.say(member, message).run_to(net.now_ns / 1e6 + pause_ms)  # type: ignore[arg-type]
    for member in (A, B, C):
        net.say(member, Hook(False))
    net.run_to(net.now_ns / 1e6 + 10_000)
    assert net.model.next_ns() is None
    assert net.model.statistics(net.now_ns)["calls at present"] == 0
