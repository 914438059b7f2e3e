"""Troubles of devices, with words beside them about a host that was late when they began."""

import asyncio
import json
from collections.abc import Mapping
from typing import Any, ClassVar

import pytest

from fieldrig.cli.points import _echo
from fieldrig.cli.status import _lateness
from fieldrig.cli.watch import _of_point, _Shown
from fieldrig.clock import S
from fieldrig.control.device_questions import RealPoints
from fieldrig.control.troubles import LATER_NS, Troubles
from fieldrig.device import Device, Point, Value
from fieldrig.loop.real_clock import RealClock

WORDS = "the host was up to 1,240 ms late in the last seconds, load 30 on 2 cores"


class Drive(Device):
    trouble_keys: ClassVar = ("code", "missing")

    def __init__(self) -> None:
        self.code: Value = 0

    def points(self) -> Mapping[str, Point]:
        return {"code": Point(lambda: self.code), "speed": Point(lambda: 12.0)}


class Bench:
    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("fieldrig.control.troubles.time.strftime", lambda _: "14:03:22")
        self.host_words = ""
        self.drive = Drive()
        self.troubles = Troubles("belt", self.drive, lambda: self.host_words)

    def look(self, now_ns: int, code: Value) -> Mapping[str, str]:
        self.drive.code = code
        self.troubles.look(now_ns)
        return self.troubles.words()


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch)


def test_a_trouble_that_begins_on_a_late_host_has_the_words_until_it_is_over(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    assert bench.look(0, 0) == {}
    bench.host_words = WORDS
    assert bench.look(S, 2560) == {"code": f"at 14:03:22 {WORDS}"}
    assert [record.getMessage() for record in caplog.records] == [f"belt/code is 2560 (at 14:03:22 {WORDS})"]
    bench.host_words = ""
    assert bench.look(100 * S, 2560) == {"code": f"at 14:03:22 {WORDS}"}, "on time again, but it was not then"
    assert bench.look(101 * S, 0) == {}
    assert bench.look(102 * S, 2560) == {}, "this one is not the host's"
    assert len(caplog.records) == 1


def test_a_trouble_on_a_host_that_is_on_time_has_no_words_ever(bench: Bench) -> None:
    assert bench.look(0, 2560) == {}
    bench.host_words = WORDS
    assert bench.look(LATER_NS + 1, 2560) == {}


def test_words_of_another_process_may_come_some_seconds_later(bench: Bench) -> None:
    assert bench.look(0, 2560) == {}
    bench.host_words = WORDS
    assert bench.look(LATER_NS, 2560) == {"code": f"at 14:03:22 {WORDS}"}


def test_a_trouble_that_follows_from_the_first_keeps_its_words(bench: Bench) -> None:
    bench.host_words = WORDS
    bench.look(0, 2560)
    bench.host_words = ""
    assert bench.look(60 * S, 2019) == {"code": f"at 14:03:22 {WORDS}"}


def test_a_device_without_reports_has_no_troubles(bench: Bench) -> None:
    assert Device().troubles() == {}
    assert bench.drive.troubles() == {"code": 0}


def test_the_words_stand_beside_the_value_and_in_the_status(capsys: pytest.CaptureFixture[str]) -> None:
    beside = f"at 14:03:22 {WORDS}"
    _echo({"belt/code": 2560, "belt/speed": 1.5}, {"belt/code": {"unit": "", "host": beside}}, as_json=False)
    assert capsys.readouterr().out == f"belt/code = 2560 ({beside})\nbelt/speed = 1.5\n"
    _echo({"belt/code": 2560, "belt/speed": 1.5}, {"belt/code": {"unit": "", "host": beside}}, as_json=True)
    printed = capsys.readouterr()
    assert json.loads(printed.out) == {"belt/code": 2560, "belt/speed": 1.5}, "values only"
    assert printed.err == f"note: belt/code: {beside}\n"
    assert list(_lateness({"processes": {"io": {}, "belt": {"troubles": {"belt/code": beside}}}})) == [
        f"belt/code reports a fault; {beside}"
    ]


def test_the_facts_of_a_point_have_the_words(bench: Bench) -> None:
    async def facts() -> Mapping[str, Any]:
        clock = RealClock(asyncio.get_running_loop())
        points = RealPoints("belt", bench.drive, clock, lambda: WORDS)
        bench.drive.code = 2560
        found = points.facts()
        clock.close()
        return found

    found = asyncio.run(facts())
    assert found["code"]["host"] == f"at 14:03:22 {WORDS}"
    assert "host" not in found["speed"]


def test_watch_shows_a_trouble_once_more_when_words_come_later_and_not_when_it_is_over() -> None:
    shown, beside = _Shown(["c*"], later_s=10), {"code": {"host": f"at 14:03:22 {WORDS}"}}
    assert not shown.wants_facts(0.0), "nothing has changed"
    assert list(shown.changed({"code": 2560, "speed": 1.5}, {}, 0.0)) == ["code"]
    assert [shown.wants_facts(now_s) for now_s in (0.1, 0.2, 1.2, 10.1)] == [True, False, True, False]
    assert list(shown.changed({"code": 2560, "speed": 2.5}, beside, 1.2)) == ["code"]
    assert list(shown.changed({"code": 2560}, beside, 1.3)) == []
    assert list(shown.changed({"code": 0}, beside, 1.4)) == ["code"]
    assert list(shown.changed({"code": 0}, {}, 2.4)) == []


def test_watch_has_the_words_in_the_line_and_in_json_only_beside_a_trouble() -> None:
    fact = {"unit": "", "host": f"at 14:03:22 {WORDS}"}
    line, data = _of_point("belt/code", 2560, fact)
    assert line.endswith(f"  belt/code = 2560 (at 14:03:22 {WORDS})")
    assert data["host"] == fact["host"]
    line, data = _of_point("belt/code", 0, fact)
    assert line.endswith("  belt/code = 0")
    assert "host" not in data
