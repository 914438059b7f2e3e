"""A Modbus server that is not ours, as a program: `foreign_modbus.py pymodbus|libmodbus FRAMER PLACE`.

PLACE is a port of 127.0.0.1, or the path of a serial port.  Unit 7 has 64 of everything; input register 16 is 1234, and
what follows it 2.5 as a float; discrete input 3 is set.
"""

import asyncio
import ctypes
import subprocess
import sys
from ctypes.util import find_library
from types import TracebackType
from typing import Self

UNIT = 7
COUNT = 64
LEVEL = (16, [1234, 0x4020, 0x0000])
SET_INPUT = 3
BAUD = 19200


class ForeignServer:
    """The program, started and killed as often as a test likes."""

    def __init__(self, library: str, framer: str, place: str) -> None:
        self._command = [sys.executable, __file__, library, framer, place]
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        # pymodbus complains at length on stderr of what it hears
        self._process = subprocess.Popen(self._command, stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.kill()


async def pymodbus(framer: str, place: str) -> None:
    from pymodbus import FramerType
    from pymodbus.server import ModbusSerialServer, ModbusTcpServer
    from pymodbus.simulator import DataType, SimData, SimDevice

    address, level = LEVEL
    bits = [SimData(0, count=COUNT, values=False, datatype=DataType.BITS)]
    inputs = [SimData(0, values=[place == SET_INPUT for place in range(COUNT)], datatype=DataType.BITS)]
    registers = [SimData(0, count=COUNT, values=0, datatype=DataType.REGISTERS)]
    readings = [
        SimData(0, count=address, values=0, datatype=DataType.REGISTERS),
        SimData(address, values=level, datatype=DataType.REGISTERS),
    ]
    device = SimDevice(UNIT, simdata=(bits, inputs, registers, readings))
    way = {"tcp": FramerType.SOCKET, "rtu": FramerType.RTU, "ascii": FramerType.ASCII}[framer]
    if place.isdecimal():
        await ModbusTcpServer(device, framer=way, address=("127.0.0.1", int(place))).serve_forever()
    else:
        server = ModbusSerialServer(device, framer=way, port=place, baudrate=BAUD, parity="N", reconnect_delay=0.1)
        await server.serve_forever()


def libmodbus(framer: str, place: str) -> None:
    class Mapping(ctypes.Structure):
        _fields_ = (
            *((f"{way}_{what}", ctypes.c_int) for what in WHAT for way in ("nb", "start")),
            ("tab_bits", ctypes.POINTER(ctypes.c_uint8)),
            ("tab_input_bits", ctypes.POINTER(ctypes.c_uint8)),
            ("tab_input_registers", ctypes.POINTER(ctypes.c_uint16)),
            ("tab_registers", ctypes.POINTER(ctypes.c_uint16)),
        )

    library = ctypes.CDLL(find_library("modbus") or "")
    for name in ("modbus_new_tcp", "modbus_new_rtu"):
        getattr(library, name).restype = ctypes.c_void_p
    library.modbus_new_rtu.argtypes = [ctypes.c_char_p, ctypes.c_int, ctypes.c_char, ctypes.c_int, ctypes.c_int]
    library.modbus_mapping_new.restype = ctypes.POINTER(Mapping)
    mapping = library.modbus_mapping_new(COUNT, COUNT, COUNT, COUNT)
    address, level = LEVEL
    for offset, value in enumerate(level):
        mapping.contents.tab_input_registers[address + offset] = value
    mapping.contents.tab_input_bits[SET_INPUT] = 1
    query = ctypes.create_string_buffer(260)
    if framer == "tcp":
        server = ctypes.c_void_p(library.modbus_new_tcp(b"127.0.0.1", int(place)))
        listening = ctypes.c_int(library.modbus_tcp_listen(server, 1))
    else:
        server = ctypes.c_void_p(library.modbus_new_rtu(place.encode(), BAUD, b"N", 8, 1))
        library.modbus_set_slave(server, UNIT)
        assert library.modbus_connect(server) == 0
    while True:
        if framer == "tcp":
            library.modbus_tcp_accept(server, ctypes.byref(listening))
        while (length := library.modbus_receive(server, query)) >= 0 or framer != "tcp":
            if length > 0:
                library.modbus_reply(server, query, length, mapping)
        library.modbus_close(server)


WHAT = ("bits", "input_bits", "input_registers", "registers")

if __name__ == "__main__":
    _, library, framer, place = sys.argv
    if library == "libmodbus":
        libmodbus(framer, place)
    else:
        asyncio.run(pymodbus(framer, place))
