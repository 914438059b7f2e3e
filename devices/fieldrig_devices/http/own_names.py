"""Which names a browser may have used to reach a device (RFC 9112, 3.2: the field Host).

A page of any site may let its own name lead to the address of the device (DNS rebinding), and then its scripts read
what the device answers.  Its requests have that name as Host, so only names are answered that no stranger can give an
address: IP addresses, localhost, and names without a dot, such as that of a container.  Others have to be configured.
"""

from collections.abc import Collection
from ipaddress import ip_address
from urllib.parse import urlsplit


def is_own(host: str, names: Collection[str] = ()) -> bool:
    """Return whether `host`, the value of a field Host with or without a port, is a name of the device.

    `names` are further ones.  False also for a value that no client may send.  The value is empty where the address of
    the client has no host, which a browser's always has.
    """
    if not host:
        return True
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
