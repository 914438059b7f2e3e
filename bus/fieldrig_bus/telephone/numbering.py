"""The numbers of an exchange, and the meaning of the digits that a subscriber has dialled so far."""

from collections.abc import Mapping

from fieldrig_bus.telephone.message import Tone


class Numbering:
    def __init__(self, numbers: Mapping[str, str], prefix: str = "") -> None:
        """`numbers` are by member; `prefix` gives a second dial tone, and may be left out."""
        self._members = {number: member for member, number in numbers.items()}
        self._prefix = prefix

    def meaning(self, digits: str) -> str | Tone:
        """Return the member that the digits reach, or the tone that is heard after them."""
        if self._prefix and digits == self._prefix:
            return Tone.DIAL
        numbers = (digits, digits.removeprefix(self._prefix))
        called = next((self._members[number] for number in numbers if number in self._members), None)
        if called is not None:
            return called
        may_be_longer = any(known.startswith(numbers) for known in self._members)
        return Tone.SILENCE if may_be_longer else Tone.UNOBTAINABLE
