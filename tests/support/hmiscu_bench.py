"""One PTO axis with an instance of each block, and the hands of a clock."""

import itertools
from collections.abc import Callable, Sequence
from typing import Any

from fieldrig.clock import MS
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_devices.hmiscu.blocks.administrative import PTOGetDiag, PTOGetParam, PTOSetParam, PTOSimple
from fieldrig_devices.hmiscu.blocks.axis_block import REF_OF_CHANNEL_0
from fieldrig_devices.hmiscu.blocks.motion import PTOMoveRelative, PTOMoveVelocity, PTOStop
from fieldrig_devices.hmiscu.blocks.pins import Block
from fieldrig_devices.hmiscu.pto.channel import PtoChannel
from fieldrig_devices.hmiscu.pto.settings import PtoSettings
from fieldrig_devices.hmiscu.pto.status import MotionState

FINAL = ("Done", "InVelocity", "CommandAborted", "Error")


class PtoBench:
    """An axis with smooth ramps and without a hand-over, so that instants can be compared with the formulas."""

    def __init__(self, **settings: Any) -> None:
        self.now_ns = 0
        self.segments: list[PulseTrain] = []
        given = {"mode": "pto", "hand_over_ms": 0, "ramps": "smooth"} | settings
        self.channel = PtoChannel(PtoSettings.model_validate(given), self._on_segments)
        axes = {REF_OF_CHANNEL_0: self.channel}
        self.simple = PTOSimple(self.channel, REF_OF_CHANNEL_0)
        self.move, self.velocity, self.stop = PTOMoveRelative(axes), PTOMoveVelocity(axes), PTOStop(axes)
        self.get, self.set, self.diag = PTOGetParam(axes), PTOSetParam(axes), PTOGetDiag(axes)
        self.blocks: list[Block] = [self.simple, self.move, self.velocity, self.stop, self.get, self.set, self.diag]
        for block in self.blocks[1:]:
            block.inputs["PTO_REF_IN"] = REF_OF_CHANNEL_0

    def _on_segments(self, segments: Sequence[PulseTrain]) -> None:
        self.segments.extend(segments)

    # ---- time

    def cycle(self, after_ns: int = 0) -> None:
        """Call all blocks once, `after_ns` later."""
        self.now_ns += after_ns
        for block in self.blocks:
            block.call(self.now_ns)

    def cycles(self, number: int, period_ns: int = 10 * MS) -> None:
        for _ in range(number):
            self.cycle(period_ns)

    def until(self, is_so: Callable[[], Any], period_ns: int = MS, most: int = 100_000) -> None:
        for _ in range(most):
            if is_so():
                return
            self.cycle(period_ns)
        raise AssertionError("it never happens")

    def rest_ns(self) -> int:
        """Let the axis come to rest, without cycles, and return the instant."""
        while self.channel.output.is_moving:
            self.now_ns = max(self.channel.next_ns, self.now_ns)
            self.channel.advance(self.now_ns)
        return self.channel.output.train.start_ns

    # ---- blocks

    def execute(self, block: Block, **inputs: int) -> None:
        """Give a block a rising edge with these inputs, in cycles at the present instant."""
        block.inputs["Execute"] = False
        block.call(self.now_ns)
        block.inputs.update(inputs, Execute=True)
        block.call(self.now_ns)

    def release(self, block: Block) -> None:
        block.inputs["Execute"] = False
        block.call(self.now_ns)

    def relative(self, **inputs: int) -> None:
        self.execute(self.move, **{"Velocity": 20_000, "Distance": 40_000, **self._ramps(), **inputs})

    def run(self, **inputs: int) -> None:
        self.execute(self.velocity, **{"Velocity": 20_000, **self._ramps(), **inputs})

    def halt(self, **inputs: int) -> None:
        self.execute(self.stop, **{"Deceleration": self._ramps()["Deceleration"], **inputs})

    def _ramps(self) -> dict[str, int]:
        settings = self.channel.settings
        pin = 1000 if settings.ramp_unit == "ms" else 20
        return {"Acceleration": pin, "Deceleration": pin}

    def reset(self) -> None:
        for level in (False, True, False):
            self.simple.inputs["ResetError"] = level
            self.simple.call(self.now_ns)

    def diagnosis(self) -> int:
        self.execute(self.diag)
        return self.diag.outputs["PTODiag"]

    @property
    def state(self) -> MotionState:
        return self.channel.state

    @property
    def frequency(self) -> int:
        return self.channel.output.frequency_at(self.now_ns)

    @property
    def sent(self) -> int:
        return self.channel.output.sent_at(self.now_ns)


def shown(block: Block) -> set[str]:
    """Return the status pins that are TRUE."""
    return {name for name in (*FINAL, "Busy", "Active") if block.outputs.get(name)}


def edges(segments: Sequence[PulseTrain]) -> list[tuple[int, bool]]:
    """Return every edge of the segments: instant and level.  The last one is at rest."""
    found: list[tuple[int, bool]] = []
    for segment, after in itertools.pairwise(segments):
        found.extend(segment.edges(segment.start_ns, after.start_ns))
    return found
