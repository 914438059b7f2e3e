"""The labelling machine in tests of faults: a PAM, its nodes, and the machine around them."""

from typing import ClassVar, Final

from fault_choices import Injected
from faulted_machine import Effect, Machine, Sign, Table, goes_on, stops

IDLE, RUNNING, ERROR = 2, 3, 9
IN_ERROR: Final = Sign("plc", "DOF_Error", True)
FATAL: Final = stops(Sign("pam", "state", "fatal"))


def warns(word: int) -> Sign:
    return Sign("{where}", "error_word", word)


LABELLER: Final[Table] = {
    "st1 power_stage": stops(IN_ERROR),
    "st1 resolver": stops(IN_ERROR),
    "st1 over_voltage": stops(IN_ERROR),
    "st1 overload": stops(IN_ERROR),
    "st1 supply": stops(IN_ERROR),
    "st1 motor_temperature": goes_on(),
    "st1 jam": stops(IN_ERROR),
    "st1 servo_reset": stops(IN_ERROR),
    "smart_io short_circuit": goes_on(),
    "smart_io broken_wire": goes_on(),
    "smart_io overtemperature": goes_on(warns(0x1000)),
    "smart_io damaged_frames crc": goes_on(warns(0x4)),
    "smart_io damaged_frames type": goes_on(warns(0x8)),
    "smart_io full_fifo": goes_on(warns(0x2)),
    "smart_io low_battery": stops(IN_ERROR),
    "plant.dc-motor blocked": goes_on(Sign("pam", "display", "0080W003")),
    "plant.dc-motor no_pulses": goes_on(Sign("pam", "display", "0080W003")),
    "plant.dc-motor welded": goes_on(Sign("guide", "error_word", 0xA000)),
    "plant.dc-motor pushed": goes_on(Sign("guide", "error_word", 0x6000)),
    "plant.conveyor slip": goes_on(),
    "plant.conveyor dirty": goes_on(),
    "pam power_off": stops(),
    "pamring break": FATAL,
    "pamring off": FATAL,
    "pamring distort": FATAL,
    "pamring halt": stops(IN_ERROR),
    "pam.vme-master stopped": goes_on(),  # the PAM runs without a master; keys and limit switches stop it
    "pam.vme-master slow": goes_on(),
}


class Labeller(Machine):
    """pam-machine.md: an axis in error stops all; Reset and Start.  After a fatal error, a reset of the PAM."""

    file = "pam-machine.yaml"
    table = LABELLER
    safe_within_s = 12.0
    axes: ClassVar = ("belt", "cutter", "paper", "stacker")

    def begin(self) -> None:
        self.start()

    def start(self) -> None:
        self.until(lambda: self._state() == IDLE, 20, what="ready")
        self.set("plc", "DIF_Start", True)
        self.until(self._runs, 5, what="start")
        self.set("plc", "DIF_Start", False)
        self.wait(0.5)

    def provoke(self) -> None:
        self._move_guide(90 if self.get("plc", "DIL_Guide") != 90 else 30)
        self.wait(0.3)

    def works(self) -> bool:
        before = int(self.get("lane", "fed"))
        self.wait(2)
        return self._runs() and int(self.get("lane", "fed")) > before

    def is_safe(self, where: str) -> bool:
        """Return whether all axes stand; after its power-on, a PAM looks for the zero of the knife."""
        moving = ("belt", "paper") if where == "pam" else self.axes
        return all(abs(float(self.get(axis, "speed"))) < 0.01 for axis in moving)

    def wait_for_power(self) -> None:
        self.wait(6)

    def come_back(self, injected: Injected, effect: Effect) -> None:
        if injected.kind == "plant.dc-motor":
            self._guide_moves()
        if injected.fault["what"] == "stopped":  # 07..E01E ends with a reset
            self.set("pam", "reset", True)
            self.wait(1)
            self.start()
        if effect is Effect.GOES_ON:
            return
        if self._state() == ERROR and injected.fault["what"] != "low_battery":
            self.press("keys", "key3")
        elif injected.kind != "pam":
            self.set("pam", "reset", True)
            self.wait(1)
        self.start()

    def _move_guide(self, target: int) -> None:
        self.set("plc", "DIL_Guide", 0)
        self.wait(0.2)
        self.set("plc", "DIL_Guide", target)

    def _guide_moves(self) -> None:
        """Move the guide to two places, which are counted from where it was when it got power, or from its zero."""
        places = []
        for target in (30, 60):
            self._move_guide(target)
            self.wait(10 if target == 30 else 2)
            places.append(float(self.get("rail", "position")))
        assert abs(places[1] - places[0] - 30) < 2
        assert self.get("guide", "error_word") == 0
        assert "W" not in str(self.get("pam", "display"))

    def _state(self) -> object:
        return self.get("plc", "DOW_State")

    def _runs(self) -> bool:
        return self._state() == RUNNING and abs(float(self.get("belt", "speed")) - 4.0) < 0.05
