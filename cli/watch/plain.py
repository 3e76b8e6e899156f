"""Live view for a terminal without Unicode: each character of the drawing is replaced by an ASCII one."""

from rich.text import Text

_LINES = {"┌": "+", "┐": "+", "└": "+", "┘": "+", "├": "|", "┤": "|", "─": "-", "│": "|", "▏": "|"}
_MARKS = {"▲": "^", "●": "o"}
_BLOCKS = {**dict.fromkeys("▎▍▌", "-"), **dict.fromkeys("▋▊▉█", "#")}
_SPARKS = dict(zip("▁▂▃▄▅▆▇", "_.:-=+*", strict=True))  # the eighth of them is the full block
_BRAILLE = {chr(0x2800 + bits): "." if bits.bit_count() < 3 else ":" for bits in range(1, 256)}
_TABLE = str.maketrans({**_LINES, **_MARKS, **_BLOCKS, **_SPARKS, **_BRAILLE, "…": "~"})


def plain(text: Text) -> Text:
    """Convert to ASCII of the same width and colours; unknown characters become question marks."""
    copy = text.copy()
    copy.plain = text.plain.translate(_TABLE).encode("ascii", errors="replace").decode("ascii")
    return copy


def shown(text: Text, encoding: str) -> Text:
    """Convert to ASCII if the encoding cannot show the drawing."""
    try:
        "─●█⣿".encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return plain(text)
    return text
