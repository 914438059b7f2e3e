"""Logs that are not read: how they begin, the programs that write them, and what to do instead."""

import re
from typing import Final

from fieldrig.errors import UsageError

PACKED: Final = {
    b"\x1f\x8b": "gzip",
    b"PK\x03\x04": "zip",
    b"\xfd7zXZ": "xz",
    b"\x28\xb5\x2f\xfd": "zstd",
    b"BZh": "bzip2",
}
"""The beginnings of packed files."""
LOOKED_AT: Final = 1024
"""Bytes in which the words of a program are looked for."""
OTHERWISE: Final = "have it written as ASC, BLF or TRC there"
BY_SAVVYCAN: Final = "SavvyCAN opens it, and saves it as GVRET log (CSV) or CAN-DUMP"
_CLOCK: Final = rb"\d\d:\d\d:\d\d\.\d{3}"
PROGRAMS: Final[tuple[tuple[bytes, str, str], ...]] = (
    (rb"\s*Chn Identifier Flg", "Kvaser CANKing", OTHERWISE),
    (rb"[^\n]*Kvaser Memorator Log", "Kvaser Memorator", "the converter of Kvaser's tools writes ASC, BLF and MF4"),
    (rb"ASCII Trace IXXAT", "IXXAT", OTHERWISE),
    (rb"(?:.*\n)?Microchip Technology Inc", "Microchip CAN BUS Analyzer", BY_SAVVYCAN),
    (rb"(?:.*\n)?\d{1,12}(?:\.\d+)? \d?(?:[RT](?:11|29) [0-9A-F]+|C(?:XX|VR|BC|EV) )", "OVMS (CRTD)", BY_SAVVYCAN),
    (rb"ID,Data Bytes", "SavvyCAN without times (Generic ID)", "have SavvyCAN save it as GVRET log (CSV) or CAN-DUMP"),
    (rb"(?:.*\n){0,9}Line,Abs Time\(Sec\)", "Vehicle Spy", BY_SAVVYCAN),
    (rb"[^\n]*CANopen Magic", "CANopen Magic", BY_SAVVYCAN),
    (rb";\s*CAN Logger trace file", "CAN Logger", BY_SAVVYCAN),
    (
        rb"(?:timestamp;arbitration_id|Time Stamp;ID);",
        "python-can or SavvyCAN that a spreadsheet has saved with semicolons",
        "save it with commas, and with points in its numbers",
    ),
    (rb"time,addr,bus,data", "Cabana", BY_SAVVYCAN),
    (rb"# Logger type:", "CSS Electronics CLX000", BY_SAVVYCAN),
    (rb"CANSERVER_v\d_CANSERVER", "CANServer", BY_SAVVYCAN),
    (rb'"No\.","Time",', "Wireshark (packets as CSV)", "save the capture itself as pcapng"),
    (rb"TTL \S?", "TTTech (TTL)", "Wireshark opens it, and saves it as pcapng"),
    (rb"DLT\x01", "AUTOSAR DLT", "Wireshark opens it, and saves it as pcapng"),
    (rb"icsbin", "Vehicle Spy (binary)", "have it written as ASC, BLF or MF4 there"),
    (rb"[A-Z]\d{6}\.\d{3} [0-9A-F]{5} [0-9A-F]{5} ", "Actisense (N2K ASCII)", "canboat's analyzer reads it"),
    (_CLOCK + rb" [RT] [0-9A-F]{8} ", "Yacht Devices (RAW)", "canboat's analyzer reads it"),
    (rb"\d{4}-\d\d-\d\d[-T ]\d\d:\d\d:\d\d[.,\dZ]*,\d,\d{4,6},", "canboat", "record CAN itself, with candump -L"),
    (
        rb"(?:t[0-9A-F]{3}|T[0-9A-F]{8})[0-8](?:[0-9A-F]{2}){0,10}[\r\n]",
        "an adapter of Lawicel (SLCAN)",
        "give the line to slcand of can-utils, and record with candump -L",
    ),
    (
        rb"[^\n]{0,60}?\b(?:TX|RX|SENT|SEND|RECV)\b[^\n]{0,30}?(?:\b(?:0x)?[0-9A-F]{1,2}\b[ ,]{1,2}){4}",
        "a serial line as text",
        "capture its bytes as pcap with link type USER0, or make one of their hex numbers: text2pcap -l 147",
    ),
)
"""The first words of logs, the programs that write them, and the remedy."""
ENDINGS: Final = {
    ".kme": "Kvaser Memorator",
    ".kme24": "Kvaser Memorator",
    ".kme25": "Kvaser Memorator",
    ".kme40": "Kvaser Memorator",
    ".kme50": "Kvaser Memorator",
    ".kmf": "Kvaser Memorator",
    ".vsb": "Vehicle Spy",
    ".ttl": "TTTech",
    ".dlt": "AUTOSAR DLT",
}
"""The endings of binary logs, of which no document is public."""
_PROGRAMS: Final = [(re.compile(words, re.IGNORECASE), name, remedy) for words, name, remedy in PROGRAMS]


def refuse_foreign(suffix: str, head: bytes) -> None:
    """Raise UsageError, with the name of the program, for a file that is packed or of a format that is not read."""
    packed = next((name for magic, name in PACKED.items() if head.startswith(magic)), None)
    if packed is not None:
        raise UsageError(f"it is packed ({packed})", "unpack it first")
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise UsageError("it is a text in UTF-16", "save it as UTF-8 or ASCII")
    start = head[:LOOKED_AT].removeprefix(b"\xef\xbb\xbf")
    for words, name, remedy in _PROGRAMS:
        if words.match(start):
            raise UsageError(f"it is a log of {name}, which is not read", remedy)
    if (program := ENDINGS.get(suffix.lower())) is not None:
        raise UsageError(f"it is a log of {program}, which is not read", "have it written as ASC, BLF or MF4 there")
