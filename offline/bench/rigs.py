"""Processes and configurations of the benchmarks that run a rig, and a row of their tables."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tendond.offline.bench.bare import Quantiles
from tendond.offline.processes import END_SECONDS, free_port

RIG = "bench"


@dataclass(frozen=True)
class PunctualityRow:
    """One thing measured [us], and its bare counterpart, if there is one."""

    name: str
    controller: Quantiles
    bare: Quantiles | None = None
    note: str = ""


@contextmanager
def process(*arguments: str) -> "Iterator[subprocess.Popen[str]]":
    """A process of ours, ended with the block."""
    process = subprocess.Popen(
        [sys.executable, "-m", *arguments], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            process.send_signal(signal.SIGCONT)
        try:
            process.communicate(timeout=END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


def configure(folder: Path, name: str, extra: str) -> tuple[Path, Path, str]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config = folder / f"{name}.toml"
    config.write_text(f'{extra}\n[rig]\nname = "{RIG}"\n[bus]\nendpoint = "{endpoint}"\n', encoding="utf-8")
    return config, folder / f"{name}.mcap", endpoint
