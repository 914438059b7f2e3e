"""Serial lines: one end is played, and waits for the bytes of the other."""

import pytest
from recorded_logs import MS

from fieldrig import Rig, RigConfig, from_dict
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.replay import ReplayResult, replay

SCALE = "replay_kinds:Scale"


@pytest.fixture
def scale(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> RigConfig:
    monkeypatch.syspath_prepend(str(request.path.parent))
    return from_dict(
        {
            "time": "virtual",
            "buses": {"com": {"kind": "serial.virtual", "baud": 9600}},
            "devices": {"scale": {"kind": SCALE, "links": {"line": "com"}}},
        }
    )


def said(time_ms: float, sender: str, data: str) -> TraceEntry:
    return TraceEntry(round(time_ms * MS), "com", "serial", sender, b"\x00" + data.encode())


def conversation(answer: str = "12.5 kg\r", delay_ms: float = 38) -> list[TraceEntry]:
    """Three questions, each asked 5 ms after the answer to the one before."""
    log, at = [], 100.0
    for question in ("W?\r", "W?\r", "Z\r"):
        log.append(said(at, "pc", question))
        at += delay_ms
        log.append(said(at, "scale", answer if question == "W?\r" else "ERR\r"))
        at += 5
    return log


def words(result: ReplayResult) -> list[str]:
    return [each.words for each in result.differences]


def test_a_conversation_is_played_and_its_answers_are_compared(scale: RigConfig) -> None:
    result = replay(conversation(), scale)
    assert (words(result), result.played) == ([], 3)


def test_another_answer_is_named(scale: RigConfig) -> None:
    [first, *_] = words(replay(conversation("12.6 kg\r"), scale))
    assert first.startswith("com sent bytes with data 31 32 2E 35 20 6B 67 0D, the log says 31 32 2E 36 20 6B 67 0D")


def test_a_question_waits_for_the_answer_to_the_one_before(scale: RigConfig) -> None:
    """The log is of a scale that answers after 3 ms."""
    heard: list[str] = []
    with Rig(scale) as rig:
        rig.on_delivery(lambda bus, sent: heard.append(sent.sender))
        result = replay(conversation(delay_ms=3), rig)
    order = [sender for place, sender in enumerate(heard) if place == 0 or heard[place - 1] != sender]
    assert order == ["pc", "scale"] * 3
    assert result.shift_ns > 3 * 30 * MS


def test_a_scale_without_power_costs_its_time_out_and_is_named(scale: RigConfig) -> None:
    with Rig(scale) as rig:
        rig.add_fault("scale", {"what": "power_off"})
        result = replay(conversation(), rig, timeout_ns=200 * MS)
    assert words(result) == ["com did not send bytes data 31 32 2E 35 20 6B 67 0D (3 of them in a row)"]
    assert result.shift_ns >= 2 * 200 * MS


def test_the_device_can_be_played_instead(scale: RigConfig) -> None:
    """Nothing asks then, and the log speaks for the scale."""
    result = replay(conversation(), scale, play=["scale"])
    assert (result.played, words(result)) == (3, [])
