"""The colours of the BASIC of ARP cards."""

from typing import Any, Final

from fieldrig_devices.arp.language.instructions import (
    CONSTANTS,
    FUNCTIONS,
    KEYWORDS,
    ORGANISATION,
    RANGES,
    READS,
    SIGNATURES,
)
from fieldrig_devices.editor.grammars import rules

_NUMBERED: Final = ("ON", "CAM")
"""Instructions with a number directly behind the word."""
COMMANDS: Final = frozenset({*SIGNATURES, *READS} - set(_NUMBERED))


def grammar() -> dict[str, Any]:
    resources = "".join(sorted(RANGES))
    rest = KEYWORDS - {*ORGANISATION, *CONSTANTS, *FUNCTIONS, *COMMANDS, *_NUMBERED}
    return rules.grammar(
        "ARP BASIC",
        "source.arp",
        (
            rules.match("comment.line.semicolon.arp", r";.*$"),
            rules.match("string.quoted.double.arp", r'["“”„][^"“”„]*["“”„]'),
            rules.match("entity.name.label.arp", r"(?i)^\s*[a-z]\w*(?=\s*:)"),
            rules.match("support.variable.system.arp", r"(?i)[@#]\s*[a-z]+[0-9]*"),
            rules.words("keyword.control.arp", {*ORGANISATION, *rest}),
            rules.match("support.function.numbered.arp", rf"(?i)\b(?:{'|'.join(_NUMBERED)})[0-9]+\b"),
            rules.words("constant.language.arp", CONSTANTS),
            rules.words("support.function.arp", {*COMMANDS, *FUNCTIONS}),
            rules.match("variable.other.resource.arp", rf"(?i)\b[{resources}][0-9]+\b"),
            rules.match("variable.other.arp", r"(?i)\b[a-z]\w*\b"),
            rules.match("constant.numeric.arp", r"\b[0-9]+(?:\.[0-9]*)?"),
            rules.match("keyword.operator.arp", r"<<=|>>=|<<|>>|<=|>=|<>|==|[-+*/\\%&|^]=|[-+*/\\%&|^!=<>]"),
        ),
    )
