"""A source distribution, unpacked, installed below a folder, looked at by systemd's own tools, and removed again."""

import json
import os
import re
import shutil
import socket
import subprocess
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond import __version__
from tendond.cli.include import parse_with_includes
from tendond.schemas.config.rig import parse_config
from tests.deploy.installation import ROOT, Installation, build_and_install, tool
from tests.rig.tracker import free_port

SERVICES = ("tendond-controller@bench.service", "tendond-vicon@bench.service", "tendond-servo@bench.service")
EXPOSURE_MAX = 2.0
"""Maximum exposure of a service by `systemd-analyze security`, from 0 (sealed off) to 10."""

UDEV_TOKEN = re.compile(r'[A-Z_]+(\{[\w/]+\})?(==|!=|=|\+=|:=)"[^"]*"')


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Installation]:
    folder = tmp_path_factory.mktemp("install")
    yield build_and_install(folder)
    shutil.rmtree(folder)  # half a gigabyte


def test_both_distributions_have_what_they_need(installed: Installation) -> None:
    names = zipfile.ZipFile(installed.wheel).namelist()
    assert {"tendond/py.typed", "tendond/bus/systemd.py", "tendond/cli/app.py"} <= set(names)
    assert {name.partition("/")[0] for name in names} == {"tendond", f"tendond-{__version__}.dist-info"}
    for needed in ("LICENSE", "requirements.txt", "deploy/install", "deploy/rig.toml", "deploy/bus/controller.json5"):
        assert (installed.source / needed).is_file(), needed
    assert os.access(installed.source / "deploy" / "install", os.X_OK)


def test_it_runs_with_the_versions_that_are_pinned(installed: Installation) -> None:
    assert installed.tendond("--version").stdout == f"tendond {__version__}\n"
    code = (
        "import importlib.metadata as m, pkgutil, importlib, tendond\n"
        "from tendond.cli.extras import EXTRAS\n"
        "assert m.version('tendond') == tendond.__version__\n"
        "for one in pkgutil.walk_packages(tendond.__path__, 'tendond.'):\n"
        "    if '__main__' not in one.name and not one.name.startswith('tendond.cli.manual.'):\n"  # needs mkdocs
        "        try:\n"
        "            importlib.import_module(one.name)\n"
        "        except ModuleNotFoundError as error:\n"  # of an extra that is not installed with the services
        "            assert EXTRAS.get(error.name.partition('.')[0], 'plot') != 'plot', error\n"
        'print(*(f\'{d.name.lower().replace("_", "-")}=={d.version}\' for d in m.distributions()))\n'
    )
    python = str(installed.root / "opt/tendond/bin/python")
    result = subprocess.run([python, "-P", "-c", code], capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    pinned = set(re.findall(r"^\S+==\S+", (ROOT / "requirements.txt").read_text(), re.M))
    assert set(result.stdout.split()) - {f"tendond=={__version__}"} - pinned <= {
        word for word in result.stdout.split() if word.startswith("pip==")
    }


def test_the_doctor_examines_the_new_rig(installed: Installation, tmp_path: Path) -> None:
    file = installed.root / "etc/tendond/bench/rig.toml"
    text = file.read_text()
    assert parse_config(text, "rig.toml").rig.name == "bench"
    other = parse_config((installed.root / "etc/tendond/arm/rig.toml").read_text(), "rig.toml")
    assert other.bus.endpoint != parse_config(text, "rig.toml").bus.endpoint
    own = tmp_path / "rig.toml"
    own.write_text(text.replace("7460", str(free_port(socket.SOCK_STREAM))))
    result = installed.tendond("doctor", "--json", "-c", str(own), "--log", str(tmp_path))
    report = json.loads(result.stdout)
    assert result.returncode == 0, report
    assert report["rig"] == "bench"
    assert "is free" in next(line["finding"] for line in report["checks"] if line["check"] == "controller")


def test_the_example_that_is_installed_works_as_its_comments_say(installed: Installation) -> None:
    text = (installed.root / "etc/tendond/bench/rig.toml").read_text()
    assert "[vicon] or [servo], which may be empty" in text
    config = parse_config(f"{text}\n[vicon]\n[servo]\n", "rig.toml")
    assert config.vicon is not None
    assert config.servo is not None


SERVOS_CAN = "limits = {displacement_min = -0.05, displacement_max = 0.05, displacement_rate = 0.05}\n"
SPELLINGS = {
    "[{}]\n": True,
    "[ {} ]\n": True,
    "\t[{}]  # ours\n": True,
    "{}.{key}\n": True,
    "{} = {{}}\n": True,
    '["{}"]\n': True,
    'include = ["other.toml"]\n': True,
    "# [{}]\n": False,
    'rig.name = "{}"\n': False,
}


@pytest.mark.parametrize(("section", "key"), [("vicon", 'tip = "a"'), ("servo", 'port = "/dev/x"')])
def test_units_ask_the_program_whether_a_driver_has_its_section_however_it_is_spelled(
    installed: Installation, tmp_path: Path, section: str, key: str
) -> None:
    unit = (installed.root / f"usr/local/lib/systemd/system/tendond-{section}@.service").read_text()
    (condition,) = re.findall(r"^ExecCondition=/opt/tendond/bin/tendond (.*)$", unit, re.M)
    file = tmp_path / "rig.toml"
    command = condition.replace("/etc/tendond/%i/rig.toml", str(file)).split()
    (tmp_path / "other.toml").write_text(f"[{section}]\n")
    for spelling, has in SPELLINGS.items():
        file.write_text(SERVOS_CAN + spelling.format(section, key=key))
        assert installed.tendond(*command).returncode == (0 if has else 1), spelling
        found = parse_with_includes(file.read_text(), file)
        assert (getattr(found, section) is not None) is has, spelling
    file.write_text("[rig")
    assert installed.tendond(*command).returncode == 0  # the driver says what is wrong, and ends with 2
    assert installed.tendond("config", "has", section, str(file)).returncode == 2


def test_systemd_has_nothing_to_say_of_the_units(installed: Installation) -> None:
    """Verified on a system of its own units and these, so that the program that they start is there."""
    analyze = tool("systemd-analyze", "systemd")
    base = next(folder for folder in (Path("/usr/lib/systemd/system"), Path("/lib/systemd/system")) if folder.is_dir())
    shutil.copytree(base, installed.root / "usr/lib/systemd/system", symlinks=True, dirs_exist_ok=True)
    copy = installed.root / "bin/sh"
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy("/bin/sh", copy)
    command = [analyze, "verify", "--man=no", f"--root={installed.root}", "tendond@bench.target", *SERVICES]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    broken = installed.root / "usr/local/lib/systemd/system/tendond-vicon@.service"
    text = broken.read_text()
    broken.write_text(text.replace("WatchdogSec=5", "WatchdogSec=soon"))
    try:  # else the silence above would say nothing
        assert "sec value" in subprocess.run(command, capture_output=True, text=True, timeout=60).stderr
    finally:
        broken.write_text(text)


@pytest.mark.parametrize("service", SERVICES)
def test_services_are_sealed_off(installed: Installation, service: str, tmp_path: Path) -> None:
    analyze = tool("systemd-analyze", "systemd")
    unit = tmp_path / service
    shutil.copy(installed.root / "usr/local/lib/systemd/system" / service.replace("bench", ""), unit)
    command = [analyze, "security", "--offline=true", f"--threshold={EXPOSURE_MAX * 10:.0f}", str(unit)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    exposure = re.search(r"exposure level for \S+: ([0-9.]+)", result.stdout)
    assert exposure is not None, result.stderr
    assert float(exposure[1]) <= EXPOSURE_MAX, result.stdout


def test_a_restart_never_arms(installed: Installation) -> None:
    for service in SERVICES:
        text = (installed.root / "usr/local/lib/systemd/system" / service.replace("bench", "")).read_text()
        settings = [line for line in text.splitlines() if re.match(r"[A-Z]\w+=", line)]
        assert {"Type=notify", "WatchdogSec=5", "Restart=on-failure", "NoNewPrivileges=yes"} <= set(settings)
        assert {"RestartPreventExitStatus=2", "StartLimitBurst=20", "StartLimitIntervalSec=300"} <= set(settings)
        assert not [line for line in settings if line.startswith("Exec") and "arm" in line.split()]


def test_shell_and_udev_rules_are_well_formed(installed: Installation) -> None:
    result = subprocess.run(
        [tool("shellcheck", "shellcheck"), str(ROOT / "deploy/install"), str(ROOT / ".ci/run")], capture_output=True
    )
    assert result.returncode == 0, result.stdout
    rules = (installed.root / "usr/local/lib/udev/rules.d/70-tendond.rules").read_text().splitlines()
    for line in rules:
        for token in [] if line.startswith("#") else line.split(", "):
            assert UDEV_TOKEN.fullmatch(token), token


def test_installed_again_it_keeps_the_configuration_and_removed_it_leaves_configuration_and_logs(
    installed: Installation,
) -> None:
    file = installed.root / "etc/tendond/bench/rig.toml"
    file.write_text(file.read_text() + "# mine\n")
    log = installed.root / "var/log/tendond/run.mcap"
    log.write_text("precious")
    other = installed.root / "etc/tendond/arm/rig.toml"
    other.write_text(other.read_text() + "\n[rod]\nlenght = 0.4\n")
    result = installed.install()
    assert result.returncode == 0
    unknown = r"install: REFUSED: tendond: \S*arm/rig\.toml:\d+: rod\.lenght: unknown key; did you mean 'length'\?"
    assert re.search(unknown, result.stdout), result.stdout
    assert "change them, then check again with tendond config check FILE" in result.stdout
    assert re.search(r"install: note: \S*bench/rig\.toml: OK", result.stdout)
    assert file.read_text().endswith("# mine\n")
    assert installed.tendond("--version").returncode == 0
    assert installed.run("uninstall").returncode == 0
    assert file.exists()
    assert log.exists()
    assert not (installed.root / "opt/tendond").exists()
    assert not list((installed.root / "usr/local").rglob("*tendond*"))
    assert installed.run("uninstall", "--purge").returncode == 0
    assert not file.exists()
    assert not log.exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--rig", "Upper Case"), "--rig"),
        (("--prefix", "relative"), "absolute"),
        (("--rig",), "needs a value"),
        (("--nonsense",), "unknown"),
        (("--python", "no-such-python"), "no-such-python"),
    ],
)
def test_what_cannot_be_installed_is_refused_in_one_line(
    installed: Installation, arguments: tuple[str, ...], said: str
) -> None:
    result = installed.run(*arguments)
    assert result.returncode in {1, 2}
    assert said in result.stderr
    assert result.stderr.count("\n") == 1
