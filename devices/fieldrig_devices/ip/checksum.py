"""The internet checksum (RFC 1071)."""


def checksum(data: bytes) -> int:
    """Return the complement of the one's complement sum of the 16-bit words of `data`; an odd byte is the upper one.

    It is 0 for data that contain their own correct checksum.
    """
    if len(data) % 2:
        data += b"\x00"
    # RFC 1071, 2 (B): the sum modulo 0xFFFF of all words is the remainder of the whole number
    total = int.from_bytes(data, "big")
    remainder = total % 0xFFFF
    if remainder == 0 and total != 0:
        remainder = 0xFFFF
    return remainder ^ 0xFFFF
