"""The files of a rig that is made from a recording."""

from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from string import Template
from tempfile import TemporaryDirectory
from typing import Final, NamedTuple

from fieldrig.errors import UsageError
from fieldrig.points.values import counted
from fieldrig.text.device_names import name_for
from fieldrig_devices.dialogues.modbus_servers import plain_bus
from fieldrig_devices.from_recording.can_log import CanLog
from fieldrig_devices.from_recording.can_part import can_part
from fieldrig_devices.from_recording.known_files import KnownFile, check_used, known_file
from fieldrig_devices.from_recording.modbus_part import modbus_part
from fieldrig_devices.from_recording.parts import RigPart, comment
from fieldrig_devices.from_recording.recording import BusLog, Recording
from fieldrig_devices.from_recording.rig_test import test_of

HEAD: Final = Template("""\
# Made from the recording $source: $what.
# `fieldrig up $name.yaml` starts it and prints its connections; `fieldrig check $name.yaml` explains mistakes.
# The comments say what the recording shows and what it does not. `fieldrig new --from` with `--with FILE.eds` fills in
# what an EDS file knows.
time: real                        # the clock of this host

buses:
""")


class Made(NamedTuple):
    """The files by path, the rig file first, and what the user should know at once."""

    content: Mapping[PurePosixPath, bytes]
    notes: list[str]
    without: Sequence[str]
    """The buses of the recording that the rig does not have, and that `fieldrig replay` would miss."""


def content_for(file: Path, words: Sequence[str] = ()) -> Made:
    """Return the files of a rig with one device for each that the recording shows.

    `words` are those of `--with`, such as `drive.eds` or `5=drive.eds`.  UsageError for a file that is no recording or
    shows no device, and for a file of `--with` that cannot be used.
    """
    files = [known_file(word) for word in words]
    recording, source = Recording(file), plain_name(file)
    with TemporaryDirectory() as folder:
        parts = [
            _part(name, bus, log, source, recording, Path(folder), place, files)
            for place, (name, bus, log) in enumerate(_named(recording.buses))
        ]
    notes = [remark for part in parts for remark in part.remarks] + _left_out(recording)
    used = [part for part in parts if part.nodes]
    if not used:
        raise UsageError(f"{file} shows no device of which a rig could be made", "\n".join(notes) or _hint(recording))
    if files and not any(isinstance(log, CanLog) for log in recording.buses.values()):
        raise UsageError("--with describes a CANopen node, and the recording has none", "leave it out")
    check_used(
        files,
        {path for part in used for path in part.described},
        {node_id for part in used if part.is_can for node_id in part.nodes},
    )
    without = [*recording.lines, *(bus for bus, part in zip(recording.buses, parts, strict=True) if not part.nodes)]
    return Made(_content(file, used, notes), notes, without)


def plain_name(file: Path) -> str:
    """Return the name of a file as a comment can have it."""
    return "".join(character if character.isprintable() else "?" for character in file.name)


def _part(
    name: str,
    bus: str,
    log: BusLog,
    source: str,
    recording: Recording,
    folder: Path,
    place: int,
    files: Sequence[KnownFile],
) -> RigPart:
    alike = sum(type(other) is type(log) for other in recording.buses.values())
    prefix = f"{name}-" if alike > 1 else ""
    if isinstance(log, CanLog):
        return can_part(name, log, source, prefix, folder, files, place)
    return modbus_part(name, log, source, prefix, place)


def _named(buses: Mapping[str, BusLog]) -> list[tuple[str, str, BusLog]]:
    """Return the buses with names that a rig file allows."""
    named: list[tuple[str, str, BusLog]] = []
    for bus, log in buses.items():
        name = plain_bus(bus)
        taken = {other for other, _, _ in named}
        named.append((next(word for word in _numbered(name) if word not in taken), bus, log))
    return named


def _numbered(name: str) -> list[str]:
    return [name, *(f"{name}-{number}" for number in range(2, 100))]


def _left_out(recording: Recording) -> list[str]:
    notes = [f"{plain_name(recording.file)}: {oddity}" for oddity in recording.odd]
    notes += [
        f"{counted(count, 'message')} of the family {family}: no device can be made of them"
        for family, count in sorted(recording.others.items())
    ]
    if recording.left_out:
        notes.append(f"{counted(recording.left_out, 'message')} of further buses, which are too many")
    return notes


def _hint(recording: Recording) -> str:
    return "a device is seen by what it sends: record the bus from the start of the machine on"


def _content(file: Path, parts: Sequence[RigPart], notes: Sequence[str]) -> Mapping[PurePosixPath, bytes]:
    name = name_for(file)
    devices = sum(len(part.nodes) for part in parts)
    what = f"{counted(devices, 'device')} on {counted(len(parts), 'bus', 'buses')}"
    lines = [line for part in parts for line in (*part.buses, "")]
    lines += ["devices:", *(line for part in parts for line in part.devices)]
    unused = [note for note in notes if not any(note in part.remarks for part in parts)]
    head = HEAD.substitute(source=plain_name(file), what=what, name=name)
    tail = "".join(f"{line}\n" for note in unused for line in comment(f"Left out: {note}", 0))
    rig = head + "\n".join(lines) + "\n" + tail
    test = test_of(name, parts)
    return {
        PurePosixPath(f"{name}.yaml"): rig.encode(),
        PurePosixPath(f"test_{name.replace('-', '_')}.py"): test.encode(),
        **{path: data for part in parts for path, data in part.files.items()},
    }
