"""Text from outside on a terminal."""


def one_line(text: str) -> str:
    """Return the text with control characters as escapes, as they would move the cursor or change colours."""
    if text.isprintable():
        return text
    return "".join(sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text)


def without_controls(text: str) -> str:
    """Do the same with a text of several lines and columns, which stay."""
    if text.isprintable():
        return text
    return "".join(sign if sign in "\n\t" else one_line(sign) for sign in text)
