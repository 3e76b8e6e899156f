"""Completion in bash: the function that bash calls, through the program's protocol, without the model's kernels."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tendond.cli import completion
from tendond.daemon.control.laws import LAWS
from tendond.daemon.control.laws.registry import GROUP
from tendond.daemon.control.tuning.keys import tunable_keys
from tendond.drivers.simulator.rods import PLANTS
from tendond.offline.demo.scenarios import SCENARIOS
from tendond.schemas.config.rig import RigConfig

BREAKS = "="
"""Characters that end a word in bash, of those in the lines below."""

PROGRAM = Path(sys.executable).with_name("tendond")


def words_of(line: str) -> list[str]:
    """Split a line as bash does for a completion: '=' is a word of its own."""
    found = []
    for word in line.split(" "):
        found += [part for part in word.partition(BREAKS) if part] or [""]
    return found


def completed(line: str, folder: Path) -> list[str]:
    """Complete the last word of a line in bash, with the script that the program installs."""
    if (bash := shutil.which("bash")) is None:
        pytest.skip("there is no bash")
    quiet = {**os.environ, "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    script = subprocess.run(
        [str(PROGRAM), "--show-completion", "bash"], env=quiet, capture_output=True, text=True, check=True
    ).stdout
    words = words_of(line)
    array = " ".join(f"'{word}'" for word in words)
    code = f"{script}\nCOMP_WORDS=({array}); COMP_CWORD={len(words) - 1}\n_tendond_completion '{PROGRAM}'\n"
    code += 'printf "%s\\n" "${COMPREPLY[@]}"'
    found = subprocess.run([bash, "-c", code], cwd=folder, capture_output=True, text=True)
    assert found.stderr == ""
    return found.stdout.split()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a rig, another TOML file, a log, and logs in the folder of `run`."""
    (tmp_path / "rig.toml").write_text('[rig]\nname = "bench"\n')
    (tmp_path / "pyproject.toml").write_text("[build-system]\nrequires = []\n")
    (tmp_path / "broken.toml").write_text("[rig\n")
    (tmp_path / "run.mcap").write_bytes(b"")
    (tmp_path / "log").mkdir()
    (tmp_path / "log" / "bench-1.mcap").write_bytes(b"")
    return tmp_path


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("tendond rig reference acr", {"across="}),
        ("tendond rig reference kind", {"kind=exponential", "kind=minimum_jerk", "kind=circle"}),
        ("tendond rig reference kind=", {"exponential", "minimum_jerk", "circle"}),
        ("tendond rig reference kind=fig", {"figure_eight"}),
        ("tendond rig reference across=0.3 dur", {"duration=1.0"}),
        ("tendond rig teach play path.csv mov", {"moved_max=0.02"}),
        ("tendond log what-if run.mcap --set control.law", {"control.law=mpc"}),
        ("tendond log what-if run.mcap --set limits.tension_m", {"limits.tension_max=60.0"}),
        ("tendond log what-if run.mcap --law ", set(completion.BUILT_IN_LAWS)),
        ("tendond rig law sen", {"sensitivity"}),
        ("tendond set limits.tension_m", {"limits.tension_max=60.0"}),
        ("tendond set control.laws.b", {f"control.laws.{key}" for key in completion.LAW_GAINS if key[0] == "b"}),
        ("tendond study robustness --law sl", {"sliding_mode"}),
        ("tendond study stability --robot rao", {"rao-2021"}),
        ("tendond config show --preset fra", {"franka-tdcr-v4"}),
        ("tendond demo --scenario sp", {"spatial"}),
        ("tendond run --profile na", {"nasty"}),
        ("tendond run --config ", {"rig.toml"}),
        ("tendond config check r", {"rig.toml"}),
        ("tendond plot ", {"run.mcap", "log/bench-1.mcap"}),
        ("tendond log compare run.mcap log/", {"log/bench-1.mcap"}),
        ("tendond identify fit r", {"run.mcap"}),
        ("tendond config has vi", {"vicon"}),
    ],
)
def test_bash_completes(line: str, expected: set[str], folder: Path) -> None:
    found = set(completed(line, folder))
    assert found >= expected, found
    if line.endswith((" --config ", " check r", "plot ")):
        assert found == expected  # another TOML file is no rig
    last = words_of(line)[-1].removeprefix("=")
    assert all(one.startswith(last) for one in found)


@pytest.mark.parametrize(
    "line",
    [
        "tendond rig law ",
        "tendond set ",
        "tendond rig reference ",
        "tendond plot ",
        "tendond log what-if a --set l",
    ],
)
def test_completion_imports_no_kernel(line: str, folder: Path) -> None:
    code = (
        "import sys, atexit; sys.argv = ['tendond']\n"
        "from tendond.cli import main\n"
        "try: main()\n"
        "finally: print([name for name in ('numba', 'numpy', 'scipy', 'zenoh') if name in sys.modules], "
        "file=sys.stderr)"
    )
    words = line.split(" ")
    environment = {**os.environ, "_TENDOND_COMPLETE": "complete_bash", "COMP_WORDS": line}
    environment["COMP_CWORD"] = str(len(words) - 1)
    found = subprocess.run([sys.executable, "-c", code], env=environment, cwd=folder, capture_output=True, text=True)
    assert found.stdout.split()
    assert found.stderr == "[]\n"


def test_the_names_that_are_repeated_for_completion_are_those_of_the_program() -> None:
    assert tuple(LAWS)[: len(completion.BUILT_IN_LAWS)] == completion.BUILT_IN_LAWS
    assert set(completion.laws()) == set(LAWS)
    assert tuple(SCENARIOS) == completion.SCENARIOS
    assert PLANTS == completion.PLANTS
    assert completion.LAW_GROUP == GROUP
    keys = tunable_keys(RigConfig()).values()
    gains = {f"{key.law}.{key.name}={key.configured}" for key in keys if key.law in completion.BUILT_IN_LAWS}
    assert gains == set(completion.LAW_GAINS)
