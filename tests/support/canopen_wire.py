"""The master of python canopen against a node on a bench, connected by function calls."""

import canopen
from canopen_bench import CanopenBench

from fieldrig_bus.can.frame import CanFrame


class Wire(canopen.Network):
    """A network that passes frames to the bench and returns the node's frames at once."""

    def __init__(self, bench: CanopenBench) -> None:
        super().__init__()
        self.bench = bench
        self.received: list[int] = []
        self.frames: list[tuple[int, CanFrame]] = []
        """All frames that arrived, in both directions, with their instants."""
        self.lose: dict[int, int] = {}
        """Number of the frame that is lost, by identifier, counted from now on."""

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        if can_id in self.lose:
            self.lose[can_id] -= 1
            if self.lose[can_id] == 0:
                return
        frame = CanFrame(can_id, bytes(data), is_remote=remote)
        self.frames.append((self.bench.clock.now_ns(), frame))
        self.bench.can.deliver(frame)
        self.run(0)

    def run(self, ms: float) -> None:
        self.bench.clock.advance_to(self.bench.clock.now_ns() + round(ms * 1e6))
        for frame in self.bench.can.take():
            self.received.append(frame.identifier)
            self.frames.append((self.bench.clock.now_ns(), frame))
            self.notify(frame.identifier, bytearray(frame.data), self.bench.clock.now_ns() / 1e9)
