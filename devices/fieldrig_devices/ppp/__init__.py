"""PPP over a serial line: bytes and time in, bytes and IP packets out (RFC 1661, 1662, 1332, 1334)."""
