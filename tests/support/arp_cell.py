"""The cell of configs/arp-cell.yaml as a user starts it, and python canopen as its PLC."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import canopen
from canopen_network import network_on, socketcand_at
from running_rig import RunningRig, until

from fieldrig.testing import free_port
from fieldrig_devices.arp.can.face import EDS

CONFIGS = Path(__file__).parents[2] / "configs"
IO32 = CONFIGS / "eds" / "io32.eds"
IO1, IO2, PANEL, LINE, UNWINDER, TERMINAL = 1, 2, 3, 11, 12, 20
RESET_ENABLE, RUN, STOPPED = 1, 3, 4

# variables of the line's card
SPEED, TENSION, STAGE, MEASURE, SHEETS = 1, 2, 20, 21, 22
WAITS, RUNS = 0, 3000
START, STOP = 1, 2
"""Bits of the second flag word: F33, F34."""


class Cell(RunningRig):
    def __init__(self) -> None:
        self.can_port, self.user_port = free_port(), free_port()
        places = {
            "buses.can0.socketcand": f"127.0.0.1:{self.can_port}",
            "buses.user2.listen": f"127.0.0.1:{self.user_port}",
        }
        sets = [word for key, place in places.items() for word in ("--set", f"{key}={place}")]
        super().__init__(CONFIGS / "arp-cell.yaml", None, *sets)

    @property
    def run(self) -> Path:
        return self.folder / "run" / "arp-cell"

    def put(self, point: str, value: bool | int | float) -> None:
        device, _, key = point.partition("/")
        self.ask(f"device/{device}/set", {"values": {key: value}})


class Plc:
    """The master and its view of each node."""

    def __init__(self, network: canopen.Network) -> None:
        self.network = network
        self.line: Any = network.add_node(LINE, str(EDS))
        self.unwinder: Any = network.add_node(UNWINDER, str(EDS))
        self.panel: Any = network.add_node(PANEL, str(IO32))

    def variable(self, number: int) -> int:
        """Raw variable of the line's card."""
        value: int = self.line.sdo[0x2000][number].raw
        return value

    def put(self, number: int, raw: int) -> None:
        self.line.sdo[0x2000][number].raw = raw

    def ask_for(self, bits: int) -> None:
        """Flags F33 to F64."""
        self.line.sdo[0x2010][2].raw = bits

    def enable(self, is_on: bool) -> None:
        self.panel.sdo[0x6200][1].raw = int(is_on)
        wanted = RUN if is_on else RESET_ENABLE
        until(lambda: all(node.sdo[0x2102].raw == wanted for node in (self.line, self.unwinder)))

    def speed(self) -> float:
        """Speed of the film, in mm/s; a single count in 2 ms is 62.5."""
        raws: list[int] = [self.line.sdo[0x2201][2].raw for _ in range(20)]
        return sum(raws) / len(raws) / 1000

    def rest(self) -> None:
        """Close Enable.  The program begins at its first instruction and waits for a start."""
        self.enable(False)
        self.ask_for(0)
        for number, raw in ((SPEED, 50_000), (TENSION, 100_000)):
            self.put(number, raw)

    def run(self) -> None:
        """Start the film."""
        self.enable(True)
        self.ask_for(START)
        until(lambda: self.variable(STAGE) == RUNS)
        self.ask_for(0)


@contextmanager
def plc_of(cell: Cell) -> Iterator[Plc]:
    with network_on(socketcand_at(cell.can_port)) as network:
        yield Plc(network)
