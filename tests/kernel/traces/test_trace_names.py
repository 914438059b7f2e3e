"""`fieldrig trace show --rig`: a trace by the names that a rig file has, without a rig that runs."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fieldrig.cli.app import app

CONFIGS = Path(__file__).parents[3] / "configs"
LOG = """\
(1795000000.000000) can0 605#4000620100000000
(1795000000.001000) can0 585#4F00620103000000
(1795000000.002000) other 705#05
"""


def test_a_foreign_log_is_shown_by_the_names_of_a_rig(tmp_path: Path) -> None:
    log = tmp_path / "candump.log"
    log.write_text(LOG)
    done = CliRunner().invoke(app, ["trace", "show", str(log), "--rig", str(CONFIGS / "lab.yaml")])
    read, other = done.stdout.splitlines()
    assert read.endswith("SDO read io 6200:01 Write outputs byte 1 = 3, in 1 ms")
    assert other.endswith("heartbeat io operational")
    assert done.stderr.endswith("line 3: another interface begins, other; the lines before are of can0\n")


@pytest.mark.long
def test_a_stream_of_bytes_is_read_for_each_sender(tmp_path: Path) -> None:
    """A command that comes in two parts, with the modem's echo between them, is one command."""
    sent = (("pc", "00415444"), ("office", "0041"), ("pc", "0032300d"), ("office", "00544432300d"))
    lines = [
        {"time_ns": number, "bus": "office_com", "family": "serial", "sender": sender, "data": data}
        for number, (sender, data) in enumerate(sent)
    ]
    trace = tmp_path / "line.jsonl"
    trace.write_text("".join(json.dumps(line) + "\n" for line in lines))
    done = CliRunner().invoke(app, ["trace", "show", str(trace), "--rig", str(CONFIGS / "modems.yaml")])
    assert [line.split("  ")[-1].strip() for line in done.output.splitlines()[2:]] == [
        "AT command office ATD20",
        "AT echo office ATD20",
    ]


@pytest.mark.long
def test_the_frames_of_an_axis_card_have_its_objects(tmp_path: Path) -> None:
    """TPDO 2 of the card is 280h + 11: the positions of both axes, 32 bits each (docs/devices/arp/arp-can.md)."""
    log = tmp_path / "film.log"
    log.write_text("(1795000000.000000) can0 28B#4CA40000ACB00200\n")
    done = CliRunner().invoke(app, ["trace", "show", str(log), "--rig", str(CONFIGS / "arp-cell.yaml")])
    assert "TPDO 2 line" in done.output, done.output
    assert "42060" in done.output  # 0000A44Ch
    assert "176300" in done.output  # 0002B0ACh
