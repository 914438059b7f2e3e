"""The replies of FTP, with their codes.

Source: RFC 959, 4.2; RFC 2389 for FEAT; RFC 2428 for EPSV.
"""

from collections.abc import Iterable
from enum import StrEnum


class Reply(StrEnum):
    """The replies without variable parts."""

    OPENING = "150 File status okay; data follow."
    OKAY = "200 Command okay."
    NOT_NEEDED = "202 Command not needed."
    SYSTEM = "215 UNIX Type: L8"
    READY = "220 Service ready."
    GOODBYE = "221 Service closing control connection."
    ABORTED = "226 Closing data connection; transfer aborted."
    TRANSFERRED = "226 Closing data connection; transfer complete."
    LOGGED_IN = "230 User logged in, proceed."
    DONE = "250 Requested file action okay, completed."
    NEED_PASSWORD = "331 User name okay, need password."
    NEED_NEW_NAME = "350 Requested file action pending further information."
    CLOSING = "421 Service not available, closing control connection."
    NO_DATA_CONNECTION = "425 Cannot open data connection."
    TRANSFER_ABORTED = "426 Connection closed; transfer aborted."
    TOO_LONG = "500 Command line too long."
    UNKNOWN = "500 Syntax error, command unrecognized."
    WRONG_ARGUMENT = "501 Syntax error in parameters or arguments."
    NOT_IMPLEMENTED = "502 Command not implemented."
    WRONG_ORDER = "503 Bad sequence of commands."
    WRONG_ADDRESS = "504 Data connections go to the client's own address only, and to ports from 1024 on."
    WRONG_FAMILY = "522 Network protocol not supported, use (1,2)"
    WRONG_TYPE = "504 Command not implemented for that parameter."
    NOT_LOGGED_IN = "530 Not logged in."
    LOGIN_REFUSED = "530 Login incorrect."
    NO_FOLDERS = "550 The disk has no folders."
    NO_SPACE = "552 Requested file action aborted; exceeded storage allocation."


def refused(code: int, cause: ValueError) -> str:
    """Return a reply with the first line of a reason."""
    reason = str(cause).partition("\n")[0]
    return f"{code} {printable(reason)}"


def lines_of(code: int, first: str, lines: Iterable[str], last: str) -> str:
    """Return a reply of several lines, of which those in the middle begin with a blank (RFC 959, 4.2)."""
    return "\r\n".join((f"{code}-{first}", *(f" {line}" for line in lines), f"{code} {last}"))


def printable(text: str) -> str:
    """Return a text that cannot end its line."""
    return "".join(sign if sign.isprintable() else "?" for sign in text)
