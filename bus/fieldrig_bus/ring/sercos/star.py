"""The centre of a SERCOS ring in real time: MST, ATs and MDT of each cycle.

When the master sends its MST, it hears at once the ATs that are in the buffers; when it sends its MDT, the whole cycle
goes to the processes of the drives, whose ATs have time until the next MST.
Left out: the time that telegrams take on the fibre; it is shorter than the delays of the host.
"""

import asyncio
from collections.abc import Callable
from random import Random
from typing import Any, Final

from fieldrig.bus import Attachment
from fieldrig.clock import MS
from fieldrig_bus.ring.model import RING
from fieldrig_bus.ring.sercos.cycle_wire import encode_spread
from fieldrig_bus.ring.sercos.fibre import Fibre
from fieldrig_bus.ring.sercos.message import Answers, Mdt, Mst, encode
from fieldrig_bus.ring.sercos.virtual import RingSettings
from fieldrig_bus.ring.transport.bus import StarSettings
from fieldrig_bus.ring.transport.centre import Centre

OPERATION: Final = 3
"""The phase from which every station answers in every cycle."""


class RingStarSettings(StarSettings, RingSettings):
    """Settings of a SERCOS ring in real time."""


class Star(Centre):
    """The centre, with the fibre that it hosts."""

    def __init__(
        self,
        bus: str,
        at: Attachment,
        settings: RingStarSettings,
        handler: Callable[[Any], None],
        loop: asyncio.AbstractEventLoop,
    ) -> None:
        """`at` and `handler` are those of the master."""
        self._fibre = Fibre(settings.order, settings.mbaud, settings.bypassed, settings.faults, at.members)
        super().__init__(bus, at, self._fibre, settings.patience_ms * MS, handler, loop)
        self._fibre.begin_with(at.member, at.clock.now_ns(), Random(f"{at.seed}/{bus}"))
        self._answers: Answers | None = None

    def send(self, message: Any) -> None:
        if isinstance(message, Mst):
            self._begin_cycle(message)
        elif isinstance(message, Mdt):
            self._end_cycle(message.data)

    def _begin_cycle(self, mst: Mst) -> None:
        late = self.finish(is_repeating=mst.data[1] & 7 >= OPERATION)
        self._end_cycle(b"")
        answers = self._answers = self._fibre.begin_cycle(self._at.clock.now_ns(), mst, late)
        self.note_faults()
        self._at.heard(RING, answers)
        self._at.deliver(self.handler, answers)

    def _end_cycle(self, mdt: bytes) -> None:
        fibre = self._fibre
        heard = fibre.end_cycle(self._at.clock.now_ns(), mdt)
        if not heard:
            return
        self.note_faults()
        observed = encode(self._answers) if fibre.observers and self._answers is not None else b""
        instant_ns = self._at.clock.now_ns()
        self.spread(encode_spread(self.next_sequence(), instant_ns, heard, observed, fibre.station_count))
        for cycle, _ in heard:
            self._at.heard(self._at.member, cycle)
