"""A CANopen node on a bench: frames in and out as text, and the hands of its clock."""

from pathlib import Path
from typing import Any

from fieldrig.clock import MS, VirtualClock
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BitRate
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.node import CanopenNode, CanopenSettings

EDS = Path(__file__).parents[2] / "configs" / "eds"
IO32, LEVEL_SENSOR = EDS / "io32.eds", EDS / "level-sensor.eds"

Script = list[tuple[str, str]]
"""Frames of a master and the answers of the node; "" is silence."""


class RecordedCan(RecordedLink[CanFrame]):
    """Keeps the bit rates of the controller apart from the frames."""

    def __init__(self) -> None:
        super().__init__()
        self.bit_rates: list[int] = []

    def send(self, message: Any) -> None:
        if isinstance(message, BitRate):
            self.bit_rates.append(message.bit_per_s)
        else:
            super().send(message)


class CanopenBench:
    """Node 5, made from the EDS of the I/O module unless another one is given.

    A power cycle is another bench on the `store` of the first.
    """

    def __init__(self, eds: Path = IO32, store: Store | None = None, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.can, self.wires = RecordedCan(), RecordedLink[Signal]()
        self.store = store or MemoryStore()
        self.settings = CanopenSettings.model_validate({"node_id": 5, "eds": str(eds), **settings})
        self.node = CanopenNode(self.clock, "io", self.can, self.settings, self.store, self.wires)
        self.node.start()

    def send(self, *frames: str) -> list[str]:
        """Deliver frames such as "605#40 00 10 00 00 00 00 00" or "185#R"; what came out, all of this instant."""
        for frame in frames:
            self.can.deliver(parse(frame))
        return self.after(0)

    def after(self, ms: float) -> list[str]:
        """Return the frames that are sent in the next `ms` milliseconds."""
        self.clock.advance_to(self.clock.now_ns() + round(ms * MS))
        return self.take()

    def take(self) -> list[str]:
        return [show(frame) for frame in self.can.take()]

    def sdo(self, request: str) -> str:
        """The answer of the SDO server to 8 bytes in hex; "" for silence."""
        answers = [frame[4:] for frame in self.send(f"605#{request}") if frame.startswith("585#")]
        assert len(answers) < 2
        return answers[0] if answers else ""

    def play(self, script: Script) -> None:
        for request, answer in script:
            assert (request, self.sdo(request)) == (request, answer)

    def write(self, *requests: str) -> None:
        """Expedited downloads that succeed."""
        for request in requests:
            assert self.sdo(request)[:2] == "60", request

    def point(self, key: str) -> bool | int | float | str:
        return self.node.points()[key].read()

    def set(self, key: str, value: bool | int | float | str) -> None:
        write = self.node.points()[key].write
        assert write is not None
        write(value)

    @property
    def interest(self) -> list[int]:
        """Identifiers that the node asks the bus for."""
        interest: Any = self.can.interest
        return [item[0] for item in interest if item != "state"]


def parse(text: str) -> CanFrame:
    identifier, _, data = text.partition("#")
    is_extended = len(identifier) > 3
    if data == "R":
        return CanFrame(int(identifier, 16), is_extended=is_extended, is_remote=True)
    return CanFrame(int(identifier, 16), bytes.fromhex(data), is_extended=is_extended)


def show(frame: CanFrame) -> str:
    return f"{frame.identifier:0{8 if frame.is_extended else 3}X}#{frame.data.hex(' ')}"
