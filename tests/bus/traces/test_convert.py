"""`fieldrig trace convert` with waveforms: which buses and wires are taken, and what is said about the others."""

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from fieldrig.cli.trace import app
from fieldrig.errors import UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.signals.codec import encode
from fieldrig_bus.wires import Signal

ENTRIES = [
    TraceEntry(0, "wires", "wires", "plc", encode(Signal("cell.valve", True))),
    TraceEntry(1, "can0", "can", "io", bytes.fromhex("23010000020501")),
    TraceEntry(2, "wires", "wires", "tank", encode(Signal("tank.level", 0.5, "m"))),
    TraceEntry(3, "com1", "serial", "modem", b"\x00AT\r"),
    TraceEntry(4, "wires", "wires", "tank", b"["),
]


@pytest.fixture
def source(tmp_path: Path) -> Path:
    write(ENTRIES, tmp_path / "all.jsonl")
    return tmp_path / "all.jsonl"


def convert(source: Path, target: str, *arguments: str) -> Result:
    return CliRunner().invoke(app, ["convert", str(source), str(source.parent / target), *arguments])


def test_buses_without_waveforms_are_named(source: Path) -> None:
    done = convert(source, "x.vcd")
    assert done.stderr.endswith(
        "x.vcd: 2 messages; 3 are of kinds that this format cannot hold; it has no messages of can0, com1\n"
    )


def test_chosen_buses_are_complete(source: Path) -> None:
    assert convert(source, "x.pcapng", "wires").stderr.endswith("x.pcapng: 3 messages\n")


def test_chosen_wires_are_alone_in_every_format(source: Path) -> None:
    assert convert(source, "x.jsonl", "--wire", "tank.*", "--wire", "tank.level").stderr.endswith(
        "x.jsonl: 1 message\n"
    )
    assert b"tank.level" in bytes.fromhex((source.parent / "x.jsonl").read_text().split('"')[-2])
    assert convert(source, "x.vcd", "wires", "--wire", "*").stderr.endswith("x.vcd: 2 messages\n")


@pytest.mark.parametrize("ending", ["jsonl", "log", "pcapng", "vcd"])
def test_a_conversion_that_fails_leaves_the_target_as_it_was(source: Path, ending: str) -> None:
    source.write_text(source.read_text(encoding="utf-8") + "{}\n", encoding="utf-8")
    for before in (None, b"of yesterday"):
        target = source.parent / f"x.{ending}"
        if before is not None:
            target.write_bytes(before)
        with pytest.raises(UsageError):
            write(read(source), target)
        assert (target.read_bytes() if target.exists() else None) == before
    assert {path.name for path in source.parent.iterdir()} == {"all.jsonl", f"x.{ending}"}


def test_a_target_may_be_a_pipe_or_a_link(source: Path) -> None:
    (source.parent / "there.jsonl").write_bytes(b"old")
    (source.parent / "link.jsonl").symlink_to("there.jsonl")
    assert convert(source, "link.jsonl").exit_code == 0
    assert (source.parent / "link.jsonl").is_symlink()
    assert (source.parent / "there.jsonl").read_text() == source.read_text(encoding="utf-8")


def test_a_damaged_trace_is_refused_as_by_show(source: Path) -> None:
    source.write_text(source.read_text(encoding="utf-8") + "{}\n", encoding="utf-8")
    shown = CliRunner().invoke(app, ["show", str(source)])
    done = convert(source, "x.vcd")
    assert isinstance(done.exception, UsageError)
    assert str(done.exception) == str(shown.exception)
    assert "line 6 is not a message of a trace" in str(done.exception)
