"""The ways in which a case can end without passing."""


class Failed(Exception):  # noqa: N818  a verdict is not a programming error
    """The node deviates from the standard."""

    def __init__(self, expected: str, came: str) -> None:
        super().__init__(f"expected {expected}; came {came}")
        self.expected, self.came = expected, came


class Lost(Failed):
    """The node has answered none of several requests in a row."""


class NotApplicable(Exception):  # noqa: N818
    """The node doesn't support the subject of the case, according to its EDS or its answer."""


class SdoFault(Exception):  # noqa: N818
    """An SDO transfer failed.  A case that doesn't expect this has failed, too."""


class Aborted(SdoFault):
    """The server aborted the transfer with `code`."""

    def __init__(self, code: int, what: str) -> None:
        super().__init__(f"abort {abort_text(code)} for {what}")
        self.code = code


class NoAnswer(SdoFault):
    pass


class Violation(SdoFault):
    """An answer violates the protocol."""


# CiA 301, table 22.
ABORT_TEXTS = {
    0x0503_0000: "toggle bit not alternated",
    0x0504_0000: "SDO protocol timed out",
    0x0504_0001: "command specifier not valid or unknown",
    0x0504_0002: "invalid block size",
    0x0504_0003: "invalid sequence number",
    0x0504_0004: "CRC error",
    0x0504_0005: "out of memory",
    0x0601_0000: "unsupported access",
    0x0601_0001: "write-only object read",
    0x0601_0002: "read-only object written",
    0x0602_0000: "object does not exist",
    0x0604_0041: "object cannot be mapped",
    0x0604_0042: "mapped objects exceed the PDO's length",
    0x0604_0043: "parameter incompatible",
    0x0604_0047: "internal incompatibility",
    0x0606_0000: "hardware error",
    0x0607_0010: "length doesn't match",
    0x0607_0012: "length too high",
    0x0607_0013: "length too low",
    0x0609_0011: "sub-index does not exist",
    0x0609_0030: "invalid value",
    0x0609_0031: "value too high",
    0x0609_0032: "value too low",
    0x060A_0023: "resource not available",
    0x0800_0000: "general error",
    0x0800_0020: "cannot be stored",
    0x0800_0021: "cannot be stored: local control",
    0x0800_0022: "cannot be stored: device state",
    0x0800_0024: "no data available",
}


def abort_text(code: int) -> str:
    return f"{code >> 16:04X} {code & 0xFFFF:04X}h ({ABORT_TEXTS.get(code, 'unknown')})"
