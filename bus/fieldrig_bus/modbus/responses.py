"""Checks whether a response matches a request.

Source: Modbus application protocol V1.1b3, chapter 6, and chapter 7 for exceptions.  A serial line has no transaction
numbers, so only the contents distinguish a late response from the right one.
"""

from typing import Final

EXCEPTION: Final = 0x80
EXCEPTION_SIZE: Final = 2

BITS_READ: Final = frozenset({1, 2})
REGISTERS_READ: Final = frozenset({3, 4})
ECHOED: Final = {5: 5, 6: 5, 15: 5, 16: 5, 22: 7}
"""Number of bytes of the request that the response to a write repeats."""
READ_WRITE: Final = 23
READ_HEAD: Final = 5


def fits(request: bytes, response: bytes) -> bool:
    """True if the PDU of a response matches that of a request: by function code, and by size or echo where possible."""
    function = request[0]
    if response[0] == function | EXCEPTION:
        return len(response) == EXCEPTION_SIZE
    if response[0] != function:
        return False
    if (echoed := ECHOED.get(function)) is not None:
        return response == request[:echoed]
    size = _size(request)
    return size is None or (len(response) == 2 + size and response[1] == size)


def _size(request: bytes) -> int | None:
    """The size of the requested data, in bytes."""
    function, quantity = request[0], int.from_bytes(request[3:5], "big")
    if len(request) < READ_HEAD:
        return None
    if function in BITS_READ:
        return (quantity + 7) // 8
    return 2 * quantity if function in REGISTERS_READ or function == READ_WRITE else None
