"""Moves a carriage to and fro by SDO: it finds the home switch, and then goes to a place to park and to three stations.

A master as a user writes it: it knows the addresses of configs/drive.yaml, and nothing of fieldrig.
"""

import itertools
import struct
import time
from math import pi

import can

NODE = 3
TIMEOUT_S = 0.2
TRIES = 5
ABORTED = 0x80
UNITS = 1e6 * 10 / (2 * pi)
"""Increments for one rad of the roller: a million for each turn of the motor, which has a gear of 10."""
FAST, SLOW = 0.3, 0.1
"""rad/s towards the switch."""
TOLERANCE = 0.02
WIDEST = 0.35
"""rad that the switch may be wide."""
BOUNCE_S = 0.5
"""A switch that is still on after this time was no bounce."""
PARK, STATIONS = -0.9, (1.0, 2.0, 3.0)
"""rad from home."""

CONTROL, STATUS, MODE = 0x6040, 0x6041, 0x6060
POSITION, TARGET, SPEED, VELOCITY, INPUTS = 0x6064, 0x607A, 0x6081, 0x60FF, 0x60FD
PROFILE_POSITION, PROFILE_VELOCITY = 1, 3
FAULT, TARGET_REACHED, HOME = 0x0008, 0x0400, 0x0004
SIZES = {CONTROL: 2, STATUS: 2, MODE: 1}


class DriveError(Exception):
    pass


class Carriage:
    def __init__(self, bus: can.BusABC) -> None:
        self.bus = bus
        self.home = 0.0

    # ---- SDO

    def ask(self, request: bytes) -> bytes:
        """Return the answer to a request; it is asked again after a time-out."""
        while self.bus.recv(0) is not None:  # late answers
            pass
        for _ in range(TRIES):
            self.bus.send(can.Message(arbitration_id=0x600 + NODE, data=request, is_extended_id=False))
            end_s = time.monotonic() + TIMEOUT_S
            while (left_s := end_s - time.monotonic()) > 0:
                frame = self.bus.recv(left_s)
                if frame is None or frame.arbitration_id != 0x580 + NODE:
                    continue
                if bytes(frame.data[1:4]) == request[1:4]:
                    return bytes(frame.data)
        raise DriveError("the drive does not answer")

    def read(self, index: int) -> int:
        answer = self.ask(struct.pack("<BHB4x", 0x40, index, 0))
        return int.from_bytes(answer[4 : 4 + SIZES.get(index, 4)], "little", signed=index == POSITION)

    def write(self, index: int, value: int) -> None:
        size = SIZES.get(index, 4)
        request = struct.pack("<BHB", 0x23 | (4 - size) << 2, index, 0)
        request += (value % (1 << 8 * size)).to_bytes(4, "little")
        while self.ask(request)[0] == ABORTED:
            time.sleep(0.05)  # the state of the drive does not allow it now

    # ---- the drive

    def enable(self) -> None:
        self.bus.send(can.Message(arbitration_id=0x000, data=[0x01, NODE], is_extended_id=False))
        for word in (0x80, 0x06, 0x07, 0x0F):
            self.write(CONTROL, word)
            time.sleep(0.1)  # the brake takes 40 ms

    def position(self) -> float:
        return self.read(POSITION) / UNITS

    def is_at_switch(self) -> bool:
        return bool(self.read(INPUTS) & HOME)

    def turn(self, rad_per_s: float) -> None:
        self.write(VELOCITY, round(rad_per_s * UNITS))

    def move_to(self, place: float) -> None:
        self.write(TARGET, round(place * UNITS))
        self.write(CONTROL, 0x1F)
        self.write(CONTROL, 0x0F)
        time.sleep(0.02)
        while not (status := self.read(STATUS)) & TARGET_REACHED:
            if status & FAULT:
                raise DriveError("a fault while it moves")
            time.sleep(0.02)

    # ---- home

    def approach(self, rad_per_s: float) -> float:
        """Turn until the switch is on, and return the place."""
        self.turn(rad_per_s)
        while not self.is_at_switch():
            time.sleep(0.01)
        place = self.position()
        self.turn(0)
        return place

    def is_homed(self) -> bool:
        """Find home twice; a switch that sticks does not go off again, and a bounce is not found twice."""
        first = self.approach(FAST)
        self.turn(-SLOW)
        while self.is_at_switch():
            if self.position() < first - WIDEST:
                self.turn(0)
                return False
            time.sleep(0.01)
        self.home = self.approach(SLOW)
        time.sleep(BOUNCE_S)
        return self.is_at_switch() and abs(self.home - first) < TOLERANCE

    def run(self) -> None:
        self.enable()
        self.write(MODE, PROFILE_VELOCITY)
        while not self.is_homed():
            time.sleep(0.1)
        time.sleep(0.3)  # until it stands
        self.write(MODE, PROFILE_POSITION)
        self.write(SPEED, round(2.0 * UNITS))
        for place in itertools.cycle((PARK, *STATIONS)):
            self.move_to(self.home + place)
            time.sleep(0.3)


def main() -> None:
    with can.Bus(interface="socketcand", host="127.0.0.1", port=29569, channel="can0") as bus:
        Carriage(bus).run()


if __name__ == "__main__":
    main()
