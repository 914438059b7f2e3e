"""Fills the tank of the lab to 0.6 m and keeps it there: the level from the transmitter, the pump by Modbus.

A master as a user writes it: it knows the addresses of configs/lab.yaml, and nothing of fieldrig.
"""

import struct
import time

import can
from pymodbus import ModbusException
from pymodbus.client import ModbusTcpClient

SENSOR = 6
LEVEL, BOOT_UP = 0x180 + SENSOR, 0x700 + SENSOR
START_ALL_NODES = bytes([0x01, 0x00])
RUN = 0  # coil
SPEED = 0  # holding register, 0.1 %
FULL_MM = 600
CYCLE_S = 0.1
PATIENCE_S = 2.5  # the transmitter speaks every second


class Filling:
    def __init__(self, bus: can.BusABC, drive: ModbusTcpClient) -> None:
        self.bus, self.drive = bus, drive
        self.level_mm: int | None = None
        self.heard_s = time.monotonic()
        self.runs: bool | None = None

    def start_nodes(self) -> None:
        self.bus.send(can.Message(arbitration_id=0x000, data=START_ALL_NODES, is_extended_id=False))

    def listen(self, until_s: float) -> None:
        """Take what the nodes say until an instant."""
        while (left_s := until_s - time.monotonic()) > 0:
            frame = self.bus.recv(left_s)
            if frame is None:
                return
            if frame.arbitration_id == LEVEL:
                self.level_mm, _status = struct.unpack("<iB", frame.data)
                self.heard_s = time.monotonic()
            elif frame.arbitration_id == BOOT_UP and frame.data == b"\x00":
                self.level_mm = None  # until the node has said it again
                self.start_nodes()

    def control(self) -> None:
        if time.monotonic() - self.heard_s > PATIENCE_S:
            self.level_mm = None
        wanted = self.level_mm is not None and self.level_mm < FULL_MM
        if wanted != self.runs:
            self.tell(wanted)

    def tell(self, runs: bool) -> None:
        try:
            self.drive.write_register(SPEED, 1000)
            self.drive.write_coil(RUN, runs)
        except ModbusException:
            self.runs = None  # tried again in the next cycle
        else:
            self.runs = runs

    def run(self) -> None:
        self.start_nodes()
        next_s = time.monotonic()
        while True:
            next_s += CYCLE_S
            self.listen(next_s)
            self.control()


def main() -> None:
    with (
        can.Bus(interface="socketcand", host="127.0.0.1", port=29536, channel="can0") as bus,
        ModbusTcpClient("127.0.0.1", port=5020, timeout=0.5, retries=1) as drive,
    ):
        Filling(bus, drive).run()


if __name__ == "__main__":
    main()
