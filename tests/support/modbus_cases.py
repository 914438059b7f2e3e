"""The answers of a Modbus server: requests and responses as hexadecimal PDUs, for any transport.

The examples are those of the Modbus application protocol V1.1b3, chapter 6; `TABLE` and `SETTINGS` are a device for
which they hold.  Deviations: 6.21's example says conformity level 01 and counts 13 characters in "Product code XX",
here the objects can also be read one by one (81), and are counted right.
"""

from typing import Any, NamedTuple

TABLE = """
coils:                  # 6.1 and 6.11: CD 6B 05 from 0x13 on; 6.5: 0xAC
  - {address: 19, name: c0, initial: true}
  - {address: 20, name: c1}
  - {address: 21, name: c2, initial: true}
  - {address: 22, name: c3, initial: true}
  - {address: 23, name: c4, count: 2}
  - {address: 25, name: c6, count: 2, initial: true}
  - {address: 27, name: c8, count: 2, initial: true}
  - {address: 29, name: c10}
  - {address: 30, name: c11, initial: true}
  - {address: 31, name: c12}
  - {address: 32, name: c13, count: 2, initial: true}
  - {address: 34, name: c15}
  - {address: 35, name: c16, initial: true}
  - {address: 36, name: c17}
  - {address: 37, name: c18, initial: true}
  - {address: 172, name: valve}
  - {address: 300, name: fixed, access: ro, initial: true}
  - {address: 400, name: hidden, access: wo}
  - {address: 1000, name: many_coils, count: 2001}
discrete_inputs:        # 6.2: AC DB 35 from 0xC4 on
  - {address: 196, name: d0, count: 2}
  - {address: 198, name: d2, count: 2, initial: true}
  - {address: 200, name: d4}
  - {address: 201, name: d5, initial: true}
  - {address: 202, name: d6}
  - {address: 203, name: d7, count: 3, initial: true}
  - {address: 206, name: d10}
  - {address: 207, name: d11, count: 2, initial: true}
  - {address: 209, name: d13}
  - {address: 210, name: d14, count: 3, initial: true}
  - {address: 213, name: d17}
  - {address: 214, name: d18, initial: true}
  - {address: 215, name: d19}
  - {address: 216, name: d20, count: 2, initial: true}
holding_registers:
  - {address: 1, name: h1, count: 2}                                        # 6.6 and 6.12
  - {address: 3, name: h3, initial: 0xFE}                                   # 6.17
  - {address: 4, name: h4, initial: 0xACD}
  - {address: 5, name: h5, initial: 1}
  - {address: 6, name: h6, initial: 3}
  - {address: 7, name: h7, initial: 13}
  - {address: 8, name: h8, initial: 255}
  - {address: 14, name: h14, count: 3}
  - {address: 107, name: h107, initial: 0x22B}                              # 6.3
  - {address: 108, name: h108}
  - {address: 109, name: h109, initial: 100}
  - {address: 200, name: limited, scale: 0.1, min: 0, max: 100}
  - {address: 300, name: fixed_register, access: ro, initial: 7}
  - {address: 400, name: hidden_register, access: wo}
  - {address: 1000, name: many, count: 126}
  - {address: 65535, name: last, initial: 0xFFFE}
input_registers:
  - {address: 8, name: i8, initial: 10}                                     # 6.4
  - {address: 1000, name: many_inputs, count: 126}
fifos:
  - {address: 0x4DE, name: queue, initial: [0x1B8, 0x1284]}                 # 6.18
  - {address: 0x4DF, name: full, depth: 32, initial: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18,
     19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32]}
  - {address: 0x4E0, name: empty}
"""

SETTINGS: dict[str, Any] = {
    "turnaround_ms": 0.0,
    "exception_status": 0x6D,
    "identification": {
        "vendor_name": "Company identification",
        "product_code": "Product code XX",
        "revision": "V2.11",
    },
    "server_id": {"server_id": "0815", "additional": "fieldrig"},
}


class Case(NamedTuple):
    says: str
    steps: tuple[tuple[str, str], ...]
    """Request and response; an empty response is silence."""


def _hex(text: str) -> str:
    return text.encode().hex()


def _one(says: str, request: str, response: str) -> Case:
    return Case(says, ((request, response),))


EXAMPLES = [
    _one("6.1 read coils", "01 0013 0013", "01 03 CD6B05"),
    _one("6.2 read discrete inputs", "02 00C4 0016", "02 03 ACDB35"),
    _one("6.3 read holding registers", "03 006B 0003", "03 06 022B 0000 0064"),
    _one("6.4 read input registers", "04 0008 0001", "04 02 000A"),
    Case("6.5 write single coil", (("05 00AC FF00", "05 00AC FF00"), ("01 00AC 0001", "01 01 01"))),
    Case("6.6 write single register", (("06 0001 0003", "06 0001 0003"), ("03 0001 0001", "03 02 0003"))),
    _one("6.7 read exception status", "07", "07 6D"),
    _one("6.8 return query data", "08 0000 A537", "08 0000 A537"),
    Case(
        "6.11 write multiple coils",
        (("0F 0013 000A 02 CD01", "0F 0013 000A"), ("01 0013 000A", "01 02 CD01")),
    ),
    Case(
        "6.12 write multiple registers",
        (("10 0001 0002 04 000A 0102", "10 0001 0002"), ("03 0001 0002", "03 04 000A 0102")),
    ),
    _one("6.13 report server id", "11", "11 0B 0815 FF " + _hex("fieldrig")),
    Case(
        "6.16 mask write register: 0x12 and 0xF2, or 0x25, is 0x17",
        (
            ("06 0004 0012", "06 0004 0012"),
            ("16 0004 00F2 0025", "16 0004 00F2 0025"),
            ("03 0004 0001", "03 02 0017"),
        ),
    ),
    Case(
        "6.17 read/write multiple registers",
        (
            (
                "17 0003 0006 000E 0003 06 00FF 00FF 00FF",
                "17 0C 00FE 0ACD 0001 0003 000D 00FF",
            ),
            ("03 000E 0003", "03 06 00FF 00FF 00FF"),
        ),
    ),
    _one("6.18 read FIFO queue", "18 04DE", "18 0006 0002 01B8 1284"),
    _one(
        "6.21 read device identification",
        "2B 0E 01 00",
        "2B 0E 01 81 00 00 03 00 16"
        + _hex("Company identification")
        + "01 0F"
        + _hex("Product code XX")
        + "02 05"
        + _hex("V2.11"),
    ),
]

FUNCTION = [
    _one(f"function {code:#04x} is not there", f"{code:02X} 0000 0001", f"{code | 0x80:02X} 01")
    for code in (0x09, 0x0A, 0x0D, 0x0E, 0x12, 0x13, 0x14, 0x15, 0x19, 0x2A, 0x2C, 0x41, 0x64, 0x7F)
] + [
    _one("43 with another MEI type is not there", "2B 0D 00 00", "AB 01"),
    _one("8 with a reserved sub-function is not there", "08 0005 0000", "88 01"),
    _one("8 with sub-function 0x15 is not there", "08 0015 0000", "88 01"),
]

QUANTITY = [
    Case(
        f"function {code}: {most} is the most, and comes before the address",
        (
            (f"{code:02X} {at:04X} {most:04X}", ok),
            (f"{code:02X} {at:04X} {most + 1:04X}", f"{code | 0x80:02X} 03"),
            (f"{code:02X} {at:04X} 0000", f"{code | 0x80:02X} 03"),
            (f"{code:02X} 5555 0000", f"{code | 0x80:02X} 03"),
            (f"{code:02X} 5555 {most + 1:04X}", f"{code | 0x80:02X} 03"),
            (f"{code:02X} 5555 {most:04X}", f"{code | 0x80:02X} 02"),
            (f"{code:02X} {at:04X}", f"{code | 0x80:02X} 03"),
            (f"{code:02X} {at:04X} 0001 00", f"{code | 0x80:02X} 03"),
        ),
    )
    for code, at, most, ok in (
        (1, 1000, 2000, "01 FA" + 250 * "00"),
        (3, 1000, 125, "03 FA" + 250 * "00"),
        (4, 1000, 125, "04 FA" + 250 * "00"),
    )
] + [
    _one("2: a quantity beyond 2000 comes before the address", "02 00C4 07D1", "82 03"),
    Case(
        "15: 1968 coils at the most",
        (
            ("0F 03E8 07B0 F6" + 246 * "FF", "0F 03E8 07B0"),
            ("01 0B96 0003", "01 01 03"),
            ("0F 03E8 07B1 F7" + 247 * "FF", "8F 03"),
            ("0F 03E8 0000 00", "8F 03"),
            ("0F 5555 0000 00", "8F 03"),
        ),
    ),
    Case(
        "15: the byte count has to fit, and comes before the address",
        (
            ("0F 0013 000A 01 CD", "8F 03"),
            ("0F 0013 000A 03 CD0100", "8F 03"),
            ("0F 0013 000A 02 CD", "8F 03"),
            ("0F 0013 000A 02 CD0100", "8F 03"),
            ("0F 5555 000A 01 CD", "8F 03"),
            ("0F 0013", "8F 03"),
            ("0F 5555 000A 02 CD01", "8F 02"),
        ),
    ),
    Case(
        "16: 123 registers at the most",
        (
            ("10 03E8 007B F6" + 246 * "55", "10 03E8 007B"),
            ("10 03E8 007C F8" + 246 * "55", "90 03"),
            ("10 03E8 0000 00", "90 03"),
            ("10 5555 007C F8" + 246 * "55", "90 03"),
        ),
    ),
    Case(
        "16: the byte count has to fit, and comes before the address",
        (
            ("10 0001 0002 03 000A01", "90 03"),
            ("10 0001 0002 04 000A", "90 03"),
            ("10 0001 0002 04 000A 0102 00", "90 03"),
            ("10 5555 0002 03 000A01", "90 03"),
            ("10 0001", "90 03"),
            ("10 5555 0001 02 000A", "90 02"),
        ),
    ),
    Case(
        "23: 125 to read and 121 to write at the most",
        (
            ("17 03E8 007D 03E8 0079 F2" + 242 * "01", "17 FA" + 242 * "01" + 8 * "00"),
            ("17 03E8 007E 03E8 0001 02 0001", "97 03"),
            ("17 03E8 0000 03E8 0001 02 0001", "97 03"),
            ("17 03E8 0001 03E8 0000 00", "97 03"),
            ("17 03E8 0001 03E8 007A F4" + 242 * "01", "97 03"),
            ("17 5555 0001 03E8 0001 03 000100", "97 03"),
            ("17 03E8 0001", "97 03"),
        ),
    ),
    Case("22 has seven bytes", (("16 0004 00F2", "96 03"), ("16 0004 00F2 0025 00", "96 03"))),
    Case("24 has three bytes", (("18 04", "98 03"), ("18 04DE 00", "98 03"))),
    Case("5 and 6 have five bytes", (("05 00AC FF", "85 03"), ("05 00AC FF00 00", "85 03"), ("06 0001", "86 03"))),
    Case("7 and 17 have one byte", (("07 00", "87 03"), ("11 00", "91 03"))),
]

VALUE = [
    Case(
        "a coil value is 0x0000 or 0xFF00, before the address",
        (
            ("05 00AC 0001", "85 03"),
            ("05 00AC 1234", "85 03"),
            ("05 00AC FFFF", "85 03"),
            ("05 5555 FF01", "85 03"),
            ("05 5555 FF00", "85 02"),
            ("05 00AC FF00", "05 00AC FF00"),
            ("05 00AC 0000", "05 00AC 0000"),
            ("01 00AC 0001", "01 01 00"),
        ),
    ),
    Case(
        "a write beyond the limits of a value is a server failure and changes nothing",
        (
            ("06 00C8 03E8", "06 00C8 03E8"),
            ("06 00C8 03E9", "86 04"),
            ("10 00C8 0001 02 FFFF", "90 04"),
            ("16 00C8 0000 FFFF", "96 04"),
            ("17 00C8 0001 00C8 0001 02 FFFF", "97 04"),
            ("03 00C8 0001", "03 02 03E8"),
        ),
    ),
]

ADDRESS = [
    Case(
        "a gap, a border, and a place after the last address are not there",
        (
            ("03 0000 0001", "83 02"),
            ("03 0000 0002", "83 02"),
            ("03 0008 0002", "83 02"),
            ("03 006A 0003", "83 02"),
            ("03 FFFF 0001", "03 02 FFFE"),
            ("03 FFFF 0002", "83 02"),
            ("03 FFFE 0002", "83 02"),
            ("01 0012 0013", "81 02"),
            ("02 00C4 0017", "82 02"),
            ("04 0007 0001", "84 02"),
            ("04 0009 0001", "84 02"),
        ),
    ),
    Case(
        "what is half there is not written at all",
        (
            ("10 0001 0003 06 0001 0002 0003", "10 0001 0003"),
            ("10 0007 0003 06 0001 0002 0003", "90 02"),
            ("03 0007 0002", "03 04 000D 00FF"),
            ("0F 0025 0002 01 00", "8F 02"),
            ("01 0025 0001", "01 01 01"),
        ),
    ),
    Case(
        "read only and write only",
        (
            ("05 012C 0000", "85 02"),
            ("06 012C 0001", "86 02"),
            ("01 012C 0001", "01 01 01"),
            ("03 012C 0001", "03 02 0007"),
            ("05 0190 FF00", "05 0190 FF00"),
            ("06 0190 0001", "06 0190 0001"),
            ("01 0190 0001", "81 02"),
            ("03 0190 0001", "83 02"),
            ("16 0190 FFFF 0000", "96 02"),
        ),
    ),
    Case(
        "23 checks both addresses before it writes",
        (
            ("17 5555 0001 0001 0001 02 0009", "97 02"),
            ("17 0001 0001 5555 0001 02 0009", "97 02"),
            ("17 0001 0001 0001 0001 02 0009", "17 02 0009"),
        ),
    ),
    Case(
        "a FIFO that is not there, one with more than 31, an empty one",
        (("18 04DD", "98 02"), ("18 04DF", "98 03"), ("18 04E0", "18 0002 0000")),
    ),
    _one("22 at an address that is not there", "16 5555 0000 0000", "96 02"),
]

IDENTIFICATION = [
    Case(
        "43: a code beyond 4 is a wrong value, an unknown object a wrong address only when it is asked for alone",
        (
            ("2B 0E 00 00", "AB 03"),
            ("2B 0E 05 00", "AB 03"),
            ("2B 0E 04 03", "AB 02"),
            ("2B 0E 04 02", "2B 0E 04 81 00 00 01 02 05" + _hex("V2.11")),
            ("2B 0E 01 02", "2B 0E 01 81 00 00 01 02 05" + _hex("V2.11")),
            ("2B 0E 03 02", "2B 0E 03 81 00 00 01 02 05" + _hex("V2.11")),
            ("2B 0E 01", "AB 03"),
            ("2B 0E 01 00 00", "AB 03"),
        ),
    ),
    Case(
        "43: an unknown first object means: from the beginning",
        (
            (
                "2B 0E 02 40",
                "2B 0E 02 81 00 00 03 00 16"
                + _hex("Company identification")
                + "01 0F"
                + _hex("Product code XX")
                + "02 05"
                + _hex("V2.11"),
            ),
        ),
    ),
]

DIAGNOSTICS = [
    Case(
        "8: query data comes back as it is",
        (("08 0000 0001 0203", "08 0000 0001 0203"), ("08 0000 01", "88 03"), ("08 0000", "88 03"), ("08 00", "88 03")),
    ),
    Case(
        "8: a counter is asked for with 0000",
        (("08 000B 0001", "88 03"), ("08 0002 0000", "08 0002 0000"), ("08 0002 1111", "88 03")),
    ),
    Case(
        "8: exceptions and messages are counted, and cleared",
        (
            ("08 000A 0000", "08 000A 0000"),
            ("03 5555 0001", "83 02"),
            ("41", "C1 01"),
            ("08 000D 0000", "08 000D 0002"),
            ("08 000E 0000", "08 000E 0004"),
            ("08 0001 0000", "08 0001 0000"),
            ("08 000D 0000", "08 000D 0000"),
            ("08 0001 FF00", "08 0001 FF00"),
            ("08 0001 00FF", "88 03"),
            ("08 0010 0000", "08 0010 0000"),
            ("08 0011 0000", "08 0011 0000"),
            ("08 0012 0000", "08 0012 0000"),
            ("08 0014 0000", "08 0014 0000"),
        ),
    ),
]

CASES = [*EXAMPLES, *FUNCTION, *QUANTITY, *VALUE, *ADDRESS, *IDENTIFICATION, *DIAGNOSTICS]
