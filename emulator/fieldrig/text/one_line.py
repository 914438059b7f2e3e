"""Text from outside on one line of a terminal."""


def one_line(text: str) -> str:
    """Return the text with control characters as escapes, as they would move the cursor or change colours."""
    if text.isprintable():
        return text
    return "".join(sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text)
