"""Events on a bus in exact time: arbitration, an error with its retransmission, a cycle of the ring."""

from collections.abc import Callable, Mapping
from typing import Any, Final

from tests.pictures.recording import Sent, frame_bar, recorded
from tests.pictures.timing import Bar, Lane, timing

from fieldrig.clock import MS, S
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import CanError
from fieldrig_bus.ring.sercos.message import Answers, Cycle
from fieldrig_bus.ring.sercos.timing import GAP_NS, MST_BYTES, answers_ns, telegram_ns

BITRATE: Final = 250_000
MBAUD: Final = 4
CAN: Final = {"kind": "can.virtual", "bitrate": BITRATE}
MEMBERS: Final = ("node 5", "node 6", "node 7")


def bus_alone(play: Callable[[Rig], None], **settings: Any) -> list[Sent]:
    """The messages on a CAN bus without devices while `play` sends on it."""
    return recorded({"time": "virtual", "buses": {"can0": {**CAN, **settings}}, "devices": {}}, play)


def arbitration() -> str:
    """Three members start at the same instant; the lowest identifier wins each time."""

    def play(rig: Rig) -> None:
        links = {name: rig.attach(name).link("can0") for name in MEMBERS}
        for name, identifier in zip(MEMBERS, (0x285, 0x186, 0x707), strict=True):
            links[name].send(CanFrame(identifier, bytes(4)))
        rig.run_until(3 * MS)

    sent = bus_alone(play)
    lanes = [
        Lane(name, [frame_bar(message, BITRATE) for message in sent if message.sender == name]) for name in MEMBERS
    ]
    about = "Three frames that were requested at the same time follow each other in the order of their identifiers."
    return timing(lanes, 0, 1_200_000, "Arbitration on can.virtual, 250 kbit/s", about)


def retransmission() -> str:
    """A bit of the first frame is flipped: an error frame, and the sender tries again."""

    def play(rig: Rig) -> None:
        sender = rig.attach("sender").link("can0")
        rig.attach("receiver").link("can0").on_receive(lambda message: None)
        sender.send(CanFrame(0x185, bytes.fromhex("01 02 03 04")))
        rig.run_until(3 * MS)

    faults = [{"what": "corrupt", "count": 1, "bit": 30}]
    sent = bus_alone(play, faults=faults)
    bit_ns = S // BITRATE
    frame = next(message for message in sent if isinstance(message.message, CanFrame))
    error = next(message for message in sent if isinstance(message.message, CanError))
    retry = frame_bar(frame, BITRATE, "185, complete")
    detected = (error.message.bit + 1) * bit_ns
    lanes = [
        Lane(
            "can0",
            [
                Bar(0, detected, "185, bit 30 flipped", "bad"),
                Bar(detected, retry.start_ns, "error frame", "outside"),
                retry,
            ],
            "250 kbit/s",
        )
    ]
    about = "The first attempt ends in an error frame; the second one succeeds."
    return timing(lanes, 0, 600_000, "A corrupted frame and its retransmission", about)


def ring_cycle() -> str:
    """One communication cycle of configs/ring.yaml in phase 4."""

    def play(rig: Rig) -> None:
        rig.run_until(20 * S)

    sent = [message for message in recorded("ring.yaml", play) if message.bus == "ring"]
    answers = [message for message in sent if isinstance(message.message, Answers)][-1:]
    cycles = [message for message in sent if isinstance(message.message, Cycle)]
    start_ns = beginning_of(answers[0])
    master: list[Bar] = []
    drives: list[Bar] = []
    for answer in answers:
        begin = beginning_of(answer)
        cycle = next(message for message in cycles if message.message.number == answer.message.number)
        at_ns = begin + telegram_ns(MST_BYTES, MBAUD)
        master.append(Bar(begin, at_ns, "MST", "bus"))
        for at in answer.message.ats:
            length_ns = telegram_ns(len(at), MBAUD)
            drives.append(Bar(at_ns + GAP_NS, at_ns + GAP_NS + length_ns, f"AT {at[0]}", "device"))
            at_ns += GAP_NS + length_ns
        mdt_ns = telegram_ns(len(cycle.message.mdt), MBAUD)
        master.append(Bar(cycle.time_ns - mdt_ns, cycle.time_ns, "MDT", "bus"))
    lanes = [Lane("max4", master, "master"), Lane("drives", drives, "infeed to outfeed")]
    about = "Each cycle begins with an MST. The answers of the drives follow, then the MDT of the master."
    return timing(lanes, start_ns, start_ns + 500_000, "The telegrams of a SERCOS cycle of ring.yaml, 4 Mbaud", about)


def beginning_of(answers: Sent) -> int:
    """The start of the MST of the cycle that these answers belong to."""
    return answers.time_ns - answers_ns(map(len, answers.message.ats), MBAUD)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {
    "can-arbitration": arbitration,
    "can-retransmission": retransmission,
    "ring-cycle": ring_cycle,
}
