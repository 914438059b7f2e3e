"""The files of `--with`, and which node of the recording each of them describes."""

from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from fieldrig.cli.common import reading
from fieldrig.errors import UsageError
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader
from fieldrig_devices.canopen.eds.commissioning import commissioned
from fieldrig_devices.from_recording.can_log import NodeLog

IDENTITY, DEVICE_TYPE = 0x1018, 0x1000
SEARCHED = ((DEVICE_TYPE, 0), (IDENTITY, 1), (IDENTITY, 2))
"""Objects that tell devices apart."""


class KnownFile(NamedTuple):
    """An EDS or DCF file, and the node that it is for if the user or the file says so."""

    path: Path
    node_id: int | None


def known_file(word: str) -> KnownFile:
    """Return the file of a word such as `drive.eds` or `5=drive.eds`.  UsageError if it cannot be used."""
    number, equals, name = word.partition("=")
    is_numbered = bool(equals) and number.strip().isdigit()
    path = Path(name if is_numbered else word)
    node_id = int(number) if is_numbered else None
    if node_id is not None and not 1 <= node_id <= 127:
        raise UsageError(f"--with {word}: {node_id} is no node-ID", "expected 1 to 127")
    with reading(path, "expected an EDS or DCF file"):
        try:
            reader.load(path, node_id or reader.CHECKED_AS)
        except ValueError as cause:
            raise UsageError(
                f"{path} cannot be used:\n{cause}", f"`fieldrig eds check {path}` lists the rest"
            ) from cause
        return KnownFile(path, commissioned(path).node_id if node_id is None else node_id)


def described_by(files: Iterable[KnownFile], nodes: Mapping[int, NodeLog]) -> dict[int, Path]:
    """Return the file of each node of a bus that has one.  UsageError for a node with two.

    A file without a node-ID belongs to the nodes whose device type and identity the recording has and the file agrees
    with; where it has neither, to the only other node.
    """
    found: dict[int, Path] = {}
    for file in files:
        fitting = [file.node_id] if file.node_id is not None else _fitting(file.path, nodes)
        for node_id in fitting:
            if node_id in nodes and found.setdefault(node_id, file.path) != file.path:
                raise UsageError(
                    f"--with {file.path}: node {node_id} is described by {found[node_id]} too",
                    f"write --with NODE={file.path}",
                )
    return found


def check_used(files: Iterable[KnownFile], used: Collection[Path], nodes: Iterable[int]) -> None:
    """UsageError for a file that describes no node of any bus; `nodes` are those that there are."""
    for file in files:
        if file.path not in used:
            raise UsageError(
                f"--with {file.path}: the recording has no node that it describes",
                f"the nodes are {_listed(nodes)}: write --with NODE={file.path}",
            )


def _fitting(path: Path, nodes: Mapping[int, NodeLog]) -> list[int]:
    dictionary = reader.load(path, reader.CHECKED_AS)
    same = [node_id for node_id, log in nodes.items() if _is_same(dictionary, log)]
    if same:
        return same
    others = [node_id for node_id, log in nodes.items() if not _is_identified(log)]
    return others if len(others) == 1 else []


def _is_identified(log: NodeLog) -> bool:
    return any(log.objects.number(*key) is not None for key in SEARCHED)


def _is_same(dictionary: Dictionary, log: NodeLog) -> bool:
    """True if the recording has something of the identity, and all of it agrees with the file."""
    pairs = [(log.objects.number(*key), dictionary.get(*key)) for key in SEARCHED]
    known = [(number, variable) for number, variable in pairs if number is not None]
    return bool(known) and all(variable is not None and variable.number == number for number, variable in known)


def _listed(nodes: Iterable[int]) -> str:
    return ", ".join(map(str, sorted(nodes))) or "none"
