"""The Host header field (RFC 9110, 7.2), whose value is a host and perhaps a port (RFC 3986, 3.2.2 and 3.2.3)."""

import re
from ipaddress import AddressValueError, IPv6Address
from typing import Final

_HOST: Final = re.compile(
    rb"""
    (?: \[ (?P<ipv6> [0-9A-Fa-f:.]+ ) \]
      | \[ v [0-9A-Fa-f]+ \. [\w.~!$&'()*+,;=:-]+ \]
      | (?: [\w.~!$&'()*+,;=-] | % [0-9A-Fa-f]{2} )*
    )
    (?: : (?P<port> [0-9]* ) )?
    """,
    re.VERBOSE | re.ASCII,
)


def is_host(value: bytes) -> bool:
    """Return true for a value that the field may have; it is empty if the client's address has no host."""
    match = _HOST.fullmatch(value)
    if match is None:
        return False
    try:
        if match["ipv6"] is not None:
            IPv6Address(match["ipv6"].decode())
    except AddressValueError:
        return False
    return int(match["port"] or 0) <= 0xFFFF
