"""The abort codes of a node: those that its object dictionary gives by itself, and faults for all others."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

from fieldrig.points.values import counted
from fieldrig_devices.canopen.abort import NAMES, Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.from_recording.objects import Key, ObjectLog

MOST_FAULTS: Final = 200
"""Faults of one node; more would hide everything else in the rig file."""
_DURING: Final = frozenset({Code.TOGGLE_BIT_NOT_ALTERNATED, Code.PROTOCOL_TIMED_OUT, Code.UNKNOWN_COMMAND_SPECIFIER,
                            Code.INVALID_BLOCK_SIZE, Code.INVALID_SEQUENCE_NUMBER, Code.CRC_ERROR})  # fmt: skip
"""Codes about the messages of a transfer and not about its object."""
_OF_VALUES: Final = frozenset({Code.INVALID_VALUE, Code.VALUE_TOO_HIGH, Code.VALUE_TOO_LOW, Code.PARAMETER_INCOMPATIBLE,
                               Code.GENERAL, Code.NOT_STORED, Code.DEVICE_STATE})  # fmt: skip
"""Codes about what is written, or when."""


class Refusals:
    """The refusals of a node, compared with those of its dictionary."""

    def __init__(self) -> None:
        self.faults: list[dict[str, Any]] = []
        self.remarks: list[str] = []
        self.left_out = 0

    def take(self, logs: Mapping[Key, ObjectLog], dictionary: Dictionary, is_driven: Callable[[Key], bool]) -> None:
        """Take the refusals of a node; `is_driven` says of which objects a drive itself judges what is written."""
        for key, log in sorted(logs.items()):
            for (is_download, code), count in log.aborts.items():
                if code not in _DURING and not (code in _OF_VALUES and is_download and is_driven(key)):
                    self._take(key, log, dictionary, is_download, code, count)

    def _take(self, key: Key, log: ObjectLog, dictionary: Dictionary, is_download: bool, code: int, count: int) -> None:
        data: list[bytes | None] = [each for other, each in log.refused_writes if other == code and is_download]
        if all(_answer(dictionary, key, is_download, each) == code for each in data or [None]):
            return
        index, subindex = key
        done = log.is_written if is_download else log.is_read
        others = [other for (direction, other) in log.aborts if direction == is_download and other != code]
        what = "writing" if is_download else "reading"
        if done or others:
            self.remarks.append(
                f"{what} {index:04X}h sub-index {subindex} ended in abort {words(code)} {counted(count, 'time')}, "
                "and worked at other times: why is not in the recording"
                if done
                else f"{what} {index:04X}h sub-index {subindex} also ended in abort {words(code)}"
            )
            if done or self._has(key, is_download):
                return
        if len(self.faults) >= MOST_FAULTS:
            self.left_out += 1
            return
        transfer = "download" if is_download else "upload"
        self.faults.append(
            {"what": "sdo_abort", "index": index, "subindex": subindex, "transfer": transfer, "code": code}
        )

    def _has(self, key: Key, is_download: bool) -> bool:
        transfer = "download" if is_download else "upload"
        return any((fault["index"], fault["subindex"], fault["transfer"]) == (*key, transfer) for fault in self.faults)


def refused_indices(logs: Mapping[Key, ObjectLog]) -> Iterator[int]:
    """Yield the indices of the objects of which the node says that they do not exist."""
    there = {index for (index, _), log in logs.items() if log.is_there}
    for (index, _), log in logs.items():
        if index not in there and any(code == Code.NO_OBJECT for _, code in log.aborts):
            yield index


def words(code: int) -> str:
    """Return a code as in `0609 0030h invalid value`."""
    name = NAMES.get(code, "an unknown code").lower().replace("_", " ")
    return f"{code >> 16:04X} {code & 0xFFFF:04X}h ({name})"


def _answer(dictionary: Dictionary, key: Key, is_download: bool, data: bytes | None) -> int | None:
    """Return the code with which the dictionary refuses an access; None if it accepts it."""
    try:
        variable = dictionary.find(*key)
        if is_download:
            variable.check_writable(None if data is None else len(data))
            return None if data is None else variable.refusal(data)
        variable.read()
    except Abort as abort:
        return abort.code
    return None
