"""The columns of a list of registers by what people call them, and the addresses as people write them."""

import re
from collections.abc import Mapping, Sequence
from typing import Final
from unicodedata import combining, normalize

from fieldrig_devices.sources.sheet import Sheet, sheet_of

HEADINGS: Final[Mapping[str, Sequence[str]]] = {
    "address": ("address", "addr", "modbus address", "register address", "reg address", "reg addr", "start address",
                "register", "reg", "register number", "start", "adresse", "register no", "address dec", "address hex",
                "start reg", "first register", "registeradresse", "registernummer", "registers", "register nr",
                "modbusadresse", "startadresse", "registre", "n registre", "indirizzo", "registro", "direccion"),
    "name": ("name", "parameter name", "signal name", "variable name", "parameter",
             "tag", "tag name", "signal", "variable", "point", "point name", "register name",
             "description", "beschreibung", "bezeichnung", "quantity name", "designation", "measurement", "benennung",
             "messwert", "messgrosse", "datenpunkt", "nom", "libelle", "parametre", "grandeur", "mesure", "nome",
             "parametro", "descrizione", "nombre", "descripcion"),
    "type": ("type", "data type", "datatype", "format", "data format", "datentyp", "encoding", "typ", "datenformat",
             "type de donnees", "tipo", "tipo dato", "tipo di dato", "tipo de dato", "formato"),
    "space": ("function", "function code", "fc", "table", "register type", "object type", "area", "space", "reg type",
              "funktionscode", "funktion", "registerart", "registertyp", "objekttyp", "fonction", "code fonction",
              "type de registre", "funzione", "codice funzione", "funcion", "codigo de funcion"),
    "bit": ("bit", "bit no", "bit number", "bit nr", "bit position"),
    "unit": ("unit", "units", "einheit", "uom", "engineering unit", "eng unit", "unite", "unita", "unita di misura",
             "unidad", "unidades"),
    "scale": ("scale", "scaling", "factor", "scale factor", "multiplier", "resolution", "faktor", "res", "auflosung",
              "skalierung", "multiplikator", "coefficient", "coef", "facteur", "echelle", "multiplicateur", "fattore",
              "scala", "moltiplicatore", "risoluzione", "escala", "multiplicador", "resolucion"),
    "divisor": ("divisor", "divider", "div", "gain", "teiler", "diviseur", "divisore"),
    "offset": ("offset",),
    "access": ("access", "r/w", "rw", "read/write", "r w", "mode", "zugriff", "action", "rd/wr", "lesen/schreiben",
               "zugriffsart", "acces", "lecture/ecriture", "l/e", "accesso", "lettura/scrittura", "acceso",
               "lectura/escritura"),
    "min": ("min", "minimum", "low", "lower limit", "minimo"),
    "max": ("max", "maximum", "high", "upper limit", "massimo", "maximo"),
    "initial": ("default", "default value", "initial", "initial value", "value", "wert", "standardwert",
                "voreinstellung", "werkseinstellung", "valeur par defaut", "valore predefinito", "valor por defecto"),
    "word_order": ("word order", "wordorder", "word swap", "register order", "wortreihenfolge", "ordre des mots"),
    "order": ("order", "byte order", "byteorder", "endian", "endianness", "endianess", "byte/word order", "swap",
              "bytereihenfolge", "ordre des octets", "ordine byte", "orden de bytes"),
    "values": ("values", "enum", "enumeration", "enum values", "states", "options", "value names", "value list",
               "possible values", "allowed values", "werte", "wertebereich", "zustande", "valeurs", "valori",
               "valores"),
    "length": ("length", "count", "size", "words", "registers", "quantity", "number of registers", "no of registers",
               "lange", "anzahl", "registeranzahl", "anzahl register", "longueur", "taille", "nombre de mots",
               "nombre de registres", "lunghezza", "longitud"),
    "about": ("about", "comment", "comments", "description", "remark", "remarks", "note", "notes", "details",
              "bemerkung", "kommentar", "hinweis", "anmerkung", "commentaire", "remarque", "commento", "comentario"),
}  # fmt: skip
"""The words in the line of names for each thing that a list says, the most certain ones first, without accents.

The makers of inverters give a gain, by which the value was multiplied to become a whole number.
"""
FEWEST: Final = 2
"""The columns that make a line that of the names: what says the address, and another one."""
MOST_TITLES: Final = 20
"""Lines above the names of the columns, such as the title of a device."""
LOOSE: Final = ("address", "name", "type", "unit", "scale", "access", "length")
"""Things that are also found as words among others, such as `Physical address` or `Start Reg (Hex)`."""
NOT_MEANT: Final = frozenset({"id", "slave", "unit id", "station"})
"""Words beside which `unit` and `address` are those of a device."""
BITS_OF_A_REGISTER: Final = 16
NUMBERED: Final = re.compile(r"([0134])(\d{4,5})(?!\d)")
HEX: Final = re.compile(r"[0-9a-f]{2,5}h?", re.IGNORECASE)


def columns_of(names: Sequence[str]) -> dict[str, int]:
    """Return the positions of the columns by what they say; a column says one thing."""
    words = [" ".join(re.sub(r"[^\w/]+|_", " ", without_accents(name)).split()).casefold() for name in names]
    found: dict[str, int] = {}
    for what, headings in HEADINGS.items():
        for heading in headings:
            place = next((place for place, word in enumerate(words) if word == heading), None)
            if place is not None and place not in found.values():
                found[what] = place
                break
    for what in LOOSE:
        if what not in found and (place := _among_others(words, HEADINGS[what], set(found.values()))) is not None:
            found[what] = place
    return found


def list_in(text: str) -> Sheet:
    """Return the rows of a list, below the first line that has the names of columns.  ValueError if none has them."""
    head, first = text, None
    for line in range(MOST_TITLES):
        try:
            sheet = sheet_of(head)
        except ValueError:
            if first is None:
                raise
            break
        found = columns_of(sheet.names)
        if "address" in found and (len(found) >= FEWEST or line == 0):
            return sheet._replace(lines=[number + line for number in sheet.lines])
        first = sheet if first is None else first
        head = head.partition("\n")[2]
    names = [] if first is None else [name for name in first.names if name]
    raise ValueError(f"expected a column such as `address`, got {', '.join(names)}")


def without_accents(text: str) -> str:
    return "".join(letter for letter in normalize("NFKD", text.replace("ß", "ss")) if not combining(letter))


def _among_others(words: Sequence[str], headings: Sequence[str], taken: set[int]) -> int | None:
    for heading in headings:
        for place, word in enumerate(words):
            if place not in taken and f" {heading} " in f" {word} " and not NOT_MEANT & set(word.split()):
                return place
    return None


def is_in_hex(heading: str, cells: Sequence[str]) -> bool:
    """True if a column has hexadecimal numbers without a mark: by its heading, or as some have letters."""
    known = [cell.strip() for cell in cells if cell.strip()]
    if not known or not all(HEX.fullmatch(cell) for cell in known):
        return False
    return "hex" in heading.casefold() or any(re.search("[a-f]", cell.rstrip("hH"), re.IGNORECASE) for cell in known)


def address_in(text: str, *, is_hex: bool = False) -> int | None:
    """Return the first number of an address such as `100`, `0x64`, `64h`, `40,001` or `100-101`."""
    plain = text.strip().lower()
    if is_hex:
        return int(plain.rstrip("h"), 16) if HEX.fullmatch(plain) else None
    plain = re.sub(r"(?<=\d),(?=\d{3}(?!\d))", "", plain)
    match = re.fullmatch(r"(?:0x([0-9a-f]{1,5})|([0-9a-f]{1,5})h|(\d{1,6}))(?:\s*[-–:.…]+\s*\w+)?", plain)
    if match is None:
        return None
    digits = match[1] or match[2]
    return int(match[3]) if digits is None else int(digits, 16)


def bit_in(bit: str, address: str) -> int | None:
    """Return the bit that a row is about, by its column or by an address such as `40001.3`; None for a whole value."""
    dotted = re.fullmatch(r"\w+\.(\d{1,2})", address.strip())
    text = bit.strip() or (dotted[1] if dotted else "")
    return int(text) if text.isdecimal() and int(text) < BITS_OF_A_REGISTER else None


def is_numbered_list(cells: Sequence[tuple[str, bool]]) -> bool:
    """True if all addresses are numbers such as 40001 or 300001, with the digit of the space in front.

    Each address has with it whether it is one of a bit: the zeros in front of a coil's may be lost.
    """
    known = [(text.replace(",", ""), is_bit) for text, is_bit in cells if address_in(text) is not None]
    numbers = [(NUMBERED.match(text), text, is_bit) for text, is_bit in known]
    if not any(number for number, _, _ in numbers):
        return False
    return all(
        int(number[2]) > 0 if number is not None else is_bit and 0 < (address_in(text) or 0) < 10_000
        for number, text, is_bit in numbers
    )
