"""Where an extra is not installed, the commands that need it name it in one line before they begin."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tendond.cli.extras import EXTRAS, missing_line
from tendond.offline.demo.report import without_figures
from tests.golden.scripts import FOLDER

ROOT = Path(__file__).parents[3]
NORMAL = str(FOLDER / "normal.mcap")
ABSENT = "import sys\nsys.modules[sys.argv.pop(1)] = None\nfrom tendond.cli import main\nmain()"
"""A command line in an environment without a library."""

NEEDING = {
    "plot": ("matplotlib", ["plot", NORMAL, "--out", "OUT"]),
    "plot html": ("plotly", ["plot", NORMAL, "--out", "OUT", "--format", "html"]),
    "log compare": ("matplotlib", ["log", "compare", NORMAL, "--out", "OUT"]),
    "log report": ("matplotlib", ["log", "report", NORMAL, "--out", "OUT/page.html"]),
    "log smooth": ("matplotlib", ["log", "smooth", NORMAL, "--out", "OUT/table.csv"]),
    "log export": ("pyarrow", ["log", "export", NORMAL, "--out", "OUT/table.parquet"]),
    "log view": ("foxglove", ["log", "view", NORMAL, "--port", "0"]),
    "study paper": ("matplotlib", ["study", "paper", "--out", "OUT"]),
    "study robustness": ("matplotlib", ["study", "robustness", "--out", "OUT"]),
    "study robustness space": ("matplotlib", ["study", "robustness", "--points", "space", "--out", "OUT"]),
    "study robustness cluster": (
        "distributed",
        ["study", "robustness", "--out", "OUT", "--cluster", "tcp://127.0.0.1:1"],
    ),
    "study contact": ("matplotlib", ["study", "contact", "--out", "OUT"]),
    "identify": ("matplotlib", ["identify", NORMAL, "--out", "OUT"]),
    "identify demo": ("matplotlib", ["identify", "demo", "--out", "OUT"]),
    "validate": ("matplotlib", ["validate", "armlab", "--out", "OUT"]),
    "log export bag": ("rosbags", ["log", "export", NORMAL, "--rosbag2", "--out", "OUT/bag"]),
    "bridge ros2": ("rosbags", ["bridge", "ros2", "--config", "CONFIG"]),
    "simulate": ("mujoco", ["simulate", "--plant", "mujoco", "--config", "CONFIG"]),
    "config mjcf": ("mujoco", ["config", "mjcf", "--out", "OUT/robot.xml"]),
    "bench plants": ("mujoco", ["bench", "plants"]),
    "demo plant": ("mujoco", ["demo", "--plant", "mujoco", "--out", "OUT"]),
    "dashboard": ("tornado", ["dashboard", "--port", "0"]),
    "mocap calibrate": ("cv2", ["mocap", "calibrate", "OUT", "--square", "0.02", "--out", "OUT/camera.toml"]),
    "rig vicon": ("motioncapture", ["rig", "vicon", "--config", "CONFIG"]),
}
"""Command by name: the library that is missing, and the arguments."""


IMPORTED_AS = {"opencv-python-headless": "cv2", "python-can": "can"}
"""Import name of a package, where another is not obvious."""


def run(missing: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-c", ABSENT, missing, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=ROOT)


@pytest.mark.parametrize("name", NEEDING)
def test_a_command_names_the_extra_that_it_needs_and_the_command_that_installs_it(name: str, tmp_path: Path) -> None:
    library, arguments = NEEDING[name]
    config = tmp_path / "rig.toml"
    config.write_text('[vicon]\nsource = "datastream"\n')
    words = [one.replace("OUT", str(tmp_path / "out")).replace("CONFIG", str(config)) for one in arguments]
    ended = run(library, *words)
    line = ended.stderr.splitlines()[-1]
    assert "Traceback" not in ended.stderr
    assert ended.returncode in (1, 2)
    assert f"pip install 'tendond[{EXTRAS[library]}]'" in line, ended.stderr
    assert not list(tmp_path.glob("out/*")), "it had begun"


def test_the_extras_are_those_of_the_package() -> None:
    optional = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    declared: dict[str, set[str]] = {}
    for extra, requirements in optional.items():
        for requirement in requirements if extra != "dev" else ():
            package = re.split(r"[<>=]", requirement)[0]
            declared.setdefault(IMPORTED_AS.get(package, package).replace("-sdk", ""), set()).add(extra)
    named = {library.replace("-sdk", ""): extra for library, extra in EXTRAS.items()}
    assert named.keys() == declared.keys()
    assert all(extra in declared[library] for library, extra in named.items())


def test_a_library_of_no_extra_has_no_line() -> None:
    assert missing_line("tendond.nowhere") is None
    assert missing_line("matplotlib.figure") == (
        "this needs matplotlib, which is not installed: pip install 'tendond[plot]'"
    )


def test_a_demo_without_matplotlib_says_how_to_have_its_figures_later() -> None:
    words = without_figures(ModuleNotFoundError("no", name="matplotlib.figure"), Path("out/demo/demo.mcap"))
    assert words.endswith("pip install 'tendond[plot]', then tendond plot out/demo/demo.mcap")
    with pytest.raises(ModuleNotFoundError):
        without_figures(ModuleNotFoundError("no", name="numpy"), Path("demo.mcap"))
