"""The words in the cells of a list for the space of a register and for what a client may do with it."""

import re
from typing import Final

from fieldrig_devices.begin.list_columns import without_accents

SPACE_WORDS: Final = {
    "coils": ("1", "5", "15", "coil", "coils", "0x", "do", "digital output", "bobine", "bobines"),
    "discrete_inputs": ("2", "discrete input", "discrete inputs", "discrete", "1x", "di", "digital input"),
    "holding_registers": ("3", "6", "16", "10", "holding register", "holding registers", "holding", "hr", "4x",
                          "analog output", "halteregister", "haltregister", "registre de maintien"),
    "input_registers": ("4", "input register", "input registers", "input", "ir", "3x", "analog input",
                        "eingangsregister", "inputregister", "registre d entree"),
}  # fmt: skip
AMONG: Final = (("holding", "holding_registers"), ("input reg", "input_registers"), ("coil", "coils"),
                ("discrete", "discrete_inputs"))  # fmt: skip
"""Words that name a space among others, as in `Read Holding Registers (03)`."""
ACCESS_WORDS: Final = {
    "ro": ("r", "ro", "rd", "read", "readonly", "lesen", "nurlesen", "l", "lecture", "lectureseule", "lettura",
           "solalettura", "lectura", "sololectura"),
    "wo": ("w", "wo", "wr", "write", "writeonly", "schreiben", "nurschreiben", "ecriture", "ecritureseule", "scrittura",
           "escritura"),
}  # fmt: skip


def space_of(text: str) -> str | None:
    """Return the space that a cell such as `FC03`, `R04`, `Holding Register`, `4xxxx` or `3/6/16` names first."""
    plain = re.sub(r"[^a-z0-9]+", " ", without_accents(text.casefold()).replace("fc", ""))
    words = re.sub(r"\b([0134])x+\b", r"\1x", plain).strip()
    among = next((space for word, space in AMONG if word in words), None)
    if among is not None:
        return among
    number = re.search(r"\d+", re.sub(r"\b0x", "", words))
    for candidate in (words, words.split(" ")[0].lstrip("0"), number[0].lstrip("0") if number else ""):
        for space, known in SPACE_WORDS.items():
            if candidate in known:
                return space
    return None


def access_of(text: str) -> str | None:
    """Return `ro` or `wo` for what a cell says; None for both directions, and for other words."""
    letters = re.sub(r"[^a-z]+", "", without_accents(text.casefold()))
    return next((access for access, known in ACCESS_WORDS.items() if letters in known), None)
