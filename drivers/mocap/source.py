"""Source of frames that a configuration names."""

import importlib.util
from collections import Counter
from pathlib import Path
from typing import Protocol

from tendond.drivers.mocap.frames import Frame
from tendond.schemas.config.mocap import MocapSection
from tendond.schemas.config.rig import ConfigError
from tendond.schemas.config.vicon import ViconSection


class FrameSource(Protocol):
    """Source of frames.

    Attributes:
        counts: irregularities, by name.
        packets: all that came.
    """

    counts: Counter[str]
    packets: int

    def receive(self) -> Frame | None:
        """Return the next frame; none when none came for a moment."""

    def news(self) -> list[str]:
        """Return the lines for people since the last call."""

    def close(self) -> None:
        """Close the source."""


def open_source(section: ViconSection, folder: Path = Path()) -> FrameSource:
    """Open the source of frames of [mocap] or [vicon].

    Args:
        section: configuration.
        folder: of the configuration, to which names of files are relative.

    Raises:
        ConfigError: a library is not installed.
        ViconError: the address cannot be listened on.
        CameraError: the calibration cannot be used.
    """
    if objection := missing_library(section):
        raise ConfigError(objection)
    if section.reader == "udp":
        from tendond.drivers.vicon.udp import UdpSource

        return UdpSource(section)
    if section.reader == "sdk":
        from tendond.drivers.mocap.sdk import SdkSource

        return SdkSource(section)
    from tendond.drivers.apriltag.source import TagSource

    assert isinstance(section, MocapSection)
    return TagSource(section, folder)


def missing_library(section: ViconSection) -> str:
    """Return the line about a library that the section needs and that is not installed; empty if there is none."""
    if section.reader == "apriltag":
        if importlib.util.find_spec("cv2") is None:
            return f"{section.key}.system = 'apriltag' needs OpenCV (cv2): pip install 'tendond[apriltag]'"
    elif section.reader == "sdk" and importlib.util.find_spec("motioncapture") is None:
        of = "source = 'datastream'" if section.connection[0] == "vicon" else f"system = '{section.connection[0]}'"
        instead = f", or use {section.key}.source = 'udp'" if section.connection[0] == "vicon" else ""
        return f"{section.key}.{of} needs the motioncapture package: pip install 'tendond[vicon-sdk]'{instead}"
    return ""


def place_of(section: ViconSection) -> str:
    """Describe where the frames come from, for people."""
    if section.reader == "udp":
        return f"UDP port {section.port}"
    if isinstance(section, MocapSection):
        if section.reader == "apriltag":
            return f"tags in the pictures of {section.apriltag.video}"
        host, port = section.host_and_port
        return f"{section.station} at {host}:{port}"
    return f"DataStream server {section.server}"
