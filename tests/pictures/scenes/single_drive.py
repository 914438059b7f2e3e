"""A move of a single CiA 402 drive: position, velocity, torque and state, as a master reads them at each SYNC."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

from tests.pictures.recording import recorded
from tests.pictures.timing import LEFT, Lane, draw_timing, spans

from fieldrig.clock import MS
from fieldrig.link import Link
from fieldrig.text.svg import Drawing
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame

NODE: Final = 3
RIG: Final[Mapping[str, Any]] = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}},
    "devices": {
        "axis": {
            "kind": "cia402.drive",
            "node_id": NODE,
            "links": {"can": "can0"},
            "motor": {"brake_torque_nm": 2.0},
            "load": {"inertia_kg_m2": 0.0005, "coulomb_nm": 0.05},
        }
    },
}
TURNS: Final = 4
START_NODE: Final = CanFrame(0x000, bytes((1, NODE)))
SYNC: Final = CanFrame(0x080, b"")
WRITES: Final = (
    ("2f 60 60 00", 1),  # mode: profile position
    ("23 00 18 01", 0x8000_0180 + NODE),  # TPDO 1 becomes status word and torque, with each SYNC
    ("2f 00 1a 00", 0),
    ("23 00 1a 01", 0x6041_0010),
    ("23 00 1a 02", 0x6077_0010),
    ("2f 00 1a 00", 2),
    ("2f 00 18 02", 1),
    ("23 00 18 01", 0x180 + NODE),
    ("23 81 60 00", 16_000_000),  # 16 turns per second
    ("23 83 60 00", 150_000_000),
    ("23 84 60 00", 100_000_000),
    ("2b 68 60 00", 20),  # position window time
    ("23 7a 60 00", TURNS * 1_000_000),
)
WORDS: Final = ((20, 0x06), (40, 0x07), (60, 0x0F), (160, 0x1F), (260, 0x0F), (620, 0x07), (660, 0x06))
"""Control words by the millisecond at which they are sent: enable, new set-point, then off again."""
END_MS: Final = 720
STATES: Final = {0x40: "disabled", 0x21: "ready", 0x23: "switched on", 0x27: "operation enabled"}
"""States by the bits 0 to 3, 5 and 6 of the status word."""
HEIGHT: Final = 90
GAP: Final = 24


class Sample(NamedTuple):
    """The values of one SYNC: turns, turns per second, percent of the rated torque, and the status word."""

    time_ns: int
    position: float
    velocity: float
    torque: float
    status: int


def move() -> str:
    found: list[Sample] = []
    recorded(RIG, lambda rig: found.extend(_moved(rig)))
    about = (
        "The brake lifts, the drive accelerates, keeps its speed, brakes, and holds its position until it is disabled."
    )
    drawing = Drawing(880, "A move of a CiA 402 drive", about)
    top = 20.0
    for name, unit, values in (
        ("position", "turns", [sample.position for sample in found]),
        ("velocity", "turns/s", [sample.velocity for sample in found]),
        ("torque", "% of rated", [sample.torque for sample in found]),
    ):
        top = _curve(drawing, name, unit, values, top)
    states = [(sample.time_ns, STATES.get(sample.status & 0x6F, "")) for sample in found]
    lanes = [Lane("state", spans(states), "6041h")]
    for bit, meaning in ((12, "set-point taken"), (10, "target reached")):
        shown = [(sample.time_ns, meaning if sample.status >> bit & 1 else "") for sample in found]
        lanes.append(Lane("status word", spans(shown), f"bit {bit}"))
    return drawing.render(draw_timing(drawing, lanes, found[0].time_ns, found[-1].time_ns, top=top))


def _curve(drawing: Drawing, name: str, unit: str, values: Sequence[float], top: float) -> float:
    """Draw a curve over the whole width and return where the next one begins."""
    low, high = min(*values, 0.0), max(*values, 0.0)
    right = drawing.width - 30
    step = (right - LEFT) / (len(values) - 1)

    def y(value: float) -> float:
        return top + HEIGHT * (high - value) / (high - low)

    drawing.text(20, top + HEIGHT / 2, name, "name")
    drawing.text(20, top + HEIGHT / 2 + 16, unit, "tiny")
    for value in sorted({0.0, *(end for end in (low, high) if abs(end) > (high - low) / 10)}):
        drawing.line("grid", [(LEFT, y(value)), (right, y(value))])
        drawing.text(LEFT - 6, y(value) + 4, f"{value:.0f}", "tiny", "end")
    drawing.line("curve", [(LEFT + step * place, y(value)) for place, value in enumerate(values)])
    return top + HEIGHT + GAP


def _moved(rig: Rig) -> Iterator[Sample]:
    """A sample in every millisecond, from the enabling to the end."""
    link: Link[CanFrame] = rig.attach("master").link("can0")
    heard: dict[int, bytes] = {}
    link.on_receive(lambda frame: heard.__setitem__(frame.identifier, frame.data))
    rig.run_until(rig.now_ns + 100 * MS)
    for write in WRITES:
        _write(link, *write)
        rig.run_until(rig.now_ns + 2 * MS)
    link.send(START_NODE)
    rig.run_until((rig.now_ns // MS + 10) * MS)
    words = dict(WORDS)
    for passed in range(END_MS):
        if passed in words:
            _write(link, "2b 40 60 00", words[passed])
        link.send(SYNC)
        rig.run_until(rig.now_ns + MS)
        status, torque = heard[0x180 + NODE][:2], heard[0x180 + NODE][2:4]
        position, velocity = heard[0x380 + NODE][2:6], heard[0x480 + NODE][2:6]
        yield Sample(
            rig.now_ns,
            _number(position) / 1e6,
            _number(velocity) / 1e6,
            _number(torque) / 10,
            _number(status),
        )


def _number(data: bytes) -> int:
    return int.from_bytes(data, "little", signed=True)


def _write(link: Link[CanFrame], head: str, value: int) -> None:
    """An expedited SDO download; `head` is its command byte, index and sub-index."""
    link.send(CanFrame(0x600 + NODE, bytes.fromhex(head) + value.to_bytes(4, "little")))


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"cia402-move": move}
