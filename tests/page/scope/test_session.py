"""One page's scope: what it is sent, how it triggers, and that several pages do not disturb each other."""

import asyncio
from math import isnan
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from in_loop import in_loop
from scope_bench import ScopeBench

from fieldrig.clock import MS, S
from fieldrig.outside.untrusted import MalformedError
from fieldrig_page.scope.session import Session, read_wish
from fieldrig_page.scope.setup import Setup, read_setup
from fieldrig_page.scope.triggers import Hit

RISING = {"kind": "edge", "signal": "io/a", "level": 0.5, "what": "rising"}


@in_loop
async def test_the_newest_window_rolls_by_deltas_of_new_buckets_only() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a", "io/b"], window_ns=100 * MS)
    for begin in range(0, 300, 50):
        bench.feed(
            [at * MS for at in range(begin, begin + 50)], [float(at) for at in range(begin, begin + 50)], [0.0] * 50
        )
        assert page.look()
        assert not page.look()
    assert page.frame["whole"] is False
    assert [part["n"] for part in page.frame["parts"]] == [50]
    assert page.drawn(0) == [float(at) for at in range(199, 299)]
    assert [column["unit"] for column in page.columns] == ["V", "V"]


@in_loop
async def test_a_page_that_was_behind_gets_the_whole_again() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a"], window_ns=100 * MS)
    bench.feed([at * MS for at in range(150)], [1.0] * 150)
    page.look()
    bench.feed([at * MS for at in range(150, 180)], [2.0] * 30)
    page.session.frame()  # it never gets there
    await page.want()
    assert page.look()
    assert page.frame["whole"] is True
    assert page.drawn(0) == [1.0] * 71 + [2.0] * 29


@in_loop
async def test_lost_samples_are_drawn_as_a_gap_and_said() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a"], window_ns=100 * MS)
    bench.feed([at * MS for at in range(50)], [1.0] * 50)
    page.look()
    bench.feed([at * MS for at in range(70, 101)], [1.0] * 31, lost=20)
    page.look()
    assert [place for place, value in enumerate(page.drawn(0)) if isnan(value)] == list(range(50, 70))
    assert page.status["lost"] == [20]
    assert page.gaps == [{"rows": [0], "first_ns": 49 * MS, "end_ns": 70 * MS, "lost": 20}]


@pytest.mark.long
@settings(max_examples=30)
@given(st.integers(250, 3_000), st.lists(st.integers(1, 700), min_size=1, max_size=30))
def test_a_pulse_of_one_sample_is_caught_with_what_was_before_for_any_batches(place: int, lengths: list[int]) -> None:
    async def catch() -> None:
        bench = ScopeBench()
        setup = {"signals": ["io/a", "io/b"], "window_ns": 400 * MS, "mode": "single", "trigger": RISING}
        page = await bench.page(**setup)
        at = 0
        while at < 4_000:
            length = lengths[at % len(lengths)]
            times = range(at, at + length)
            bench.feed([t * MS for t in times], [float(t == place) for t in times], [float(t) for t in times])
            at += length
        page.look()
        assert page.status["state"] == "caught"
        capture = page.status["capture"]
        assert (capture["trigger_ns"], capture["after_ns"]) == (place * MS, place * MS)
        assert (capture["first_ns"], capture["end_ns"]) == ((place - 200) * MS, (place + 200) * MS)
        found = bench.captures[capture["number"]].traces["io/a"]
        assert sum(found.track.values[found.column]) == 1.0
        assert max(page.drawn(0)) == 1.0

    asyncio.run(catch())


@in_loop
async def test_single_stops_normal_goes_on_and_another_arm_begins_anew() -> None:
    bench = ScopeBench()
    setup = {"signals": ["io/a"], "window_ns": 20 * MS, "mode": "single", "trigger": RISING}
    single = await bench.page(**setup)
    normal = await bench.page(**{**setup, "mode": "normal"})
    assert len(bench.readers) == 1  # the recording is shared

    def pulse(begin: int) -> None:
        bench.feed(
            [t * MS for t in range(begin, begin + 100)], [float(t % 100 == 50) for t in range(begin, begin + 100)]
        )

    for begin in (0, 100, 200):
        pulse(begin)
    single.look()
    normal.look()
    assert (single.status["capture"]["trigger_ns"], normal.status["capture"]["trigger_ns"]) == (50 * MS, 250 * MS)
    assert (single.status["hits"], normal.status["hits"]) == (1, 3)
    await single.want(arm=1)
    single.look()
    assert single.status["state"] == "armed"
    pulse(300)
    single.look()
    assert single.status["capture"]["trigger_ns"] == 350 * MS


@in_loop
async def test_each_pulse_of_one_batch_is_caught() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a"], window_ns=20 * MS, mode="normal", trigger=RISING)
    bench.feed([t * MS for t in range(1000)], [float(t % 100 == 50) for t in range(1000)])
    page.look()
    assert page.status["hits"] == 10
    assert page.status["capture"]["trigger_ns"] == 950 * MS


@in_loop
async def test_auto_rolls_while_nothing_triggers() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a"], window_ns=20 * MS, mode="auto", trigger=RISING)
    bench.feed([t * MS for t in range(30)], [float(t == 10) for t in range(30)])
    page.look()
    assert page.status["capture"]["trigger_ns"] == 10 * MS
    bench.feed([t * MS for t in range(30, 100)], [0.0] * 70)
    page.look()
    assert (page.status["state"], page.status["capture"]) == ("running", None)


@in_loop
async def test_a_wrong_signal_is_said_and_takes_nothing_from_the_others() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a", "xx/b", "io/c"], window_ns=100 * MS)
    for number, reader in enumerate(bench.readers):
        if all(name.startswith("io/") for name in reader.signals):
            bench.feed([0, 10 * MS], *[[1.0, 1.0]] * len(reader.signals), reader=number)
    page.look()
    assert [column["is_there"] for column in page.columns] == [True, False, True]
    assert "did you mean io/a?" in page.columns[1]["trouble"]
    assert "the rig has no xx/b" in page.status["trouble"]


@in_loop
async def test_a_text_that_its_signal_has_not_had_yet_is_waited_for() -> None:
    bench = ScopeBench()
    trigger = {"kind": "state", "signal": "io/message", "what": "run"}
    page = await bench.page(signals=["io/message"], window_ns=10 * MS, mode="single", trigger=trigger)
    bench.feed([at * MS for at in range(20)], [0.0] * 20)
    page.look()
    assert (page.status["state"], page.status["trouble"]) == ("armed", "")
    (column,) = page.columns
    assert (column["states"], column["is_open"]) == (["ready"], True)
    signal = bench.recordings.want("another page", ["io/message"], "cycle")["io/message"]
    signal.states = ["ready", "stop", "run"]
    bench.feed([at * MS for at in range(20, 40)], [1.0] * 10 + [2.0] * 10)
    page.look()
    assert page.status["state"] == "caught"
    assert page.status["capture"]["trigger_ns"] == page.status["capture"]["first_ns"] + 5 * MS
    refused = await bench.page(
        signals=["io/state"], window_ns=10 * MS, mode="single", trigger={**trigger, "signal": "io/state"}
    )
    bench.feed([0], [0.0], reader=1)
    refused.look()
    assert "has no state 'run'" in refused.status["trouble"]


@in_loop
async def test_a_wire_holds_its_value_until_what_is_known() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["wires/lamp"], window_ns=100 * MS)
    bench.feed([0], [1.0])
    bench.readers[0].reach(150 * MS)
    page.look()
    assert page.drawn(0) == []  # no news: the value before holds
    assert page.frame["before"] == [1.0]


@in_loop
async def test_stop_keeps_all_that_there_is_to_look_around_in() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a"], window_ns=100 * MS)
    bench.feed([t * MS for t in range(1000)], [float(t) for t in range(1000)])
    await page.want(is_stopped=True)
    page.look()
    number = page.status["capture"]["number"]
    bench.feed([t * MS for t in range(1000, 2000)], [0.0] * 1000)
    await page.want(view_ns=[500 * MS, 510 * MS], cursors_ns=[502 * MS, 503.5 * MS], capture=number)
    page.look()
    assert page.drawn(0) == [float(t) for t in range(500, 510)]
    assert page.frame["cursors"] == [[502.0], [503.0]]
    assert not page.look()


@in_loop
async def test_another_process_that_is_silent_is_not_awaited_for_ever() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a", "wires/lamp"], window_ns=20 * MS, mode="single", trigger=RISING)
    bench.feed([0], [1.0], columns=(1,))
    bench.feed([t * MS for t in range(50)], [float(t == 20) for t in range(50)], columns=(0,))
    page.look()
    assert page.status["state"] == "triggered"
    bench.now_s = 2.0
    page.look()
    assert page.status["state"] == "caught"
    assert list(bench.captures[1].traces) == ["io/a", "wires/lamp"]


@in_loop
async def test_a_message_that_comes_before_the_readers_has_what_they_read_after_it() -> None:
    bench = ScopeBench()
    session = Session(bench.recordings, bench.captures, 0, lambda: bench.now_s, object())
    bench.sessions.append(session)
    trigger = {"kind": "message", "part": "can0", "words": "EMCY"}
    setup = {"signals": ["io/a"], "window_ns": 20 * MS, "mode": "single", "trigger": trigger}
    session.want(read_wish({"setup": setup, "pixels": 100}))
    session.strike(Hit(0, 10 * MS, 10 * MS))
    assert not bench.captures.all()
    await asyncio.sleep(0)  # the readers begin
    await asyncio.sleep(0)
    bench.feed([t * MS for t in range(12, 40)], [1.0] * 28)
    assert [list(capture.traces) for capture in bench.captures.all()] == [["io/a"]]


@in_loop
async def test_a_message_without_any_reader_is_not_kept_for_ever() -> None:
    bench = ScopeBench()
    session = Session(bench.recordings, bench.captures, 0, lambda: bench.now_s, object())
    trigger = {"kind": "message", "part": "can0"}
    setup = {"signals": ["io/a"], "window_ns": 20 * MS, "mode": "single", "trigger": trigger}
    session.want(read_wish({"setup": setup, "pixels": 100}))
    session.strike(Hit(0, 10 * MS, 10 * MS))
    bench.now_s = 2.0
    session.tick()
    assert session.caught is not None


@in_loop
async def test_xy_has_a_point_for_each_sample() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a", "io/b"], window_ns=100 * MS, xy=["io/a", "io/b"])
    bench.feed([t * MS for t in range(150)], [float(t) for t in range(150)], [float(-t) for t in range(150)])
    page.look()
    assert page.frame["xy"]["each"] == 1
    assert len(page.frame["xy"]["x"]) == len(page.frame["xy"]["y"]) == 8 * 100


@in_loop
async def test_many_signals_chosen_one_by_one_need_few_readers() -> None:
    bench = ScopeBench()
    names = [f"io/{number}" for number in range(20)]
    page = await bench.page(signals=names[:1], window_ns=100 * MS)
    for count in range(2, 21):
        await page.want({"signals": names[:count], "window_ns": 100 * MS})
    open_readers = [reader for reader in bench.readers if not reader.is_ended]
    assert len(open_readers) <= 6
    assert sorted(name for reader in open_readers for name in reader.signals) == sorted(names)


@in_loop
async def test_time_that_begins_anew_is_drawn_anew() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a"], window_ns=S)
    bench.feed([t * 100 * MS for t in range(20)], [1.0] * 20)
    page.look()
    bench.feed([t * 100 * MS for t in range(3)], [2.0] * 3)
    page.look()
    assert page.frame["whole"] is True
    assert page.drawn(0)[-1] == 2.0


@pytest.mark.parametrize(
    ("wish", "wrong"),
    [
        (None, "expected an object"),
        ({"setup": {}}, "pixels"),
        ({"setup": {}, "pixels": float("inf")}, "2\\*\\*62"),
        ({"setup": {"signals": 3}, "pixels": 100}, "signals"),
        ({"setup": {"signals": ["a/b"] * 33}, "pixels": 100}, "at most 32"),
        ({"setup": {"speed": 3}, "pixels": 100}, "'speed': expected one of"),
        ({"setup": {"mode": "single"}, "pixels": 100}, "trigger: the mode single waits for one"),
        ({"setup": {"window_ns": 1}, "pixels": 100}, "window_ns"),
        ({"setup": {"before": 2}, "pixels": 100}, "before"),
        ({"setup": {}, "pixels": 100, "view_ns": [5, 5]}, "view_ns"),
        ({"setup": {}, "pixels": 100, "cursors_ns": [1, 2, 3]}, "cursors_ns"),
    ],
)
def test_what_is_no_wish_is_refused(wish: Any, wrong: str) -> None:
    with pytest.raises(MalformedError, match=wrong):
        read_wish(wish)


@in_loop
async def test_a_gap_costs_a_delta_from_its_beginning_and_not_the_whole() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["wires/a"], window_ns=100 * MS)
    bench.feed([0, 10 * MS], [1.0, 2.0])
    bench.readers[0].reach(40 * MS)
    page.look()
    bench.feed([50 * MS], [3.0], lost=1)
    bench.readers[0].reach(60 * MS)
    page.look()
    assert page.frame["whole"] is False
    assert [page.low[0][number] for number in (10, 50)] == [2.0, 3.0]
    assert all(isnan(page.low[0][number]) for number in range(11, 50))
    assert [gap["lost"] for gap in page.gaps] == [1]


@in_loop
async def test_lost_changes_of_a_wire_leave_it_unknown_until_the_next_one() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["wires/a"], window_ns=100 * MS)
    bench.feed([0], [1.0])
    bench.feed([], [], lost=2)
    bench.readers[0].reach(60 * MS)
    bench.feed([60 * MS], [3.0])
    bench.readers[0].reach(100 * MS)
    page.look()
    assert isnan(page.high[0][50])
    assert page.status["lost"] == [2]


@in_loop
async def test_a_page_that_changes_its_set_up_often_leaves_no_readers_behind() -> None:
    bench = ScopeBench()
    page = await bench.page(signals=["io/a"], window_ns=S)
    for period_ms in range(1, 40):
        await page.want({"signals": ["io/a"], "window_ns": S, "rhythm": period_ms * MS})
    assert len([reader for reader in bench.readers if not reader.is_ended]) <= 8


junk = st.recursive(
    st.none() | st.booleans() | st.integers(-(1 << 63), (1 << 64) - 1) | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=5,
)
KEYS = ("pixels", "arm", "is_stopped", "capture", "view_ns", "cursors_ns")


@pytest.mark.long
@given(st.fixed_dictionaries({}, optional=dict.fromkeys((*KEYS, "setup"), junk)), junk, st.sampled_from(Setup._fields))
def test_junk_as_a_wish_raises_nothing_else(wish: dict[str, Any], value: Any, key: str) -> None:
    for given_wish in (value, wish, {"pixels": 100, "setup": {key: value}}, {"setup": {}, "pixels": 100, **wish}):
        try:
            checked = read_wish(given_wish)
        except MalformedError:
            continue
        assert read_setup(checked.setup.as_data()) == checked.setup
