"""Ways of foreign clients to the memory of a PAM: words for a script of a master."""

from collections.abc import Sequence
from typing import Any

from pymodbus.client import ModbusTcpClient


class Registers:
    """The memory as pymodbus sees it."""

    def __init__(self, client: ModbusTcpClient) -> None:
        self._client = client

    def read(self, word: int, count: int) -> Sequence[int]:
        answer = self._client.read_holding_registers(word, count=count)
        assert not answer.isError(), answer
        return list(answer.registers)

    def write(self, word: int, values: Sequence[int]) -> None:
        answer = self._client.write_registers(word, list(values))
        assert not answer.isError(), answer


class DataBlock:
    """The memory as snap7 sees it: bytes in a data block, two for a word."""

    def __init__(self, client: Any, block: int, byte_order: str) -> None:
        """`byte_order` is "little" if the even byte has the lower bits of a word."""
        self._client, self._block = client, block
        self._order: Any = byte_order

    def read(self, word: int, count: int) -> Sequence[int]:
        data = self._client.db_read(self._block, 2 * word, 2 * count)
        return [int.from_bytes(data[at : at + 2], self._order) for at in range(0, 2 * count, 2)]

    def write(self, word: int, values: Sequence[int]) -> None:
        data = b"".join(value.to_bytes(2, self._order) for value in values)
        self._client.db_write(self._block, 2 * word, bytearray(data))
