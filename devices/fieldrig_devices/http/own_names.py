"""Which names a browser may have used to reach a device (RFC 9112, 3.2: the field Host).

A page of any site may let its own name lead to the address of the device (DNS rebinding), and then its scripts read
what the device answers.  Its requests have that name as Host, so only names are answered that no stranger can give an
address: IP addresses, localhost, and names without a dot, such as that of a container.  Others have to be configured.
"""

import re
from collections.abc import Collection
from ipaddress import AddressValueError, IPv6Address, ip_address
from typing import Final
from urllib.parse import urlsplit


def is_own(host: str, names: Collection[str] = ()) -> bool:
    """Return whether `host`, the value of a field Host with or without a port, is a name of the device.

    `names` are further ones.  False also for a value that no client may send.
    """
    try:
        parts = urlsplit(f"//{host}")
        name, _ = parts.hostname, parts.port
    except ValueError:
        return False
    if not name or parts.netloc != host or parts.username is not None or not name.isprintable() or " " in name:
        return False
    name = name.rstrip(".")
    if "." not in name or name.endswith(".localhost"):
        return True
    return name in {each.lower() for each in names} or _is_address(name)


def _is_address(name: str) -> bool:
    try:
        ip_address(name.partition("%")[0])
    except ValueError:
        return False
    return True


_HOST: Final = re.compile(
    rb"""
    (?: \[ (?P<ipv6> [0-9A-Fa-f:.]+ ) \]
      | \[ v [0-9A-Fa-f]+ \. [\w.~!$&'()*+,;=:-]+ \]
      | (?: [\w.~!$&'()*+,;=-] | % [0-9A-Fa-f]{2} )+
    )
    (?: : (?P<port> [0-9]* ) )?
    """,
    re.VERBOSE | re.ASCII,
)


def is_host(value: bytes) -> bool:
    """Return whether the field may have this value: a host, and perhaps a port (RFC 9110, 7.2).

    Source: RFC 3986, 3.2.2 and 3.2.3.  An http address always has a host, so an empty one is none (RFC 9110, 4.2.1; RFC
    9112, 3.3 leaves it to the server).
    """
    match = _HOST.fullmatch(value)
    if match is None:
        return False
    try:
        if match["ipv6"] is not None:
            IPv6Address(match["ipv6"].decode())
    except AddressValueError:
        return False
    return int(match["port"] or 0) <= 0xFFFF
