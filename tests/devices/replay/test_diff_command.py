"""`fieldrig diff`: exit codes, words, JSON, and files that are no logs."""

import json
from pathlib import Path

import pytest
from recorded_logs import frame
from typer.testing import CliRunner, Result

from fieldrig.cli.app import app
from fieldrig.errors import UsageError
from fieldrig.traces import trace_files

LOG = [frame(10 * number, 0x181, f"{number:02X}") for number in range(20)]


@pytest.fixture
def a(tmp_path: Path) -> Path:
    trace_files.write(LOG, tmp_path / "a.jsonl")
    return tmp_path / "a.jsonl"


def other(a: Path) -> Path:
    """A log without the frame at 0.13 s, in another format."""
    path = a.with_name("b.log")
    trace_files.write([*LOG[:13], *LOG[14:]], path)
    return path


def run(*words: str | Path) -> Result:
    return CliRunner().invoke(app, ["diff", *map(str, words)])


def test_the_exit_code_is_0_without_a_difference(a: Path) -> None:
    done = run(a, a)
    assert (done.exit_code, done.stdout) == (0, "no difference in 20 messages of 1 stream\n")


def test_the_exit_code_is_1_with_one_and_the_first_is_told(a: Path) -> None:
    done = run(a, other(a))
    assert done.exit_code == 1
    assert done.stdout.startswith("first difference at 0.130000 s: can0 181 TPDO 1 node 1: missing in the second log\n")
    assert "\n  > 0.130000 s  can0      TPDO 1 node 1 0D\n" in done.stdout


def test_json_has_every_stream(a: Path) -> None:
    found = json.loads(run(a, other(a), "--json").stdout)
    assert (found["same"], found["first"]["what"]) == (False, "missing in the second log")
    [stream] = found["streams"]
    assert (stream["stream"], stream["left"], stream["right"], stream["missing"]) == ("181", 20, 19, 1)


def test_a_part_of_the_time_is_compared(a: Path) -> None:
    assert run(a, other(a), "--for", "100ms").exit_code == 0
    assert run(a, other(a), "--from", "100ms").exit_code == 1


@pytest.mark.parametrize(
    ("option", "why"),
    [
        (("--from", "10s"), "they are empty, or --from, --for and --leave-out leave nothing of them"),
        (("--leave-out", "181"), "they are empty, or --from, --for and --leave-out leave nothing of them"),
        (("--from", "10s", "--leave-out", "705"), "705"),
    ],
)
def test_two_logs_of_nothing_are_not_equal(a: Path, option: tuple[str, ...], why: str) -> None:
    done = run(a, other(a), *option)
    assert isinstance(done.exception, UsageError)
    assert done.exception.what == "neither log has a message to compare"
    assert why in str(done.exception)


def test_a_log_of_nothing_differs_from_one_with_messages(a: Path) -> None:
    empty = a.with_name("empty.log")
    empty.write_bytes(b"")
    assert run(a, empty).exit_code == run(empty, a).exit_code == 1


@pytest.mark.parametrize("option", [("--tolerance", "much"), ("--offset", "soon"), ("--for", "5")])
def test_a_wrong_duration_is_wrong_usage(a: Path, option: tuple[str, str]) -> None:
    assert run(a, a, *option).exit_code == 2


def test_an_offset_may_be_negative(a: Path) -> None:
    assert run(a, a, "--offset", "-2s").exit_code == 1


def test_a_file_that_is_no_log_is_named(a: Path) -> None:
    wrong = a.with_name("wrong.log")
    wrong.write_bytes(b"\x00\x01\x02 no log\n")
    done = run(a, wrong)
    assert isinstance(done.exception, UsageError)
    assert "wrong.log" in done.exception.what
