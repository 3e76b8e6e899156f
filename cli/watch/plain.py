"""The live view for a terminal that has no Unicode: each character of the drawing has one of ASCII in its place."""

from rich.text import Text

_LINES = {"┌": "+", "┐": "+", "└": "+", "┘": "+", "├": "|", "┤": "|", "─": "-", "│": "|", "▏": "|"}
_MARKS = {"▲": "^", "●": "o"}
_BLOCKS = {**dict.fromkeys("▎▍▌", "-"), **dict.fromkeys("▋▊▉█", "#")}
_SPARKS = dict(zip("▁▂▃▄▅▆▇", "_.:-=+*", strict=True))  # the eighth of them is the full block
_BRAILLE = {chr(0x2800 + bits): "." if bits.bit_count() < 3 else ":" for bits in range(1, 256)}
_TABLE = str.maketrans({**_LINES, **_MARKS, **_BLOCKS, **_SPARKS, **_BRAILLE, "…": "~"})


def plain(text: Text) -> Text:
    """The same in ASCII, as wide and in the same colours; what has no other form is a question mark."""
    copy = text.copy()
    copy.plain = text.plain.translate(_TABLE).encode("ascii", errors="replace").decode("ascii")
    return copy


def shown(text: Text, encoding: str) -> Text:
    """As it can be shown in an encoding: as it is, or plain."""
    try:
        "─●█⣿".encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return plain(text)
    return text
