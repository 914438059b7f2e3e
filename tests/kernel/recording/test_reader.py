"""Readers of recordings and the processes that they read: losses, owners, limits, and questions that are junk."""

import asyncio
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from in_loop import in_loop
from jumping_loop import run_jumping
from patience import PATIENCE_S
from recording_bench import HandLine, process_on

from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError
from fieldrig.recording import reader, record_set, recorders
from fieldrig.recording.reader import Reader, Rows


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "ACKNOWLEDGE_S", 0.001)


def column(rows: list[Rows], number: int) -> list[float]:
    found = (part.values[part.columns.index(number)] for part in rows if number in part.columns)
    return [value for values in found for value in values]


async def until(condition: Any) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not condition():
            await asyncio.sleep(0.001)


@pytest.mark.long
@given(st.lists(st.booleans(), max_size=120), st.integers(1, 40), st.integers(1, 9))
def test_what_is_lost_on_the_way_is_asked_for_again(losses: list[bool], batches: int, cycles: int) -> None:
    fate: Iterator[bool] = iter(losses)

    async def main() -> None:
        line, rows = HandLine(lambda: next(fate, False)), list[Rows]()
        source, process = process_on(line)
        listener = Reader(line, ["hand/x", "hand/on"], "cycle", rows.append)
        await listener.begin()
        for number in range(batches):
            for _ in range(cycles):
                source.cycle()
            process.flush()
            if number % 5 == 0:
                await asyncio.sleep(0)
        await listener.end()
        process.close()
        assert column(rows, 0) == [float(number) for number in range(1, batches * cycles + 1)]
        assert listener.lost == 0

    asyncio.run(main())


@in_loop
async def test_what_the_process_has_no_more_is_counted() -> None:
    line, rows = HandLine(lambda: True), list[Rows]()
    source, process = process_on(line)
    listener = Reader(line, ["hand/x"], "cycle", rows.append)
    await listener.begin()
    for _ in range(record_set.MOST_KEPT + 10):
        source.cycle()
        process.flush()
    await listener.end()
    assert listener.lost == 10
    assert len(column(rows, 0)) == record_set.MOST_KEPT
    process.close()


@in_loop
async def test_nothing_is_published_for_a_reader_that_has_stopped_reading() -> None:
    line = HandLine()
    source, process = process_on(line)
    line.show_life("recorder/me")
    wish = {"command": "begin", "id": "one", "owner": "me", "signals": ["hand/x"], "rhythm": "cycle"}
    await line.ask("process/p/record", wish, 1)
    for _ in range(record_set.MOST_BEHIND + 30):
        source.cycle()
        process.flush()
    assert line.published == record_set.MOST_BEHIND
    state = await line.ask("process/p/record", {"command": "acknowledge", "id": "one", "number": 80}, 1)
    assert state == {"next": record_set.MOST_BEHIND + 30, "oldest": 0}
    source.cycle()
    process.flush()
    assert line.published == record_set.MOST_BEHIND + 1
    process.close()


@in_loop
async def test_a_rig_in_virtual_time_waits_for_its_reader_until_it_is_dead() -> None:
    line = HandLine()
    source, process = process_on(line, is_lossless=True)
    end_life = line.show_life("recorder/me")
    wish = {"command": "begin", "id": "one", "owner": "me", "signals": ["hand/x"], "rhythm": "cycle"}
    await line.ask("process/p/record", wish, 1)
    while not process.is_behind:
        source.cycle()
        process.flush()
    waiting = asyncio.create_task(process.until_room())
    await asyncio.sleep(0)
    await line.ask("process/p/record", {"command": "acknowledge", "id": "one", "number": 1}, 1)
    await waiting
    source.cycle()
    process.flush()
    assert process.is_behind
    end_life()
    await process.until_room()
    process.close()


@in_loop
async def test_a_recording_ends_with_its_owner_and_others_go_on() -> None:
    line = HandLine()
    source, process = process_on(line)
    one, two = Reader(line, ["hand/x"], "cycle", lambda _: None), Reader(line, ["hand/x"], "cycle", lambda _: None)
    await one.begin()
    await two.begin()
    assert len(source.hand.cycles) == 2
    line.die(one.owner)
    assert len(source.hand.cycles) == 1
    await two.end()
    assert source.hand.cycles == []
    process.close()


@in_loop
async def test_an_owner_that_was_never_seen_has_no_recording_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorders, "OWNER_S", 0.001)
    line = HandLine()
    source, process = process_on(line)
    wish = {"command": "begin", "id": "one", "owner": "me", "signals": ["hand/x"], "rhythm": "cycle"}
    await line.ask("process/p/record", wish, 1)
    await until(lambda: not source.hand.cycles)
    process.close()


def test_an_owner_whose_end_was_reported_and_who_lives_is_read_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """The end of a broken connection may be heard after the begin of the next one."""
    monkeypatch.setattr(reader, "ACKNOWLEDGE_S", 0.4)

    async def read() -> None:
        line = HandLine()
        source, process = process_on(line)
        listener = Reader(line, ["hand/x"], "cycle", lambda _: None)
        await listener.begin()
        line.die(listener.owner)
        await asyncio.sleep(2 * reader.ACKNOWLEDGE_S)
        begun = [*source.hand.cycles]
        assert len(begun) == 1
        await asyncio.sleep(5 * recorders.OWNER_S)
        assert source.hand.cycles == begun
        await listener.end()
        process.close()

    run_jumping(read())


@in_loop
async def test_a_process_that_was_restarted_is_read_on() -> None:
    line, rows = HandLine(), list[Rows]()
    source, process = process_on(line)
    listener = Reader(line, ["hand/x", "hand/word"], "cycle", rows.append)
    await listener.begin()
    source.cycle()
    process.close()
    source, process = process_on(line)
    await until(lambda: source.hand.cycles)
    for source.hand.values["word"] in ("busy", "idle"):
        source.cycle()
    process.flush()
    await listener.end()
    assert column(rows, 0) == [1, 1, 2]
    assert [part.lost for part in rows] == [0, reader.LEAST_LOST]
    assert [listener.columns[1].states[int(value)] for value in column(rows, 1)] == ["idle", "busy", "idle"]
    process.close()


@pytest.mark.parametrize("ran_on_ns", [0, 1])
@in_loop
async def test_a_rig_that_went_back_has_lost_rows_only_if_it_ran_on_before_it_was_read_again(ran_on_ns: int) -> None:
    line, rows, complete = HandLine(), list[Rows](), list[int]()
    source, process = process_on(line)
    listener = Reader(line, ["hand/x"], "cycle", rows.append, complete.append)
    await listener.begin()
    for _ in range(3):
        source.cycle()
    process.flush()
    await until(lambda: source.at_ns in complete)
    source.at_ns = 1_000_000
    process.forget()
    source.at_ns += ran_on_ns
    await until(lambda: source.hand.cycles)
    source.cycle()
    process.flush()
    await listener.end()
    assert [part.lost for part in rows] == [0, reader.LEAST_LOST if ran_on_ns else 0]
    process.close()


@in_loop
async def test_changes_come_with_their_instants_and_the_present_values_first() -> None:
    line, rows, complete = HandLine(), list[Rows](), list[int]()
    source, process = process_on(line)
    listener = Reader(line, ["hand/on", "hand/x"], "change", rows.append, complete.append)
    columns = await listener.begin()
    source.hand.change(5, "on", True)
    source.hand.change(5, "on", False)
    source.hand.change(7, "x", 3)
    source.at_ns = 9
    await listener.end()
    process.close()
    source.hand.change(8, "x", 4)
    events = {part.columns: list(zip(part.times_ns, part.values[0], strict=True)) for part in rows}
    assert events == {(0,): [(0, 0.0), (5, 1.0), (5, 0.0)], (1,): [(0, 0.0), (7, 3.0)]}
    assert [(column.name, column.kind, column.unit) for column in columns] == [
        ("hand/on", "truth", "m"),
        ("hand/x", "number", "m"),
    ]


@pytest.mark.parametrize("signals", [["hand/z"], ["foot/x"], ["can0/x"], ["hand"], ["hand/x", "hand/"]])
@in_loop
async def test_a_signal_that_is_not_there_is_refused_and_nothing_is_left(signals: list[str]) -> None:
    line = HandLine()
    source, process = process_on(line)
    with pytest.raises(ControlError):
        await Reader(line, signals, "cycle", lambda _: None).begin()
    assert not source.hand.cycles
    assert not source.ticks
    assert not any(line.ears.values())
    process.close()


@in_loop
async def test_a_process_that_stops_begins_no_recording() -> None:
    line = HandLine()
    _, process = process_on(line)
    process.close()
    with pytest.raises(ControlError, match="is stopping"):
        await Reader(line, ["hand/x"], "cycle", lambda rows: None).begin()


@in_loop
async def test_recordings_are_limited() -> None:
    line = HandLine()
    source, process = process_on(line)
    listeners = [Reader(line, ["hand/x"], "cycle", lambda _: None) for _ in range(recorders.MOST_SETS)]
    for listener in listeners:
        await listener.begin()
    with pytest.raises(ControlError, match="has 16 recordings already"):
        await Reader(line, ["hand/x"], "cycle", lambda _: None).begin()
    for listener in listeners:
        await listener.end()
    source.hand.values |= {f"v{number}": 0 for number in range(recorders.MOST_SIGNALS)}
    with pytest.raises(ControlError, match="too many values in a second"):
        await Reader(line, [f"hand/v{number}" for number in range(1_000)], 100_000, lambda _: None).begin()
    process.close()


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(1 << 63), (1 << 64) - 1) | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)
QUESTIONS = st.fixed_dictionaries(
    {},
    optional={
        "command": st.sampled_from(["begin", "again", "acknowledge", "stop", "end"]) | JSON,
        "id": st.just("one") | JSON,
        "owner": st.just("me") | JSON,
        "signals": st.lists(st.sampled_from(["hand/x", "hand/word", "hand/", "no/x"]) | st.text(), max_size=3) | JSON,
        "rhythm": st.sampled_from(["cycle", "change", 1_000_000]) | JSON,
        "first": st.integers() | JSON,
        "end": st.integers() | JSON,
        "number": st.integers() | JSON,
    },
)


@pytest.mark.long
@settings(max_examples=50)
@given(st.lists(QUESTIONS | JSON, max_size=6))
def test_any_question_is_answered_or_refused(questions: list[Any]) -> None:
    async def main() -> None:
        line = HandLine()
        source, process = process_on(line)
        for question in questions:
            try:
                await process.answer("record", question)
            except (ControlError, MalformedError):
                continue
            source.cycle()
        process.close()

    asyncio.run(main())
