"""Reads what the EDS or DCF file of a drive says about it: its modes, homing methods, encoder and units.

Source: CiA 402-2 for the objects.
What the file declares is what exists.  An object that it lacks has no effect: the engine works with a default, in the
units of the file.  Where the file gives 0, or nothing, for a limit, a rate or the profile velocity (6081h), with which
nothing could ever move, the engine works with the default too, though a master reads the 0, because real drives keep
such values in a memory of their own.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import Key, find
from fieldrig_devices.cia402.behaviour import Behaviour
from fieldrig_devices.cia402.homing_methods import ALL_METHODS
from fieldrig_devices.cia402.objects import ROWS, Row
from fieldrig_devices.cia402.si_units import SiUnits, si_units
from fieldrig_devices.cia402.units import units_of
from fieldrig_devices.drive_profile.objects import is_drive_type
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN

DEVICE_TYPE: Final = 0x1000
USUAL_INCREMENTS: Final = 4_096
"""Increments of an encoder of which the file says nothing: 1024 lines.

The following error window of such files (6065h) is some thousand increments, which a finer encoder soon exceeds.
"""
FEWEST_INCREMENTS: Final = 16
"""A resolution of an encoder below this is a value that the file does not know."""

TARGETS: Final = {
    1: objects.TARGET_POSITION, 2: objects.VL_TARGET, 3: objects.TARGET_VELOCITY, 4: objects.TARGET_TORQUE,
    6: objects.HOMING_METHOD, 7: objects.DATA_RECORD, 8: objects.TARGET_POSITION, 9: objects.TARGET_VELOCITY,
    10: objects.TARGET_TORQUE,
}  # fmt: skip
"""The object without which there is no such mode, for a file that does not say its modes."""
LENGTHS: Final = frozenset({objects.POSITION_WINDOW})
SPEEDS: Final = frozenset({
    objects.VELOCITY_WINDOW, objects.THRESHOLD, objects.MAX_VELOCITY, objects.PROFILE_VELOCITY, objects.HOMING_SPEED,
})  # fmt: skip
RATES: Final = frozenset({
    objects.PROFILE_ACCELERATION, objects.PROFILE_DECELERATION, objects.QUICK_STOP_DECELERATION,
    objects.HOMING_ACCELERATION, objects.MAX_ACCELERATION, objects.MAX_DECELERATION, objects.PROFILE_JERK,
})  # fmt: skip
CONSTANTS: Final = (objects.SUPPORTED_MODES, objects.RATED_TORQUE, objects.RATED_CURRENT, objects.DEVICE_TYPE)
"""Objects that describe drive and motor."""
NEVER_0: Final = RATES | {
    objects.VELOCITY_WINDOW, objects.THRESHOLD, objects.MAX_VELOCITY, objects.HOMING_SPEED, objects.MAX_MOTOR_SPEED,
    objects.MAX_TORQUE, objects.MAX_CURRENT, objects.TORQUE_SLOPE, objects.FOLLOWING_WINDOW,
    objects.VL_ACCELERATION, objects.VL_DECELERATION, objects.VL_QUICK_STOP,
}  # fmt: skip
"""Objects whose 0 means that the file does not know the value."""
NEVER_0_WITHIN: Final = frozenset({(objects.VL_AMOUNT, 2), (objects.BUFFER, 2)})
"""The same for single sub-indices: the highest speed of velocity mode, and the size of the buffer of set-points."""


class Declared(NamedTuple):
    """The description of a drive by its file."""

    behaviour: Behaviour
    defaults: Mapping[Key, int]
    """The numbers to use where the file has no such object, or none that could be meant."""
    defaults_in: Callable[[SiUnits], Mapping[Key, int]]
    """Returns these numbers in other units."""
    increments: int
    """Increments of the encoder per turn of the motor."""
    constants: frozenset[int]
    """The objects of `CONSTANTS` whose value file or master give; the drive shows its own in all others."""


def declared(path: Path, increments: int | None = None) -> Declared:
    """Return what the file says about a drive whose encoder has `increments` per turn, or as many as the file says.

    Raises EdsError if the file is refused.
    """
    return _declared(path, increments, path.stat().st_mtime_ns)


@lru_cache(maxsize=32)
def _declared(path: Path, increments: int | None, mtime_ns: int) -> Declared:
    description = reader.describe(path, reader.CHECKED_AS)
    file = _File(Dictionary(description.variables), description.given, increments)
    behaviour = Behaviour(
        modes=file.modes(), homing_methods=file.homing_methods(), has_feed_constant=file.has_feed_constant
    )
    said = si_units(file.number)
    return Declared(behaviour, file.defaults(said), file.defaults, file.increments, file.constants())


def name_parameters(dictionary: Dictionary) -> None:
    """Separate the parameters of the profile from the set-points, whatever access types the file gives them.

    Makers use `rww` and `rwr` for all that can be mapped; a master expects 1010h to save 6065h, and not 6040h.
    """
    for row in ROWS:
        variable = None if row.access == "ro" else find(dictionary, row)
        if variable is not None and variable.access.is_writable:
            variable.is_parameter = row.access == "rw"


class _File:
    def __init__(self, dictionary: Dictionary, given: frozenset[tuple[int, int]], increments: int | None) -> None:
        self._dictionary, self._given = dictionary, given
        self._variables = {(row.index, row.subindex or 0): find(dictionary, row) for row in ROWS}
        self.increments = increments or self._resolution() or USUAL_INCREMENTS

    def number(self, index: int, subindex: int = 0) -> int | None:
        """The number that the file gives; None if it gives none."""
        variable = self._dictionary.get(index, subindex)
        if variable is None or (index, subindex) not in self._given:
            return None
        value = variable.value
        return None if isinstance(value, str) else int(value)

    def modes(self) -> frozenset[int]:
        """Modes by 6502h, or by objects and limits if it does not say any, and those of the maker by 6060h."""
        bits = self.number(objects.SUPPORTED_MODES)
        if bits:
            modes = frozenset(mode for mode in TARGETS if bits >> (mode - 1) & 1)
        else:
            modes = frozenset(mode for mode, index in TARGETS.items() if index in self._dictionary)
            modes -= {mode for mode in modes if not self._accepts(mode)}
        mode = self._variables[objects.MODE, 0]
        return (
            modes | frozenset(range(int(min(mode.low, 0)), 0)) if mode is not None and mode.low is not None else modes
        )

    def _accepts(self, mode: int) -> bool:
        """True if the limits of 6060h permit this mode."""
        variable = self._variables[objects.MODE, 0]
        if variable is None:
            return True
        low, high = (limit if limit is not None else mode for limit in (variable.low, variable.high))
        return low <= mode <= high

    def constants(self) -> frozenset[int]:
        """The constants with a value in the file, and those that a master writes."""
        written = {index for index in (*CONSTANTS, objects.DC_LINK) if self._is_writable(index)}
        given = {index for index in CONSTANTS if self.number(index) is not None}
        unknown = set() if self.number(objects.SUPPORTED_MODES) else {objects.SUPPORTED_MODES}
        return frozenset((written | given) - unknown)

    def _is_writable(self, index: int) -> bool:
        variable = self._dictionary.get(index)
        return variable is not None and variable.access.is_writable

    def homing_methods(self) -> frozenset[int]:
        """Methods by 60E3h; without it, all, as far as the limits of 6098h permit."""
        members = self._dictionary.members(objects.HOMING_METHODS)
        listed = {self.number(objects.HOMING_METHODS, member.subindex) for member in members}
        return (frozenset(number for number in listed if number) & ALL_METHODS.keys()) or frozenset(ALL_METHODS)

    def _resolution(self) -> int | None:
        counts, turns = (self.number(objects.ENCODER_RESOLUTION, subindex) for subindex in (1, 2))
        per_turn = (counts or 0) // (turns or 1)
        return per_turn if per_turn >= FEWEST_INCREMENTS else None

    @property
    def has_feed_constant(self) -> bool:
        """False if 6092h gives one unit for a turn, with which there would be no position within a turn."""
        return self._pair(objects.FEED_CONSTANT, (0, 0)) != (1, 1)

    # ---- defaults

    def defaults(self, said: SiUnits) -> dict[Key, int]:
        """Return the numbers of our own drive where the file has none, in these units."""
        encoder = self._pair(objects.ENCODER_RESOLUTION, (self.increments, 1))
        gear = self._pair(objects.GEAR_RATIO, (1, 1))
        angle = said.per_turn
        unset = encoder if angle is None else (max(round(angle), 1), 1)
        feed = self._pair(objects.FEED_CONSTANT, unset)
        if feed == (1, 1):  # as the engine takes it, without `has_feed_constant`
            feed = unset
        turn = self.increments
        units = said.scaled(units_of(encoder, gear, feed, 0, 0.0), turn, turn * gear[0] / gear[1])
        scaled = _scaled(turn / units.per_unit, turn / units.per_speed_unit, turn / units.per_rate_unit)
        found = {(row.index, row.subindex or 0): scaled(row) for row in ROWS}
        for index, pair in ((objects.ENCODER_RESOLUTION, encoder), (objects.FEED_CONSTANT, feed)):
            found |= {(index, subindex): number for subindex, number in enumerate(pair, 1)}
        return {key: value for key, value in found.items() if self._is_unknown(key)}

    def _pair(self, index: int, otherwise: tuple[int, int]) -> tuple[int, int]:
        """The two numbers of a factor of the units; the engine takes a 0 as 1."""
        first, second = (self._variables[index, subindex] for subindex in (1, 2))
        if first is None:
            return otherwise
        return max(first.number, 1), 1 if second is None else max(second.number, 1)

    def _is_unknown(self, key: Key) -> bool:
        index = key[0]
        return (
            self._variables[key] is None
            or index in NEVER_0
            or key in NEVER_0_WITHIN
            or (index == objects.PROFILE_VELOCITY and not self.number(index))
        )


def _scaled(per_turn: float, speeds: float, rates: float) -> Callable[[Row], int]:
    """Return the function that gives the start value of our own drive, in the units of the file.

    A turn of the motor is `per_turn` user units, a turn per second `speeds` units of velocities, and a turn per second
    squared `rates` units of accelerations.
    """

    def scaled(row: Row) -> int:
        start = row.start if isinstance(row.start, int) else 0
        for rows, scale in ((LENGTHS, per_turn), (SPEEDS, speeds), (RATES, rates)):
            if row.index in rows:
                return max(round(start * scale / INCREMENTS_PER_TURN), 1)
        return start

    return scaled


def is_drive(dictionary: Dictionary) -> bool:
    """True if 1000h says CiA 402, or the objects are those of a drive whatever 1000h says."""
    is_said = is_drive_type(dictionary.number(DEVICE_TYPE, 0))
    return is_said or (objects.CONTROL_WORD in dictionary and objects.STATUS_WORD in dictionary)
