"""A card that runs a program, and its terminal, in one rig."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig

PROGRAM = """
BEG MAIN
TERM
MSG 1, "LENGTH ####.#"
MSG 2, "LOOPS"
TERM 1, 1, 1, 1, V1, E
L1:
IF F245 = HI, SET F219
IF F246 = HI, RES F219
IF V1 > 100, PRINT 1, V1
IF V1 > 100, V1 == 0
GOTO L1
END
"""


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    (tmp_path / "panel.I01").write_text(PROGRAM)
    card = {"kind": "arp", "program": "panel.I01", "inputs": {"I108": True}, "links": {"can": "can0"}}
    config = {
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": 500_000}},
        "devices": {
            "card": {**card, "terminal": True, "parameters": {"general": {8: 33}}},
            "panel": {"kind": "terminal.tr", "node_id": 33, "links": {"can": "can0"}},
        },
    }
    with Rig(from_dict(config, tmp_path)) as rig:
        rig.run_until(1 * S)
        yield rig


def press(rig: Rig, keys: str) -> None:
    rig.set("panel", "press", keys)
    rig.run_until(rig.now_ns + 150 * MS * len(keys.split()) + 100 * MS)


@pytest.mark.manual("ARP-013", "ARP-064", "ARP-114", "ARP-115", "ARP-116", "ARP-119")
def test_program_and_operator_meet_at_the_terminal(rig: Rig) -> None:
    assert rig.get("panel", "screen.1") == "LENGTH    0.0   "
    press(rig, "1 2 POINT 5 CR")
    assert (rig.get("card", "V1"), rig.get("panel", "screen.1")) == (12.5, "LENGTH   12.5   ")
    press(rig, "F1")
    assert rig.get("panel", "led.F12") is True
    press(rig, "F2")
    assert rig.get("panel", "led.F12") is False
    press(rig, "2 5 0 CR")
    assert rig.get("panel", "printer") == "LENGTH  250.0"
    assert (rig.get("card", "V1"), rig.get("panel", "screen.1")) == (0, "LENGTH    0.0   ")
    assert rig.get("card", "error") == 0
