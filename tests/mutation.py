"""Mutate what decides about tension and see whether a test notices: `python -m tests.mutation [TARGET ...]`.

mutmut (https://mutmut.readthedocs.io) makes the mutants and picks, for each, the tests that reach it. It cannot follow
the links of `tendond/` to the folders, so it works on a copy in which they are folders. It is no requirement of the
tests: `.venv/bin/pip install mutmut` where it is wanted.

A mutant that no test kills is printed with its difference; the exit status is 1 where fewer than 90 % of a module's are
killed. mutmut leaves decorated functions alone: kernels of a module that is mutated are plain functions in the copy.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from tendond.model.numerics.compile import sources_digest

ROOT = Path(__file__).parents[1]
GOAL = 0.9


@dataclass(frozen=True)
class Target:
    """Modules, as paths in the package, and the tests that are asked about them."""

    modules: tuple[str, ...]
    tests: tuple[str, ...]


def _target(modules: str, tests: str) -> Target:
    return Target(tuple(f"{name}.py" for name in modules.split()), tuple(f"tests/{name}.py" for name in tests.split()))


TARGETS = {
    "actuation": _target(
        "daemon/control/actuation",
        "unit/control/test_actuation unit/reference/test_limits unit/reference/test_laws "
        "unit/control/test_cycle_direct unit/control/test_safe_command",
    ),
    "admission": _target(
        "daemon/control/phases/admission daemon/control/sources",
        "unit/control/test_admission_numbers unit/control/test_cycle_faults "
        "unit/control/test_cycle_tendon_faults "
        "unit/control/test_fault_table unit/control/test_missed_ticks "
        "unit/commissioning/test_refusals unit/control/test_sources unit/control/test_thresholds",
    ),
    "modes": _target(
        "daemon/control/phases/modes daemon/control/phases/faults",
        "unit/runtime/test_requests unit/control/test_cycle unit/control/test_cycle_faults "
        "unit/control/test_cycle_tendon_faults "
        "unit/control/test_fault_table unit/commissioning/test_refusals "
        "unit/control/test_sources unit/commissioning/test_probe",
    ),
    "cycle": _target(
        "daemon/control/cycle daemon/control/phases/decision daemon/control/phases/estimation "
        "daemon/control/phases/prediction daemon/control/tasks/plane",
        "unit/control/phases/test_command unit/control/phases/test_decision unit/control/phases/test_estimation "
        "unit/control/phases/test_law_state unit/control/phases/test_prediction "
        "unit/control/phases/test_prediction_faults unit/control/phases/test_prediction_probe",
    ),
    "observer": _target(
        "model/estimation/observer model/estimation/observer_gains model/estimation/compliance",
        "unit/model/test_observer_bounds unit/model/test_observer",
    ),
    "space": _target("daemon/control/tasks/space", "unit/control/phases/test_space"),
    "commissioning": _target(
        "daemon/control/commissioning/averages daemon/control/commissioning/probe "
        "daemon/control/commissioning/probe_advance daemon/control/commissioning/probe_plan "
        "daemon/control/commissioning/verdict",
        "unit/commissioning/test_commissioning_numbers unit/commissioning/test_probe_numbers "
        "unit/commissioning/test_probe_pulls "
        "unit/commissioning/test_probe_rest unit/commissioning/test_verdict_numbers",
    ),
    "rests": _target(
        "daemon/control/commissioning/mistakes daemon/control/commissioning/rest_check "
        "daemon/control/commissioning/rests daemon/control/commissioning/rest_grid "
        "daemon/control/commissioning/rotations",
        "unit/commissioning/rest/test_mistakes unit/commissioning/rest/test_rest_fit "
        "unit/commissioning/rest/test_rest_grid",
    ),
    "monitors": _target(
        "daemon/control/commissioning/tracking daemon/control/commissioning/swing "
        "daemon/control/commissioning/jump daemon/control/phases/monitors",
        "unit/commissioning/test_monitor_numbers unit/commissioning/test_report_numbers",
    ),
    "guard": _target(
        "drivers/dynamixel/driver/guard",
        "unit/drivers/test_servo_guard unit/drivers/test_servo_release unit/drivers/test_servo_limits",
    ),
}

SETTINGS = """\
[tool.pytest.ini_options]
markers = ["rig: real wires", "sil: real processes"]

[tool.mutmut]
source_paths = ["tendond"]
only_mutate = {modules}
pytest_add_cli_args_test_selection = {tests}
pytest_add_cli_args = ["-p", "no:cacheprovider", "-p", "no:xdist"]
also_copy = ["deploy", "docs", "examples", "README.md"]
track_dependencies = false
use_git_change_detection = false
"""


def prepare(folder: Path, target: Target) -> None:
    """Copy the project to `folder`, links as what they point to, kernels as Python, with mutmut's settings."""
    for name in ("tendond", "tests", "deploy", "docs", "examples"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("out"))
    shutil.copy(ROOT / "README.md", folder)
    modules = [f"tendond/{path}" for path in target.modules]
    for module in modules:
        path = folder / module
        path.write_text(re.sub(r"^@(kernel|inlined)\n", "", path.read_text(), flags=re.MULTILINE))
    # Kernels of other modules are those that are on the disk already.
    compiling = folder / "tendond/model/numerics/compile.py"
    text = compiling.read_text().replace("_SOURCES = sources_digest()", f"_SOURCES = {sources_digest()!r}")
    bound = "self.call = bind(self._compiled, *arguments)"  # a kernel as Python has nothing to bind
    assert bound in text
    text = text.replace(bound, f'{bound} if hasattr(self._compiled, "overloads") else self._compiled')
    compiling.write_text(text)
    (folder / "pyproject.toml").write_text(SETTINGS.format(modules=modules, tests=list(target.tests)))


def mutmut(folder: Path, *arguments: str) -> str:
    """Run mutmut in a prepared folder; what it says.

    Raises:
        SystemExit: it failed, with the end of what it said.
    """
    done = subprocess.run([sys.executable, "-m", "mutmut", *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit("\n".join((done.stdout + done.stderr).replace("\r", "\n").splitlines()[-15:]))
    return done.stdout


def verdicts(folder: Path) -> dict[str, str]:
    """Outcome of each mutant, by its name: killed, survived, timeout, no tests and so on."""
    lines = (line.strip().rpartition(": ") for line in mutmut(folder, "results", "--all", "true").splitlines())
    return {name: verdict for name, colon, verdict in lines if colon}


def difference(folder: Path, name: str) -> str:
    """The changed lines of a mutant."""
    lines = mutmut(folder, "show", name).splitlines()
    return "\n".join(f"    {line}" for line in lines if re.match(r"[-+](?!--|\+\+)", line))


def examine(name: str, target: Target, jobs: int, digits: str, without: list[str]) -> bool:
    """Run a target, or a sample of it, and print what became of it.

    Args:
        name: of the target. target: itself.
        jobs: mutants at once.
        digits: only mutants whose number ends in one of them; empty: all.
        without: tests to leave out.

    Returns:
        Whether the goal is met.
    """
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        prepare(folder, Target(target.modules, (*target.tests, *(f"--deselect={test}" for test in without))))
        mutmut(folder, "run", "--max-children", str(jobs), *(f"*{digit}" for digit in digits))
        found = {mutant: verdict for mutant, verdict in verdicts(folder).items() if verdict != "not checked"}
        counts = Counter(found.values())
        killed = counts["killed"] + counts["timeout"]
        print(f"{name}: {killed} of {len(found)} killed, {killed / len(found):.1%}", flush=True)
        for mutant, verdict in found.items():
            if verdict not in ("killed", "timeout"):
                print(f"  {verdict}: {mutant}\n{difference(folder, mutant)}")
    return killed >= GOAL * len(found)


def main(arguments: list[str] | None = None) -> int:
    """Run the targets that are named, or all; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"of {', '.join(TARGETS)} (default: all)")
    parser.add_argument("--jobs", type=int, default=1, help="mutants at once (default: 1)")
    parser.add_argument("--digits", default="", help="a sample: mutants whose number ends in one of them, as in 37")
    parser.add_argument("--deselect", action="append", default=[], metavar="TEST", help="leave a test out")
    options = parser.parse_args(arguments)
    if unknown := set(options.targets) - set(TARGETS):
        parser.error(f"no target is called {', '.join(sorted(unknown))}; choose of {', '.join(TARGETS)}")
    if find_spec("mutmut") is None:
        parser.error("mutmut is not installed: run '.venv/bin/pip install mutmut'")
    met = [
        examine(name, TARGETS[name], options.jobs, options.digits, options.deselect)
        for name in options.targets or TARGETS
    ]
    return 0 if all(met) else 1


if __name__ == "__main__":
    sys.exit(main())
