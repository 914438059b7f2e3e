"""The colours of the three languages: grammars in TextMate's form, made from the tables of words of our compilers.

Source of the form: the language grammars of TextMate 1.5, as Visual Studio Code reads them.  Nothing is written twice:
a word that a compiler learns has its colour in the next package.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final

from fieldrig_devices.editor.grammars import arp, iec, pam

GRAMMARS: Final[Mapping[str, Callable[[], dict[str, Any]]]] = {
    "st": iec.grammar,
    "pam": pam.grammar,
    "arp": arp.grammar,
}
"""The grammars by the identifiers that the languages have in the editor."""
