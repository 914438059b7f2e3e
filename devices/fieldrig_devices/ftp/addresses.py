"""Addresses of data connections, as commands and replies of FTP write them (RFC 959, 4.1.2; RFC 2428)."""

import re
from ipaddress import IPv4Address, IPv6Address, ip_address
from typing import Final

Address = IPv4Address | IPv6Address

FIRST_PORT: Final = 1024
"""Lowest port to which a data connection is opened: services of the client are below it (RFC 2577, 3)."""
HIGHEST_PORT: Final = 65_535
_PORT: Final = re.compile(r"(\d{1,3}),(\d{1,3}),(\d{1,3}),(\d{1,3}),(\d{1,3}),(\d{1,3})", re.ASCII)
_EPRT: Final = re.compile(
    r"(?P<sign>[!-~])(?P<family>\d+)(?P=sign)(?P<host>[^|]*)(?P=sign)(?P<port>\d{1,5})(?P=sign)", re.ASCII
)
_VERSIONS: Final = {"1": 4, "2": 6}
FAMILIES: Final = {version: name for name, version in _VERSIONS.items()}
"""The number of a network protocol in EPRT and EPSV, by its version."""


class FamilyError(ValueError):
    """The client names a network protocol other than IPv4 and IPv6."""


def plain(address: str) -> Address:
    """Return the address of an end; an IPv4 address that was mapped into IPv6 is one of IPv4."""
    address_ = ip_address(address)
    return address_.ipv4_mapped or address_ if isinstance(address_, IPv6Address) else address_


def of_port(argument: str) -> tuple[Address, int]:
    """Return address and port of a PORT command.  ValueError for anything else."""
    match = _PORT.fullmatch(argument.strip())
    numbers = [int(number) for number in match.groups()] if match else []
    if not numbers or max(numbers) > 255:
        raise ValueError(f"expected six numbers from 0 to 255, got {argument!r}")
    return IPv4Address(bytes(numbers[:4])), numbers[4] << 8 | numbers[5]


def of_eprt(argument: str) -> tuple[Address, int]:
    """Return address and port of an EPRT command.  FamilyError or ValueError for anything else."""
    match = _EPRT.fullmatch(argument.strip())
    if match is None:
        raise ValueError(f"expected an address such as |1|10.0.0.7|50000|, got {argument!r}")
    version = _VERSIONS.get(match["family"])
    if version is None:
        raise FamilyError(f"expected the protocol 1 or 2, got {match['family']}")
    address = ip_address(match["host"])
    if address.version != version:
        raise ValueError(f"expected an address of IPv{version}, got {address}")
    if not 0 < int(match["port"]) <= HIGHEST_PORT:
        raise ValueError(f"expected a port from 1 to {HIGHEST_PORT}, got {match['port']}")
    return address, int(match["port"])


def as_pasv(address: IPv4Address, port: int) -> str:
    """Return the six numbers of a reply to PASV."""
    return ",".join(map(str, (*address.packed, *divmod(port, 256))))
