"""The card as a CANopen node (CiA 301), which foreign masters read and command, and which exchanges data with cards.

Source: digest chapters 7 to 10, 17 and 20; the manual describes no objects, so `arp-card.eds` is ours and is described
in docs/devices/arp/arp-can.md.  A reset of the node does not reset the card: communication restarts, and the program
continues. Left out: the CiA 402 image of the axes that the digest proposes; programs move axes, and masters request
motion from programs.
"""

from functools import partial
from pathlib import Path
from typing import Final

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.can import control, objects
from fieldrig_devices.arp.can.emergencies import Emergencies
from fieldrig_devices.arp.can.exchange import ExchangeSettings
from fieldrig_devices.arp.card_access import CardAccess
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.parameters import GENERAL, Par
from fieldrig_devices.canopen.node import CanopenNode, CanopenSettings
from fieldrig_devices.canopen.variable import Variable

EDS: Final = Path(__file__).with_name("arp-card.eds")
"""The EDS file of the card, for a CANopen master."""


class CanFace:
    """The node.  Its node-ID is @Par[5] in RAM at the start; `store` is a section of its own for 1010h."""

    def __init__(
        self,
        clock: Clock,
        name: str,
        can: Link[CanFrame],
        card: CardAccess,
        store: Store,
        exchange: ExchangeSettings | None = None,
    ) -> None:
        self._clock, self._name, self._can, self._card, self._store = clock, name, can, card, store
        self._exchange = exchange or ExchangeSettings()
        self._node: CanopenNode | None = None
        self._emergencies: Emergencies | None = None

    def start(self) -> None:
        """Power on, once the card's parameters are loaded: send the boot-up message and become operational."""
        self._node = node = CanopenNode(self._clock, self._name, self._can, self._settings(), self._store)
        for cell in objects.cells(self._card):
            _connect(node.dictionary.find(cell.index, cell.subindex), cell)
        control.connect(node.dictionary, self._card)
        self._emergencies = Emergencies(node, self._card)
        node.start()
        self.refresh()

    def refresh(self) -> None:
        """Update the values that PDOs carry, and send errors by EMCY; call it in each pass of the scheduler."""
        if self._node is None or self._emergencies is None:
            return
        for variable, read in self._node.watched:
            variable.set(read())
        self._emergencies.refresh()

    def _settings(self) -> CanopenSettings:
        node_id = self._card.parameters.ram[GENERAL][Par.CAN_NODE_ID] // SCALE
        return CanopenSettings(
            node_id=node_id,
            eds=EDS,
            signals={},
            objects=self._exchange.objects(node_id),
            serial_number=self._card.number,
        )


def _connect(variable: Variable, cell: objects.Cell) -> None:
    variable.reader = cell.read
    if cell.write is not None:
        variable.writer = partial(_write, variable, cell.write)


def _write(variable: Variable, write: objects.Write, data: bytes) -> None:
    """Write, and update the value that TPDOs carry at once."""
    write(data)
    assert variable.reader is not None
    variable.set(variable.reader())
