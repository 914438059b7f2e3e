"""The wiring of rig files, and the lab with its traffic."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from tests.pictures.chart import chart
from tests.pictures.parts import overview
from tests.pictures.recording import ROOT, Sent, block_named, frame_bar, recorded
from tests.pictures.timing import Bar, Lane, draw_timing
from tests.pictures.wiring import Part, draw_wiring, wiring

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.text.svg import Drawing
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_bus.wires import Signal
from fieldrig_page.drawing import draw_rig
from fieldrig_page.graph import graph_of

PACED: Final = "buses.mb_rtu.kind=modbus.virtual"
"""In real time the line itself takes its time, and the bus adds none; this kind takes the time of a line."""
START_ALL_NODES: Final = CanFrame(0x000, bytes.fromhex("01 00"))
READ_LEVEL: Final = CanFrame(0x605, bytes.fromhex("40 01 64 01 00 00 00 00"))
PUMP_TO_80_PERCENT: Final = ModbusRequest(1, bytes.fromhex("06 0000 0320"), 1)
PUMP_ON: Final = ModbusRequest(1, bytes.fromhex("05 0000 ff00"), 2)
BITRATE: Final = 250_000
CHARACTER_NS: Final = 11 * S // 19_200
FRAME_CHARACTERS: Final = 3
"""Address and CRC of a Modbus RTU frame."""
WINDOW: Final = (1_500 * MS, 1_534 * MS)
MEANINGS: Final = {
    0x000: "start all nodes",
    0x185: "digital inputs",
    0x285: "analog inputs",
    0x186: "level of sensor",
    0x605: "read level",
    0x585: "level of io",
}
"""The content of each frame of the window, by identifier."""


def lab_with_traffic() -> str:
    """The wiring of the lab above 34 ms of its traffic."""
    lab = Part.of(load(ROOT / "configs" / "lab.yaml"))
    about = (
        "Four devices are linked to a CAN bus, two Modbus buses and wires. Below, frames of two masters and the "
        "answers of the devices on a time axis."
    )
    drawing = Drawing(max(880, lab.width), "The lab and 34 ms of its traffic", about)
    end = draw_wiring(drawing, lab)
    return drawing.render(draw_timing(drawing, lanes_of(recorded("lab.yaml", play, PACED)), *WINDOW, top=end))


def play(rig: Rig) -> None:
    """Two masters: one reads the level by SDO, the other sets the pump's speed and starts it."""
    master = rig.attach("master")
    can, line = master.link("can0"), master.link("mb_rtu")
    line.on_receive(lambda message: None, ())
    rig.run_until(WINDOW[0])
    line.send(PUMP_TO_80_PERCENT)
    rig.run_until(WINDOW[0] + 2 * MS)
    can.send(START_ALL_NODES)
    rig.run_until(WINDOW[0] + 13 * MS)
    can.send(READ_LEVEL)
    rig.run_until(WINDOW[0] + 17 * MS)
    line.send(PUMP_ON)
    rig.run_until(WINDOW[1])


def lanes_of(sent: list[Sent]) -> list[Lane]:
    inside = [message for message in sent if WINDOW[0] < message.time_ns <= WINDOW[1]]
    frames = [
        frame_bar(message, BITRATE, label_of(message.message), "outside" if message.sender == "master" else "bus")
        for message in inside
        if message.bus == "can0" and isinstance(message.message, CanFrame)
    ]
    requests = [
        Bar(
            message.time_ns - CHARACTER_NS * (FRAME_CHARACTERS + len(message.message.pdu)),
            message.time_ns,
            message.message.pdu.hex(" "),
            "outside" if isinstance(message.message, ModbusRequest) else "bus",
        )
        for message in inside
        if message.bus == "mb_rtu"
    ]
    signals = [
        Bar(message.time_ns, message.time_ns, message.shown, "wires")
        for message in inside
        if isinstance(message.message, Signal)
    ]
    return [
        Lane("can0", frames, "250 kbit/s"),
        Lane("mb_rtu", requests, "19200 baud"),
        Lane("wires", signals, "signals"),
    ]


def label_of(frame: CanFrame) -> str:
    return f"{frame.identifier:03X} {MEANINGS[frame.identifier]}"


def tank_level() -> str:
    """Fifteen minutes of the tank: the pump runs for 330 s, then the outlet opens."""
    curve: list[tuple[float, float]] = []

    def play(rig: Rig) -> None:
        rig.set("drive", "speed_set", 100)
        rig.set("drive", "run", True)
        for second in range(0, 901, 10):
            rig.run_until(second * S)
            if second == 330:
                rig.set("drive", "run", False)
                rig.set("io", "6411:01", 10_000)
            curve.append((second, float(rig.get("tank", "level"))))

    recorded("lab.yaml", play)
    about = "The level rises from 0.5 m to 1.8 m in 330 s, and falls when the pump stops and the outlet valve opens."
    return chart({"tank/level": curve}, 2.0, "s", "m", "Fifteen minutes of the tank, in virtual time", about)


def bench() -> str:
    """The wiring of the first rig file on the page about rig files."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "bench.yaml"
        file.write_text(block_named("rig-file.md", "bench.yaml").text, encoding="utf-8")
        (Path(folder) / "eds").symlink_to(ROOT / "configs" / "eds")
        return wiring(file, "The wiring of bench.yaml", "A CANopen node on a CAN bus and a tank, joined by wires.")


def rig(name: str, about: str) -> Callable[[], str]:
    return partial(wiring, ROOT / "configs" / f"{name}.yaml", f"The wiring of {name}.yaml", about)


MACHINE: Final = ROOT / "configs" / "machine.yaml"
PARTS_OF_MACHINE: Final = {
    "lab.yaml": "glue",
    "arp-cell.yaml": "film",
    "teleservice.yaml": "wrapper",
    "feeder.yaml": "labels",
    "pam-machine.yaml": "labeller",
}


def machine() -> str:
    about = "Five parts, each with its buses and devices: glue, film, wrapper, labels and labeller. Wires join them."
    return overview(MACHINE, PARTS_OF_MACHINE, "The machine: its parts, buses and devices", about)


def machine_page() -> str:
    """The machine as its page shows it."""
    return draw_rig(graph_of(load(MACHINE)))


PICTURES: Final[Mapping[str, Callable[[], str]]] = {
    "lab-traffic": lab_with_traffic,
    "tank-level": tank_level,
    "bench-rig": bench,
    "ring-rig": rig("ring", "A controller, four drives, a motor encoder and a panel on a ring, CAN, Modbus and wires."),
    "machine-parts": machine,
    "machine-page": machine_page,
    "arp-cell-rig": rig("arp-cell", "Two cards, their nodes, a terminal and a winder on CAN, serial lines and wires."),
    "own-device-rig": rig("own-device", "A press on a CAN bus and on wires."),
}
