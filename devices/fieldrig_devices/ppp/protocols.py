"""The numbers of the protocols that this end knows (RFC 1661 chapter 2; RFC 1700, PPP DLL protocol numbers)."""

from enum import IntEnum


class ProtocolNumber(IntEnum):
    IP = 0x0021
    VJ_COMPRESSED = 0x002D
    VJ_WHOLE = 0x002F
    IPCP = 0x8021
    LCP = 0xC021
    PAP = 0xC023
