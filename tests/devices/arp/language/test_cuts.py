"""A listing that ends anywhere, as in an editor or after a transfer that broke off, has a message or compiles."""

from contextlib import suppress

import arp_listings
import pytest

from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.language.files import ObjectError, decode, encode
from fieldrig_devices.languages.mistakes import CompileError

LISTINGS = {name: text for name, text in vars(arp_listings).items() if name.isupper() and isinstance(text, str)}
assert LISTINGS


@pytest.mark.long
@pytest.mark.parametrize("name", LISTINGS)
def test_a_listing_may_end_anywhere(name: str) -> None:
    text = LISTINGS[name]
    for end in range(len(text)):
        with suppress(CompileError):
            compile_text(text[:end])


@pytest.mark.long
@pytest.mark.parametrize("name", LISTINGS)
def test_an_object_that_ends_anywhere_is_refused(name: str) -> None:
    data = encode(compile_text(LISTINGS[name]), name, 1)
    assert decode(data).name == name
    for end in range(len(data) - 1):
        with pytest.raises(ObjectError):
            decode(data[:end])
