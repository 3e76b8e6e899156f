"""Files of moving pictures: GIF and APNG by Pillow, MP4 by ffmpeg."""

import shutil
import subprocess
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.files import whole

Picture = NDArray[np.uint8]

SHADES = 7
"""Shades of a colour towards white in a GIF or APNG: edges of lines are soft, and the file stays small."""

NEARLY_WHITE = 238.0
"""Least of red, green and blue from which on a shade is left out: Pillow would take it for white."""

LAST_SECONDS = 1.0
"""Time for which the last picture stays before a GIF or APNG begins again [s]."""


def check_formats(formats: Iterable[str]) -> None:
    """Check that the programs for these formats are installed.

    Raises:
        UsageError: MP4 is among them, and there is no ffmpeg.
    """
    if "mp4" in formats and shutil.which("ffmpeg") is None:
        raise UsageError("MP4 needs ffmpeg, which is not installed: apt install ffmpeg, or take --format gif")


def write_movies(
    paths: Sequence[Path], pictures: Callable[[], Iterable[Picture]], colours: Iterable[str], rate: int
) -> None:
    """Write the same pictures into files, in the formats of their endings.

    Args:
        paths: files to write. pictures: makes them; is called once.
        colours: all of them, "#rrggbb", on white; of a GIF and an APNG. rate: pictures a second.

    Raises:
        DaemonError: ffmpeg fails. OSError: a file cannot be written.
    """
    stills: list[Image.Image] = []
    palette = _palette(colours)
    animated = [path for path in paths if path.suffix != ".mp4"]
    for path in animated:  # fails before the work, not after it
        _check_writable(path)
    encoders: list[tuple[Path, subprocess.Popen[bytes]]] = []
    try:
        for picture in pictures():
            if not encoders:
                encoders = [(path, _encoder(path, picture.shape, rate)) for path in paths if path.suffix == ".mp4"]
            if animated:
                stills.append(Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE))
            for _, encoder in encoders:
                assert encoder.stdin is not None
                encoder.stdin.write(picture.tobytes())
    except BrokenPipeError:
        pass  # the encoder says why
    except BaseException:
        for _, encoder in encoders:
            encoder.kill()
        raise
    for path, encoder in encoders:
        _, said = encoder.communicate()
        if encoder.returncode != 0:
            reason = said.decode(errors="replace").strip().splitlines() or ["no reason given"]
            raise DaemonError(f"{path}: ffmpeg failed: {reason[-1]}; --format gif needs no ffmpeg")
    for path in animated:
        stay = [round(1e3 / rate)] * (len(stills) - 1) + [round(1e3 * LAST_SECONDS)]
        form = "GIF" if path.suffix == ".gif" else "PNG"
        with whole(path) as draft:
            stills[0].save(
                draft, format=form, save_all=True, append_images=stills[1:], duration=stay, loop=0, optimize=False
            )


def _check_writable(path: Path) -> None:
    """Raise the OSError of a file that cannot be written; none is left behind."""
    existed = path.exists()
    path.open("ab").close()
    if not existed:
        path.unlink()


def _palette(colours: Iterable[str]) -> Image.Image:
    """Make a palette of the colours in shades towards white."""
    parts = np.linspace(0.0, 1.0, SHADES, endpoint=False)[:, None]
    given = [np.array([int(one[i : i + 2], 16) for i in (1, 3, 5)], dtype=float) for one in dict.fromkeys(colours)]
    shades = np.vstack([(1.0 - parts) * one + parts * 255.0 for one in given])
    shades = np.vstack([np.full((1, 3), 255.0), shades[shades.min(axis=1) < NEARLY_WHITE]])
    image = Image.new("P", (1, 1))
    image.putpalette(shades.round().astype(np.uint8)[:256].tobytes())
    return image


def _encoder(path: Path, shape: tuple[int, ...], rate: int) -> "subprocess.Popen[bytes]":
    """Start ffmpeg on raw pictures from a pipe; H.264 needs an even number of pixels."""
    height, width = shape[:2]
    return subprocess.Popen(
        [
            *("ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}"),
            *("-r", str(rate), "-i", "-", "-an", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"),
            *("-movflags", "+faststart", str(path)),
        ],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
