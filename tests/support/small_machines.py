"""The smaller rigs in tests of faults: the feeder, the Smart-IO node, the ARP cell, the lab, and the press."""

from typing import ClassVar, Final

from fault_choices import Injected
from faulted_machine import CAN_STAYS_ASIDE, Effect, Machine, Sign, goes_on, may_stop, stops, waits
from rig_hands import START_ALL

READY: Final = "ready"
FILM_RUNS: Final = 3
NIP_STANDS_RAD_S: Final = 0.05


class Feeder(Machine):
    """docs/devices/hmiscu/feeder.md: a key feeds one label; after a fault of the drive, key 2 resets."""

    file = "feeder.yaml"
    can_nodes: ClassVar = {"can3": 21}
    overrides = ("devices.feeder.channel_0.ramps=smooth",)
    in_error: ClassVar = Sign("feeder", "panel.line1", "drive error: reset")
    table: ClassVar = {
        **CAN_STAYS_ASIDE,
        "hmiscu link_broken": stops(in_error),
        "hmiscu internal_error": goes_on(),
        "hmiscu offline": stops(),
        "hmiscu exit_runtime": waits(Sign("feeder", "panel.line1", "sealer is heating")),
        "plant.stepper jam": stops(in_error),
        "plant.stepper weak": stops(in_error),
        "plant.stepper trip": stops(in_error),
        "plant.conveyor slip": goes_on(),
        "plant.conveyor dirty": goes_on(),
        "plant.heater broken": waits(Sign("feeder", "panel.line1", "sealer is heating")),
        "plant.heater stuck": waits(Sign("feeder", "panel.line1", "sealer is heating")),
    }
    safe_within_s = 30.0

    def begin(self) -> None:
        self.until(self._is_ready, 120, 1)

    def provoke(self) -> None:
        """Begin to feed a label."""
        self.set("feeder", "panel.key1", True)
        self.wait(0.15)

    def works(self) -> bool:
        self.set("feeder", "panel.key1", False)
        self.wait(1)
        return self._is_ready() and self._feed()[0] == 1

    def is_whole(self) -> bool:
        """Return whether a request feeds a whole label."""
        return self._is_ready() and self._feed() == (1, 1.0)

    def is_safe(self, where: str) -> bool:
        place = self.get("web", "position")
        self.wait(0.05)
        return self.get("web", "position") == place and not (where != "feeder" and self._is_ready())

    def come_back(self, injected: Injected, effect: Effect) -> None:
        if effect is not Effect.GOES_ON:
            assert self._feed() == (0, 0.0), "a request is refused"
        if effect is Effect.STOPS:
            self.press("feeder", "panel.key2", 0.5)
            assert (self.get("stepper", "ready"), self.get("feeder", "PTO00.State")) == (True, 0)
        self.until(self._is_ready, 300, 1)

    def _is_ready(self) -> bool:
        return self.get("feeder", "panel.line1") == READY

    def _feed(self) -> tuple[int, float]:
        """Ask for a label, and return how many more feeds there are and how far the web has moved, in labels."""
        self.set("feeder", "panel.key1", False)
        self.wait(0.1)
        before, place = int(self.get("feeder", "g_udiFeeds")), float(self.get("web", "position"))
        self.press("feeder", "panel.key1", 1)
        moved = float(self.get("web", "position")) - place
        return int(self.get("feeder", "g_udiFeeds")) - before, round(moved / 0.1, 3)


class SmartIo(Machine):
    """smart-io.md: a DC motor moves to positions; most errors end with the next order that moves it."""

    file = "smart-io.yaml"
    can_nodes: ClassVar = {"can4": 31}
    timed_out: ClassVar = Sign("io", "motor1.error", 0x1)
    table: ClassVar = {
        **CAN_STAYS_ASIDE,
        "smart_io short_circuit": stops(timed_out),
        "smart_io broken_wire": stops(timed_out),
        "smart_io overtemperature": goes_on(Sign("io", "error_word", 0x1000)),
        "smart_io damaged_frames crc": goes_on(Sign("io", "error_word", 0x4)),
        "smart_io damaged_frames type": goes_on(Sign("io", "error_word", 0x8)),
        "smart_io full_fifo": goes_on(Sign("io", "error_word", 0x2)),
        "smart_io low_battery": stops(Sign("io", "motor1.error", 0x4000)),
        "plant.dc-motor blocked": stops(timed_out),
        "plant.dc-motor no_pulses": stops(timed_out),
        "plant.dc-motor welded": stops(Sign("io", "motor1.error", 0xA000)),
        "plant.dc-motor pushed": stops(Sign("io", "motor1.error", 0x6000)),
    }
    felt: ClassVar = {"short_circuit": {"address": 201}}

    def begin(self) -> None:
        self._zero()

    def provoke(self) -> None:
        self._order(1, 100)
        self.wait(0.3)

    def works(self) -> bool:
        return all(self._move(target) for target in (40, 10))

    def is_safe(self, where: str) -> bool:
        """Return whether both outputs of the motor are off."""
        return not (self.get("io", "out201") or self.get("io", "out202"))

    def come_back(self, injected: Injected, effect: Effect) -> None:
        self._zero()

    def _move(self, target: int) -> bool:
        self._order(1, target)
        self.wait(1)
        place = float(self.get("rail", "position"))
        return bool(self.get("io", "motor1.ready")) and self.get("io", "motor1.error") == 0 and abs(place - target) < 2

    def _zero(self) -> None:
        self._order(6, -1, 1)
        self.until(lambda: self.get("io", "motor1.ready"), 10)

    def _order(self, order: int, value: int, second: int = 0) -> None:
        self.set("io", "motor1.value", value)
        self.set("io", "motor1.second", second)
        self.set("io", "motor1.order", 0)
        self.set("io", "motor1.order", order)


class Cell(Machine):
    """arp-cell.md: without the other card, a motor or film the line stops; a person opens Enable, and starts."""

    file = "arp-cell.yaml"
    can_nodes: ClassVar = {"can0": 3}
    table: ClassVar = {
        "can drop": stops(),
        "can delay": goes_on(),
        "can duplicate": goes_on(),
        "can replace": goes_on(),
        "can corrupt": stops(),
        "can error_frame": stops(),
        "can short": stops(),
        "can wrong_bit_rate": may_stop(),  # its error flags reach the frames of the cards for some time
        "can babble": stops(),
        "plant.servo blocked": stops(),
        "plant.servo encoder_signal": stops(Sign("line", "error", 116)),
        "arp memory": goes_on(),  # it is not accessed while the program runs
        "arp encoder_signal 1": goes_on(),  # of the unwinder, which regulates by its load cell
        "arp encoder_signal 2": stops(Sign("line", "error", 116)),
        "arp program_stopped": stops(Sign("unwinder", "error", 111)),
        "terminal.tr stuck_key": stops(),
        "plant.winder torn": stops(),
        "plant.winder slip": goes_on(),  # the tension stays; nothing measures the film behind the nip
    }

    def begin(self) -> None:
        self.set("panel", "6200:01", 1)
        self.wait(1)
        self.start()

    def start(self) -> None:
        self.set("io1", "6000:01", 1)
        self.wait(0.3)
        self.set("io1", "6000:01", 0)
        self.until(self.works, 60, what="the film")

    def works(self) -> bool:
        self.wait(0.2)
        return self.get("line", "V20") == FILM_RUNS and float(self.get("nip", "speed")) > 1

    def is_safe(self, where: str) -> bool:
        return abs(float(self.get("nip", "speed"))) < NIP_STANDS_RAD_S

    def wait_for_power(self) -> None:
        """Do nothing: no fault here takes the power from a device."""

    def come_back(self, injected: Injected, effect: Effect) -> None:
        if effect is Effect.GOES_ON:
            return
        self.masters["can0"].send(START_ALL)
        self.wait(0.5)
        for level in (0, 1):
            self.set("panel", "6200:01", level)
            self.wait(1)
        assert self.is_safe(injected.where)
        self.start()
