"""Files of the page; and the page with one frame in it, as a file of its own, for a picture."""

import json
import re
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parent / "page"
FILES = {
    "": ("index.html", "text/html"),
    "style.css": ("style.css", "text/css"),
    "scene.js": ("scene.js", "text/javascript"),
    "panels.js": ("panels.js", "text/javascript"),
    "page.js": ("page.js", "text/javascript"),
}
"""Files by path, with their type: nothing else is served."""

STYLE = '<link rel="stylesheet" href="style.css">'
SCRIPT = re.compile(r'<script src="([a-z]+\.js)"></script>')


def still(welcome: dict[str, Any], frames: list[str]) -> str:
    """Return the page as one file that shows frames and connects to nothing.

    Args:
        welcome: what the server says first.
        frames: as JSON, the oldest first; the last one stays.
    """
    html = _text("index.html").replace(STYLE, f"<style>{_text('style.css')}</style>")
    html = SCRIPT.sub(lambda found: f"<script>{_text(found[1])}</script>", html)
    shown = "".join(f"show({frame});" for frame in frames).replace("</", "<\\/")  # no end of the script within
    return html.replace("</body>", f"<script>welcome({json.dumps(welcome)});{shown}</script></body>")


def _text(name: str) -> str:
    return (PAGE / name).read_text(encoding="utf-8")
