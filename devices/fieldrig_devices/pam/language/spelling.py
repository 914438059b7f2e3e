"""Names in any case, for the reading in which the listings' AXI_Axes and AXI_axes are one object (section 15.1)."""

from collections.abc import Iterable
from dataclasses import replace

from fieldrig_devices.pam.language.tokens import Token


def unified(tokens: Iterable[Token], known: Iterable[str]) -> list[Token]:
    """Return the tokens with each name in its first spelling.  The names in `known` keep their own."""
    first = {name.casefold(): name for name in known}
    return [
        replace(token, text=first.setdefault(token.text.casefold(), token.text)) if token.kind == "name" else token
        for token in tokens
    ]
