"""The devices of a CAN bus of a recording: which nodes there are, and what each of them is."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

from fieldrig.clock import MS
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader
from fieldrig_devices.canopen.guarding import GUARD_TIME, LIFE_TIME_FACTOR
from fieldrig_devices.canopen.heartbeat import CONSUMER_TIME, PRODUCER_TIME
from fieldrig_devices.canopen.io_names import PROFILE as IO_MODULES
from fieldrig_devices.canopen.nmt import STARTUP
from fieldrig_devices.canopen.standard import STORED_EDS
from fieldrig_devices.cia402 import objects as profile
from fieldrig_devices.drive_profile.objects import AXIS_STEP, is_drive_type
from fieldrig_devices.from_recording import pdos as pdo_rules
from fieldrig_devices.from_recording.bus_words import SYNC_COB_ID, SYNC_OVERFLOW, left_over
from fieldrig_devices.from_recording.can_log import EMCY_ID, SYNC_ID, CanLog, NodeLog
from fieldrig_devices.from_recording.described_node import DescribedNode
from fieldrig_devices.from_recording.drive_model import DriveModel
from fieldrig_devices.from_recording.drive_objects import drive_rows
from fieldrig_devices.from_recording.eds_text import eds_of
from fieldrig_devices.from_recording.emergencies import faults_of
from fieldrig_devices.from_recording.known_files import KnownFile, described_by
from fieldrig_devices.from_recording.known_objects import U8, U16, U32
from fieldrig_devices.from_recording.node_model import (
    DEVICE_TYPE,
    NodeModel,
    fill,
    fill_described,
    heartbeat_ms,
    pdo_models,
    runs_by_itself,
)
from fieldrig_devices.from_recording.pdos import Pdo
from fieldrig_devices.from_recording.refusals import refused_indices

EMCY_COB_ID: Final = 0x1014
WRONG_LENGTH: Final = frozenset({0x8210, 0x8220})
"""Emergencies of a node that receives a PDO which is too short or too long (CiA 301, 7.2.7.1)."""


class CanopenBus:
    """The nodes of one bus, and what else there was."""

    def __init__(self, log: CanLog, source: str, prefix: str, folder: Path, files: Iterable[KnownFile]) -> None:
        """`folder` takes the EDS files, `prefix` begins the names of the devices, `source` names the recording."""
        self._log, self._source, self._folder, self._prefix = log, source, folder, prefix
        self.remarks: list[str] = []
        nodes = self._nodes()
        paths = described_by(files, nodes)
        self.described = frozenset(paths.values())
        paths |= {node_id: path for node_id in nodes if node_id not in paths and (path := self._stored_eds(node_id))}
        self._dictionaries = {node_id: reader.load(path, node_id) for node_id, path in paths.items()}
        channels = {identifier for node in nodes.values() for identifier in pdo_rules.sdo_channels(node.objects.number)}
        seen = {
            identifier: line.count
            for identifier, line in log.identifiers.items()
            if line.count and identifier not in channels
        }
        known = {node_id: pdo_rules.configured(self._number(node_id), self._indices(node_id)) for node_id in nodes}
        found, rest = pdo_rules.assigned(seen, known, frozenset(nodes))
        self.remarks += left_over(log, rest, nodes)
        self.nodes = [self._model(node_id, found[node_id], paths.get(node_id)) for node_id in sorted(nodes)]

    # ---- which nodes there are

    def _nodes(self) -> dict[int, NodeLog]:
        log = self._log
        seen = {node_id: node for node_id, node in log.nodes.items() if node.is_seen}
        if not log.is_canopen:
            return {}
        masters = self._watched(seen)
        for node_id in sorted(masters):
            self.remarks.append(
                f"node {node_id} sends nothing but a heartbeat, and other nodes watch it (1016h): it is taken for the "
                "master, and is no device here"
            )
            del seen[node_id]
        seen |= {
            node_id: node for node_id, node in log.nodes.items() if node.life.emergencies and node_id not in masters
        }
        for identifier, line in log.identifiers.items():
            pdo = pdo_rules.predefined(identifier)
            is_sender = pdo is not None and pdo[1].is_transmitted and line.count > 0
            if pdo is None or not is_sender or pdo[0] in seen or pdo[0] in masters:
                continue
            if not self._is_configured(identifier, seen):
                seen[pdo[0]] = log.node(pdo[0])
        return seen

    def _watched(self, seen: Mapping[int, NodeLog]) -> set[int]:
        """Return the nodes that are probably the master: watched by others, and never asked, booted or commanded."""
        watched = {
            value >> 16 & 0x7F
            for node in seen.values()
            for (index, subindex) in node.objects.by_key
            if index == CONSUMER_TIME and subindex and (value := node.objects.number(index, subindex))
        }
        return {
            node_id
            for node_id in watched & set(seen)
            if not seen[node_id].life.boots
            and not seen[node_id].answers_sdo
            and not any(0x180 + step + node_id in self._log.identifiers for step in (0, 0x100, 0x200, 0x300))
        }

    def _is_configured(self, identifier: int, seen: Mapping[int, NodeLog]) -> bool:
        """True if a node has a PDO with this identifier by its parameters."""
        return any(
            identifier
            in pdo_rules.configured(node.objects.number, {index for index, _ in node.objects.by_key}).values()
            for node in seen.values()
        )

    def _stored_eds(self, node_id: int) -> Path | None:
        """Return the file with the EDS that the node has in 1021h; None if the recording has none that can be used."""
        log = self._log.nodes[node_id].objects.by_key.get((STORED_EDS, 0))
        if log is None or not log.is_read or not log.last:
            return None
        path = self._folder / f"{self._prefix}node{node_id}.eds"
        path.write_bytes(log.last)
        try:
            reader.load(path, node_id)
        except ValueError:
            self.remarks.append(f"node {node_id} has an EDS in 1021h that cannot be used")
            path.unlink()
            return None
        return path

    # ---- what they are

    def _number(self, node_id: int) -> pdo_rules.Number:
        logged, dictionary = self._log.nodes[node_id].objects.number, self._dictionaries.get(node_id)

        def number(index: int, subindex: int) -> int | None:
            seen = logged(index, subindex)
            variable = None if seen is not None or dictionary is None else dictionary.get(index, subindex)
            return seen if variable is None else variable.number

        return number

    def _indices(self, node_id: int) -> frozenset[int]:
        logged = {index for (index, _), log in self._log.nodes[node_id].objects.by_key.items() if log.is_there}
        dictionary = self._dictionaries.get(node_id, Dictionary(()))
        return frozenset(logged | {variable.index for variable in dictionary})

    def _model(self, node_id: int, pdos: Mapping[Pdo, int], path: Path | None) -> NodeModel:
        log = self._log.nodes[node_id]
        is_drive = self._is_drive(node_id)
        is_refusing = any(emergency.code in WRONG_LENGTH for emergency in log.life.emergencies)
        models = pdo_models(
            self._log,
            pdos,
            self._number(node_id),
            self._indices(node_id),
            log.life.breaks,
            is_drive=is_drive,
            is_refusing=is_refusing,
        )
        name = f"{self._prefix}node{node_id}"
        model = NodeModel(name, node_id, log, is_drive, models, log.life.begins_ns(self._log.start_ns))
        if log.objects.maps_while_valid:
            model.more["maps_while_valid"] = True
            model.decisions.append("its master changes the mapping of PDOs that stay valid, which it allows")
        drive = DriveModel(model) if is_drive else None
        if path is None:
            model.eds = self._folder / f"{name}.eds"
            model.eds.write_text(self._described(model, drive), encoding="ascii", newline="\n")
            model.dictionary = reader.load(model.eds, node_id)
            fill(model)
        else:
            model.eds, model.is_described, model.dictionary = path, True, self._dictionaries[node_id]
            fill(model)
            fill_described(model)
        has_cause = any(pdo.layout.is_misfit for pdo in models)
        emergencies = [one for one in log.life.emergencies if not (has_cause and one.code in WRONG_LENGTH)]
        model.faults += faults_of(emergencies, self._log.start_ns, is_drive=is_drive)
        if drive is not None:
            drive.write(self._log.start_ns)
            model.boot_up_ms = drive.settings.boot_up_ms
        elif log.life.boot_up_ns:
            model.boot_up_ms = model.more["boot_up_ms"] = round(log.life.boot_up_ns / MS, 1)
        return model

    def _is_drive(self, node_id: int) -> bool:
        indices = self._indices(node_id)
        is_said = is_drive_type(self._device_type(node_id))
        is_alike = profile.CONTROL_WORD in indices and profile.STATUS_WORD in indices
        has_several = profile.CONTROL_WORD + AXIS_STEP in indices or profile.STATUS_WORD + AXIS_STEP in indices
        if has_several:
            self.remarks.append(
                f"node {node_id} has several axes of CiA 402; a cia402.drive has one, so it is a node that replays"
            )
        return (is_said or is_alike) and not has_several

    def _is_io(self, node_id: int) -> bool:
        return self._device_type(node_id) & 0xFFFF == IO_MODULES

    def _device_type(self, node_id: int) -> int:
        """Return 1000h; a node that was replaced during the recording is the one at its begin."""
        first = self._log.nodes[node_id].objects.first_number(DEVICE_TYPE)
        return first or self._number(node_id)(DEVICE_TYPE, 0) or 0

    def _described(self, model: NodeModel, drive: DriveModel | None) -> str:
        node, log = DescribedNode(model.node_id, is_drive=model.is_drive, is_io=self._is_io(model.node_id)), model.log
        node.take(log.objects)
        for pdo in model.pdos:
            first = pdo.log.changes.changes(model.begin_ns)
            node.take_pdo(pdo.pdo, pdo.identifier, pdo.layout, pdo.rhythm, first[0].value if first else 0)
        refused = frozenset(refused_indices(log.objects.by_key))
        if PRODUCER_TIME not in refused:  # CiA 301 wants a heartbeat of every new node
            node.put(PRODUCER_TIME, 0, "Producer heartbeat time", U16, "rw", heartbeat_ms(log))
        if log.life.guarding_ns:
            node.add(GUARD_TIME, 0, "Guard time", U16, "rw", round(log.life.guarding_ns / MS))
            node.add(LIFE_TIME_FACTOR, 0, "Life time factor", U8, "rw")
        if log.life.emergencies:
            node.add(EMCY_COB_ID, 0, "COB-ID EMCY", U32, "rw", f"$NODEID+{EMCY_ID:#x}")
        if any(pdo.rhythm is not None and pdo.rhythm.is_synchronous for pdo in model.pdos):
            node.add(SYNC_COB_ID, 0, "COB-ID SYNC message", U32, "rw", f"{SYNC_ID:#x}")
            if self._log.sync_overflow:
                overflow = self._log.sync_overflow
                node.add(SYNC_OVERFLOW, 0, "Synchronous counter overflow value", U8, "rw", overflow)
        if runs_by_itself(log, model.pdos):
            node.add(STARTUP, 0, "NMT startup", U32, "rw")
        if drive is not None:
            for row in list(drive_rows(drive.unknown_objects(), node.rows, refused)):
                node.rows[row.index, row.subindex or 0] = row
            if drive.first_mode is not None and (profile.MODE, 0) in node.rows:
                node.rows[profile.MODE, 0] = replace(node.rows[profile.MODE, 0], start=drive.first_mode)
        node.complete()
        model.objects |= {f"{index:04X}:{sub:02X}": value for (index, sub), value in node.values.items()}
        model.remarks += [
            f"{index:04X}:{sub:02X} has {size} bytes, which are too many to be kept: the node has none of them"
            for (index, sub), size in node.too_long.items()
        ]
        model.remarks += [
            f"the objects that {index:04X}h maps, as not all of them were read: {what}"
            for index, what in node.unread_mappings.items()
        ]
        return eds_of(node, f"{model.name}.eds", self._source)
