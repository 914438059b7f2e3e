"""ARP cards at work: the screen of the terminal in a cell, and two cards that exchange data."""

from collections.abc import Callable, Mapping
from typing import Any, Final

from tests.pictures.recording import frame_bar, recorded
from tests.pictures.timing import Lane, spans, timing

from fieldrig.clock import MS, S
from fieldrig.text.svg import Drawing
from fieldrig.virtual.rig import Rig

WIDTH: Final = 16
HEIGHT: Final = 22
"""Size of a cell; a terminal's own is square."""
TOP: Final = 40
LEFT: Final = 40
COLUMNS: Final = 16
LEDS: Final = ("F7", "F8", "F9", "F10", "F11", "F12")
BITRATE: Final = 500_000
WINDOW: Final = (S, S + 100 * MS)
FRAMES: Final = {0x24B: "24Bh channel 1", 0x28B: "28Bh TPDO 2"}
TWO_CARDS: Final[Mapping[str, Any]] = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual", "bitrate": BITRATE}},
    "devices": {
        "winder": {
            "kind": "arp",
            "parameters": {"general": {5: 11}},
            "inputs": {"I108": True},
            "exchange": {"send": [{"channel": 1, "words": ["POS2", "FLAG2"]}]},
            "links": {"can": "can0"},
        },
        "unwinder": {
            "kind": "arp",
            "parameters": {"general": {5: 12}},
            "inputs": {"I108": True},
            "exchange": {"receive": [{"node": 11, "channel": 1, "words": ["V500", "FLAG2"]}]},
            "links": {"can": "can0"},
        },
    },
}
"""The rig of docs/devices/arp/arp-can.md in virtual time."""


def terminal_screen() -> str:
    """The eight lines of the TR4, and its LEDs, eight seconds after the start of the cell."""
    found: dict[str, str] = {}

    def play(rig: Rig) -> None:
        rig.set("panel", "6200:01", 1)
        rig.run_until(S)
        rig.set("line", "F33", True)
        rig.run_until(8 * S)
        found.update({key: str(rig.get("terminal", key)) for key in ("screen", *(f"led.{name}" for name in LEDS))})

    recorded("arp-cell.yaml", play)
    lines = found["screen"].split("\n")
    about = "Eight lines of sixteen characters: a title, tension, set point, number of sheets and stage of the cell."
    width = 2 * LEFT + WIDTH * COLUMNS
    drawing = Drawing(width, "Terminal of the ARP cell while the film runs", about)
    drawing.rect("outside", LEFT - 12, TOP - 12, WIDTH * COLUMNS + 24, HEIGHT * len(lines) + 24, radius=8)
    for row, line in enumerate(lines):
        for column, character in enumerate(line):
            if character != " ":
                x, y = LEFT + WIDTH * (column + 0.5), TOP + HEIGHT * (row + 0.75)
                drawing.text(x, y, character, "mono", "middle")
    bottom = TOP + HEIGHT * len(lines) + 40
    for place, name in enumerate(LEDS):
        x = LEFT + 44 * place
        drawing.rect("wires" if found[f"led.{name}"] == "True" else "device", x, bottom - 12, 14, 14, radius=7)
        drawing.text(x + 17, bottom, name, "tiny")
    return drawing.render(bottom + 30)


def exchange() -> str:
    """A position of one card, the frames that carry it, and the variable of the other card that follows it."""
    positions: list[tuple[int, str]] = []
    received: list[tuple[int, str]] = []

    def play(rig: Rig) -> None:
        rig.run_until(WINDOW[0])
        for step in range((WINDOW[1] - WINDOW[0]) // MS):
            rig.set("winder", "encoder2", 100 * (step // 25))
            rig.run_until(rig.now_ns + MS)
            positions.append((rig.now_ns, str(rig.get("winder", "axis2.position"))))
            received.append((rig.now_ns, str(rig.get("unwinder", "V500"))))

    sent = [message for message in recorded(TWO_CARDS, play) if message.time_ns > WINDOW[0]]
    frames = [frame_bar(message, BITRATE, FRAMES[message.message.identifier]) for message in sent]
    lanes = [
        Lane("winder", spans(positions), "position of axis 2"),
        Lane("can0", frames, "500 kbit/s"),
        Lane("unwinder", spans(received), "V500"),
    ]
    about = "Each change of the winder's position is sent in one frame, and the unwinder's variable follows."
    return timing(lanes, *WINDOW, "Exchange between two ARP cards", about)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"arp-exchange": exchange, "arp-terminal": terminal_screen}
