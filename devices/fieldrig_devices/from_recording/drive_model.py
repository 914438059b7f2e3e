"""The behaviour of a drive of a recording as keys of the rig file, and the objects that no master has asked for."""

from typing import Final

from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader
from fieldrig_devices.cia402.behaviour import Behaviour
from fieldrig_devices.cia402.objects import ENCODER_RESOLUTION, MODE, MODE_DISPLAY
from fieldrig_devices.cia402.single.own_objects import EDS
from fieldrig_devices.cia402.single.personality import PersonalitySettings, personality, scale_speeds
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN
from fieldrig_devices.from_recording.drive_fit import Fit, fit
from fieldrig_devices.from_recording.drive_mains import mains_lost
from fieldrig_devices.from_recording.drive_signs import brake_lift_ms, signs_of
from fieldrig_devices.from_recording.drive_words import words_of
from fieldrig_devices.from_recording.node_model import NodeModel
from fieldrig_devices.from_recording.refusals import refused_indices

BRAKE_NM: Final = 2.0
"""Torque of a holding brake, which no recording says: more than that of the motor of a drive by default."""

CYCLE_MS: Final = 1.0
"""Cycle of the emulated drive, which it takes besides."""


class DriveModel:
    """The choice for one drive."""

    def __init__(self, model: NodeModel) -> None:
        self._model, self._logs = model, model.log.objects
        self._words = words = words_of(self._logs.words, model.pdos)
        self._lift = brake_lift_ms(words)
        refused = frozenset(refused_indices(self._logs.by_key))
        self._fit: Fit = fit(signs_of(model.log, words), self._logs, refused)

    def write(self, start_ns: int) -> None:
        """Give the node the keys of the rig file, once it has its dictionary; the rig is switched on at `start_ns`."""
        model, chosen = self._model, self._fit
        if chosen.personality is not None:
            model.more["personality"] = chosen.personality
        if chosen.behaviour:
            model.more["behaviour"] = chosen.behaviour
        if self._lift is not None:
            model.more["motor"] = {"brake_torque_nm": BRAKE_NM, "brake_lift_ms": max(self._lift - CYCLE_MS, 0.0)}
            model.decisions.append(f"it takes {self._lift:g} ms to enable, as a motor whose holding brake has to open")
        for key in chosen.objects:
            variable = model.dictionary.get(int(key[:4], 16), int(key[5:], 16))
            if variable is not None:
                model.objects.setdefault(key, variable.type.decode(variable.start))
        for fault in mains_lost(self._words, start_ns):
            model.faults.append(fault)
            come = "come later" if "duration_ms" in fault else "did not come"
            model.decisions.append(f"its mains {come} (bit 4 of the status word), which its fault `mains_lost` repeats")
        model.decisions += chosen.why

    @property
    def settings(self) -> PersonalitySettings:
        """The whole behaviour."""
        return personality(self._fit.personality, PersonalitySettings.model_validate(self._fit.behaviour))

    @property
    def first_mode(self) -> int | None:
        """The mode of operation at the beginning, as 6060h or 6061h show it first; None if neither does."""
        mode, display = (self._logs.by_key.get((index, 0)) for index in (MODE, MODE_DISPLAY))
        for log in (mode, display):
            if log is not None and log.first:
                return int.from_bytes(log.first, "little", signed=True)
        for pdo in self._model.pdos:
            changes = pdo.log.changes.changes(self._model.begin_ns)
            for place, part in enumerate(pdo.layout.parts):
                if part.key == (MODE_DISPLAY, 0) and changes:
                    value = pdo.layout.values(changes[0].value)[place]
                    return int.from_bytes(value.to_bytes(1, "little"), "little", signed=True)
        return None

    def unknown_objects(self) -> Dictionary:
        """Return our own drive's objects, with velocities in the units of this drive."""
        dictionary = reader.load(EDS, reader.CHECKED_AS)
        counts, turns = (self._logs.number(ENCODER_RESOLUTION, subindex) for subindex in (1, 2))
        increments = (counts or INCREMENTS_PER_TURN) // (turns or 1) or INCREMENTS_PER_TURN
        scale_speeds(dictionary, self.settings.behaviour(Behaviour(), increments).velocity_unit, {})
        return dictionary
