"""The ring buffer of strings; its strings are kept here, not in the buffer that the program gives."""

from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.iec.host import Results

TEXT: Final = """
FUNCTION_BLOCK FB_StringRingBuffer
(* Each string has its four bytes of length in front, and its zero behind it. *)
VAR_INPUT bOverwrite : BOOL; putValue : T_MaxString; pBuffer : PVOID; cbBuffer : UDINT; END_VAR
VAR_OUTPUT bOk : BOOL; getValue : T_MaxString; nCount, cbSize : UDINT; END_VAR
METHOD PRIVATE Ring : BOOL
VAR_INPUT command : INT; END_VAR
Ring := FIELDRIG_FILES_RING(
    ADR(THIS^), command, bOverwrite, putValue, cbBuffer, getValue => getValue, nCount => nCount, cbSize => cbSize);
Ring := Ring AND pBuffer <> 0;
bOk := Ring;
END_METHOD
METHOD A_Reset : BOOL
A_Reset := Ring(0);
END_METHOD
METHOD A_AddTail : BOOL
VAR_INPUT putValue : T_MaxString := '$01'; END_VAR
IF putValue <> '$01' THEN
    THIS^.putValue := putValue;
END_IF;
A_AddTail := Ring(1);
END_METHOD
METHOD A_GetHead : BOOL
VAR_OUTPUT getValue : T_MaxString; END_VAR
A_GetHead := Ring(2);
getValue := THIS^.getValue;
END_METHOD
METHOD A_RemoveHead : BOOL
VAR_OUTPUT getValue : T_MaxString; END_VAR
A_RemoveHead := Ring(3);
getValue := THIS^.getValue;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION FIELDRIG_FILES_RING : BOOL
VAR_INPUT block : PVOID; command : INT; bOverwrite : BOOL; putValue : T_MaxString; cbBuffer : UDINT; END_VAR
VAR_OUTPUT getValue : T_MaxString; nCount, cbSize : UDINT; END_VAR
{native} END_FUNCTION
"""

RESET, ADD, GET, REMOVE = range(4)
_OVERHEAD: Final = 5
"""The bytes that each string has besides its characters."""


@dataclass(slots=True)
class Rings:
    _rings: dict[int, list[str]] = field(default_factory=dict)
    """The strings of each ring, by the address of its block."""

    def act(self, block: int, command: int, overwrites: bool, value: str, room: int) -> Results:
        """Return whether the command can be done, the string that it has got, and the count and size of the ring."""
        ring = self._rings.setdefault(block, [])
        is_right, head = True, ""
        if command == RESET:
            ring.clear()
        elif command == ADD:
            size = len(value) + _OVERHEAD
            while overwrites and ring and _size(ring) + size > room:
                ring.pop(0)
            is_right = _size(ring) + size <= room
            if is_right:
                ring.append(value)
        elif is_right := bool(ring):
            head = ring.pop(0) if command == REMOVE else ring[0]
        return is_right, head, len(ring), _size(ring)


def _size(ring: list[str]) -> int:
    return sum(len(value) + _OVERHEAD for value in ring)
