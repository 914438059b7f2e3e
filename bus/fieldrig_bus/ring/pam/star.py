"""The centre of a PAM's ring in real time.

When the PAM sends its frames, it hears at once the reports that are in the buffers, and the frames go to the processes
of the nodes, whose reports have time until the next cycle.  A process that is late hears its cycles later, but misses
none.  Where it stands still for so long that it would miss some, its nodes count as being without power.
Left out: the time that frames take on the fibre; it is shorter than the delays of the host.
"""

import asyncio
from collections.abc import Callable
from random import Random
from typing import Any

from fieldrig.bus import Attachment
from fieldrig.clock import MS
from fieldrig_bus.ring.model import RING
from fieldrig_bus.ring.pam.cycle_wire import encode_spread
from fieldrig_bus.ring.pam.medium import PamMedium
from fieldrig_bus.ring.pam.message import Frames, encode
from fieldrig_bus.ring.pam.virtual import PamRingSettings
from fieldrig_bus.ring.transport.bus import StarSettings
from fieldrig_bus.ring.transport.centre import Centre


class PamRingStarSettings(StarSettings, PamRingSettings):
    """Settings of a PAM's ring in real time."""


class PamStar(Centre):
    """The centre, with the medium that it hosts."""

    def __init__(
        self,
        bus: str,
        at: Attachment,
        settings: PamRingStarSettings,
        handler: Callable[[Any], None],
        loop: asyncio.AbstractEventLoop,
        most_behind: int,
    ) -> None:
        """`at` and `handler` are those of the PAM; `Centre` explains `most_behind`."""
        self._medium = PamMedium(settings.order, settings.bypassed, settings.faults, at.members)
        super().__init__(bus, at, self._medium, settings.patience_ms * MS, handler, loop, most_behind)
        self._medium.begin_with(at.member, at.clock.now_ns(), Random(f"{at.seed}/{bus}"))

    def send(self, message: Any) -> None:
        if isinstance(message, Frames):
            self._go_round(message)

    def _go_round(self, frames: Frames) -> None:
        late = self.finish(is_repeating=False)
        medium, at = self._medium, self._at
        medium.lose(self.hung_stations())
        instant_ns = at.clock.now_ns()
        reports, heard = medium.go_round(instant_ns, frames, late)
        self.note_faults()
        at.heard(RING, reports)
        at.deliver(self.handler, reports)
        observed = encode(reports) if medium.observers else b""
        self.spread(encode_spread(self.next_sequence(), instant_ns, heard, observed, medium.station_count))
        for cycle, _ in heard:
            at.heard(at.member, cycle)
