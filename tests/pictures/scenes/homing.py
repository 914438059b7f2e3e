"""Homing of a CiA 402 axis of a MAx-4: its velocity, the home switch, and the status word that the master reads."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final, NamedTuple

from tests.pictures.recording import recorded
from tests.pictures.timing import LEFT, Lane, draw_timing, spans

from fieldrig.clock import MS
from fieldrig.link import Link
from fieldrig.text.svg import Drawing
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame

NODE: Final = 10
RIG: Final[Mapping[str, Any]] = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}},
    "devices": {
        "max4": {
            "kind": "max4",
            "links": {"can": "can0"},
            "drives": {"belt": {"ring_address": 1, "simulated": True}},
            "inputs": {"home": ""},
            "can_axes": {"node_ids": [NODE], "terminals": {"belt": {"home": "home"}}},
        }
    },
}
START_ALL_NODES: Final = CanFrame(0x000, bytes.fromhex("01 00"))
FAST: Final = 1_000_000
SLOW: Final = 200_000
"""Speeds of the search for the switch and for its edge, in increments per second."""
SWITCH: Final = 150_000
"""The home switch is on beyond this position, in increments."""
WRITES: Final = (
    ("2f 60 60 00", 6),  # mode: homing
    ("2f 98 60 00", 19),  # method 19: positive direction, falling edge of the home switch
    ("23 99 60 01", FAST),
    ("23 99 60 02", SLOW),
    ("23 9a 60 00", 10_000_000),  # acceleration
    ("2b 40 60 00", 0x06),  # shutdown
    ("2b 40 60 00", 0x07),  # switch on
    ("2b 40 60 00", 0x0F),  # enable operation
)
START: Final = ("2b 40 60 00", 0x1F)
STATUS_WORD: Final = 0x180 + NODE
HOMING_ATTAINED: Final = 12
"""Bit of the status word."""
HALF: Final = 50
AXIS: Final = 80


class Sample(NamedTuple):
    time_ns: int
    velocity: float
    is_on_switch: bool
    status: int


def homing() -> str:
    found: list[Sample] = []
    recorded(RIG, lambda rig: found.extend(_homed(rig)))
    first = found[0].time_ns
    end = found[-1].time_ns
    about = "The axis moves onto the home switch, stops, moves back slowly, and attains its home at the switch's edge."
    drawing = Drawing(880, "Homing by method 19", about)
    right = drawing.width - 30
    points = [
        (LEFT + (right - LEFT) * (sample.time_ns - first) / (end - first), AXIS - HALF * sample.velocity / FAST)
        for sample in found
    ]
    drawing.text(20, AXIS + 5, "velocity", "name")
    drawing.line("grid", [(LEFT, AXIS), (right, AXIS)])
    drawing.line("curve", points)
    switch = [(sample.time_ns, "on" if sample.is_on_switch else "") for sample in found]
    lanes = [Lane("home switch", spans(switch), "bit 2 of 60FDh")]
    for bit, meaning in ((10, "target reached"), (HOMING_ATTAINED, "homing attained")):
        shown = [(sample.time_ns, meaning if sample.status >> bit & 1 else "") for sample in found]
        lanes.append(Lane("status word", spans(shown), f"bit {bit}"))
    return drawing.render(draw_timing(drawing, lanes, first, end, top=AXIS + HALF + 20))


def _homed(rig: Rig) -> Iterator[Sample]:
    """A sample in every millisecond from the start of homing to 100 ms after its end."""
    status = [0]
    link: Link[CanFrame] = rig.attach("master").link("can0")
    link.on_receive(lambda frame: _note(frame, status))
    while not rig.get("max4", "booted"):
        rig.run_until(rig.now_ns + MS)
    link.send(START_ALL_NODES)
    for write in WRITES:
        _write(link, *write)
        rig.run_until(rig.now_ns + 200 * MS)
    _write(link, *START)
    left = 100
    while left:
        rig.run_until(rig.now_ns + MS)
        is_on = float(rig.get("max4", "belt.Position")) > SWITCH
        rig.set("max4", "home.Value", is_on)
        yield Sample(rig.now_ns, float(rig.get("max4", "belt.Velocity")), is_on, status[0])
        left -= status[0] >> HOMING_ATTAINED & 1


def _note(frame: CanFrame, status: list[int]) -> None:
    if frame.identifier == STATUS_WORD:
        status[0] = int.from_bytes(frame.data[:2], "little")


def _write(link: Link[CanFrame], head: str, value: int) -> None:
    """An expedited SDO download; `head` is its command byte, index and sub-index."""
    link.send(CanFrame(0x600 + NODE, bytes.fromhex(head) + value.to_bytes(4, "little")))


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"cia402-homing": homing}
