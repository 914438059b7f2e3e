"""The messages that a rig sends in virtual time, for the scenes."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

from doc_pages import Block, blocks, page_named
from tests.pictures.timing import Bar

from fieldrig.bus import Bus, Delivery
from fieldrig.config.rig_file import from_dict, load
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import INTERMISSION_BITS, classical_bits

ROOT: Final = Path(__file__).parents[2]


class Sent(NamedTuple):
    """One message of a rig."""

    bus: str
    time_ns: int
    """The instant at which it ends."""
    sender: str
    message: Any
    shown: str


def recorded(source: str | Mapping[str, Any], play: Callable[[Rig], object], *overrides: str) -> list[Sent]:
    """Everything that a rig sends while `play` runs it; `source` is a file in configs or a rig as a mapping."""
    sent: list[Sent] = []

    def hear(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        shown = bus.show(delivery.message)
        sent.append(Sent(bus.name, delivery.time_ns, delivery.sender, delivery.message, shown))

    config = (
        load(ROOT / "configs" / source, ["time=virtual", *overrides])
        if isinstance(source, str)
        else from_dict(dict(source))
    )
    with Rig(config, on_delivery=hear) as rig:
        play(rig)
    return sent


def block_named(page: str, name: str) -> Block:
    """The fenced block of a page in docs that is saved under this name."""
    return next(block for block in blocks(page_named(page)) if block.info[-1:] == (name,))


def frame_bar(sent: Sent, bitrate: int, label: str | None = None, style: str = "bus") -> Bar:
    """The bar of a CAN frame, over the time that its bits take."""
    assert isinstance(sent.message, CanFrame)
    length_ns = (classical_bits(sent.message) - INTERMISSION_BITS) * 1_000_000_000 // bitrate
    return Bar(sent.time_ns - length_ns, sent.time_ns, sent.shown if label is None else label, style)
