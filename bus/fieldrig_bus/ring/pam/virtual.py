"""`pamring.virtual`: the ring of a PAM in virtual time, and its model; `medium` has what each node hears."""

from collections.abc import Iterable, Sequence
from typing import ClassVar, Final

from pydantic import Field

from fieldrig.bus import ModelBus, Time
from fieldrig_bus.ring.impostors import Impostors
from fieldrig_bus.ring.model import RING, MediumModel
from fieldrig_bus.ring.pam.family import PamRingFamily
from fieldrig_bus.ring.pam.faults import RingFault
from fieldrig_bus.ring.pam.medium import PamMedium
from fieldrig_bus.ring.pam.message import Frames, RingMessage, span_bytes
from fieldrig_bus.ring.settings import OrderSettings

BYTE_NS: Final = 800
"""Duration of a byte on the fibre, at 10 Mbit/s; the manual gives no rate."""
SLOT_NS: Final = 200_000
"""Time from the begin of a cycle until its frames work in the nodes, however few they are.

The nodes of a real ring take set-points over in step, so the time between two of them does not depend on other frames.
"""


class PamRingModel(MediumModel[RingMessage]):
    """The ring of one PAM: all nodes hear the frames, and the PAM the reports, when both are over."""

    def __init__(self, order: Sequence[str], bypassed: Iterable[str] = (), faults: Iterable[RingFault] = ()) -> None:
        """`order` names stations; stations that it does not name follow in the order of joining."""
        self.medium = PamMedium(order, bypassed, faults)
        super().__init__(self.medium)
        self._impostors = Impostors()
        self._over_ns = 0
        self._overruns = 0

    def submit(self, now_ns: int, member: str, message: RingMessage) -> None:
        if message.__class__ is bytes:
            self.medium.stations[member].lay(message)
        elif member != self.medium.master:
            self._impostors.drop(member)
        elif isinstance(message, Frames):
            self._go_round(now_ns, message)

    def _go_round(self, now_ns: int, frames: Frames) -> None:
        """A cycle that begins before the last one is over waits for its end."""
        master = self.medium.master
        assert master is not None, "it sent the frames"
        self._overruns += now_ns < self._over_ns
        reports, heard = self.medium.go_round(now_ns, frames)
        bytes_in_all = span_bytes(frames.frames) + span_bytes(reports.reports) + len(reports.addresses)
        self._over_ns = max(now_ns, self._over_ns) + max(bytes_in_all * BYTE_NS, SLOT_NS)
        self._schedule(self._over_ns, RING, reports, (master,))
        for cycle, names in heard:
            self._schedule(self._over_ns, master, cycle, names)
        self._note_faults(now_ns)

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {**super().statistics(now_ns), "overruns": float(self._overruns)}


class PamRingSettings(OrderSettings):
    """Settings that every ring of a PAM has."""

    faults: list[RingFault] = Field(default=[], description="faults that the ring has from the start")


class PamRingVirtual(PamRingFamily, ModelBus[RingMessage]):
    about: ClassVar[str] = "ring of a PAM with its ST1 and Smart-IO nodes, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    settings: PamRingSettings

    def __init__(self, name: str, settings: PamRingSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> PamRingModel:
        settings = self.settings
        return PamRingModel(settings.order, settings.bypassed, settings.faults)
