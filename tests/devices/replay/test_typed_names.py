"""Names that a user types for a log: each that names nothing is answered with the nearest one."""

from pathlib import Path

import pytest
from recorded_logs import frame
from typer.testing import CliRunner

from fieldrig import load
from fieldrig.cli.app import app
from fieldrig.errors import UsageError
from fieldrig.traces import trace_files
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.replay import ReplayResult, replay

pytestmark = pytest.mark.long

LAB = Path(__file__).parents[3] / "configs" / "lab.yaml"
LOG = [frame(0, 0x705, "00"), frame(10, 0x605, "40 00 10 00 00 00 00 00"), frame(11, 0x585, "43 00 10 00 92 01 03 00")]
OTHER = TraceEntry(12_000_000, "can0", "can", "plc", frame(12, 0x606, "40 00 10 00 00 00 00 00").data)


def played(**words: object) -> ReplayResult:
    return replay([*LOG, OTHER], load(LAB, ("time=virtual",)), **words)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("word", "nearest"),
    [
        ("node=7", "did you mean node=5?"),
        ("id=615", "did you mean id=605?"),
        ("unit=3", "there are: id=585, id=605, id=606, id=705, node=5, sender=plc"),
        ("sender=pcl", "did you mean sender=plc?"),
        ("client=10.0.0.7", "there are"),
    ],
)
def test_a_side_that_the_log_does_not_have(word: str, nearest: str) -> None:
    with pytest.raises(UsageError) as wrong:
        played(play=["master", word])
    assert f"--play {word}: the log has no such messages" in str(wrong.value)
    assert nearest in str(wrong.value)


@pytest.mark.parametrize("word", ["node=5", "id=605", "id=0605h", "sender=plc", "sender=p*"])
def test_a_side_that_the_log_has(word: str) -> None:
    assert played(play=["master", word]).played


def test_a_bus_that_the_log_does_not_have() -> None:
    with pytest.raises(UsageError, match=r"the log has no bus 'canO'\n?.*did you mean can0\?"):
        played(buses={"canO": "can0"})
    assert played(buses={"can0": "can0"}).played


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ({"value_tolerances": {"device_typ": 1}}, "--value-tolerance device_typ names nothing that was compared"),
        ({"leave_out": ["hartbeat"]}, "--leave-out hartbeat names nothing that was compared"),
    ],
)
def test_a_value_that_was_not_compared_is_a_note(words: dict[str, object], sentence: str) -> None:
    (note,) = [note for note in played(**words).notes if note.startswith("--")]
    assert note.startswith(sentence)


@pytest.mark.parametrize(
    "words", [{"value_tolerances": {"1000h": 1.0}}, {"leave_out": ["1000*"]}, {"leave_out": ["heartbeat"]}]
)
def test_a_value_that_was_compared_is_none(words: dict[str, object]) -> None:
    assert not [note for note in played(**words).notes if note.startswith("--")]


@pytest.mark.parametrize(
    ("word", "note"),
    [
        ("canO/705", "did you mean can0/705?"),
        ("7O5", "did you mean 705?"),
        ("unit 3*", "there are: 705, can0/705, 605, can0/605, 585, can0/585"),
        ("0x705", ""),
        ("can0/7*", ""),
    ],
)
def test_a_stream_that_neither_log_has_is_a_note(tmp_path: Path, word: str, note: str) -> None:
    trace_files.write(LOG, tmp_path / "a.jsonl")
    done = CliRunner().invoke(app, ["diff", str(tmp_path / "a.jsonl"), str(tmp_path / "a.jsonl"), "--leave-out", word])
    assert done.exit_code == 0
    notes = [line for line in done.stdout.splitlines() if line.startswith("note: --")]
    assert notes == ([f"note: --leave-out {word}: the logs have no such stream; {note}"] if note else [])
