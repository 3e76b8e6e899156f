"""The controller notifies its supervisor, on a real notify socket."""

import os
import resource
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pytest

from tendond.bus.systemd import Supervisor
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.loop import Loop
from tendond.daemon.runtime.pacing import Wake
from tendond.schemas.config.rig import check_config
from tendond.schemas.messages import Mode
from tests.sil.rig import Rig, rig
from tests.sil.supervision import PING, WATCHDOG_SECONDS, Manager

pytestmark = pytest.mark.sil


def test_a_run_from_ready_to_stopping(tmp_path: Path, manager: Manager, monkeypatch: pytest.MonkeyPatch) -> None:
    manager.in_charge(monkeypatch)
    with rig(tmp_path) as one:
        controller = one.controller()
        manager.await_line("READY=1")
        assert [line for line in manager.received if line != PING][:1] == ["READY=1"]  # nothing before it
        with one.session() as session:
            assert one.status(session).mode is Mode.IDLE  # it was not notified too early: the bus is open
            monkeypatch.delenv("NOTIFY_SOCKET")
            one.start("simulate")
            one.arm(session)
            manager.await_line("STATUS=tracking")
            manager.await_line("STATUS=pretension")
            manager.hear(2.0 * WATCHDOG_SECONDS)
            code, _ = one.end(controller)  # while it tracks: the tendons are released first
        assert code == 0
        manager.hear(0.2)
        end = [line for line in manager.received if line != PING]
        assert end.count("STOPPING=1") == 1
        assert end.index("STOPPING=1") < max(i for i, line in enumerate(end) if line.startswith("STATUS=releasing"))


@dataclass(frozen=True)
class Supervised:
    """Controller under a manager, shared by tests; the last of them ends it."""

    rig: Rig
    controller: "subprocess.Popen[str]"
    manager: Manager


@pytest.fixture(scope="module")
def supervised(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Supervised]:
    folder = tmp_path_factory.mktemp("supervised")
    with pytest.MonkeyPatch.context() as patch, closing(Manager(folder)) as manager, rig(folder) as one:
        manager.in_charge(patch)
        controller = one.controller()
        manager.await_line(PING)
        yield Supervised(one, controller, manager)


def test_signs_of_life_come_at_half_the_watchdogs_time_and_not_from_a_stopped_process(supervised: Supervised) -> None:
    manager, controller = supervised.manager, supervised.controller
    heard = manager.hear(5.0 * WATCHDOG_SECONDS)
    assert 1 <= heard.count(PING) <= 11  # up to two in each of its periods, however many cycles there are
    controller.send_signal(signal.SIGSTOP)
    time.sleep(0.2)
    assert manager.hear(3.0 * WATCHDOG_SECONDS) == []
    controller.send_signal(signal.SIGCONT)
    manager.await_line(PING, len(manager.received))


def test_a_full_disk_is_reported_and_does_not_end_the_signs_of_life(supervised: Supervised) -> None:
    manager, controller = supervised.manager, supervised.controller
    resource.prlimit(controller.pid, resource.RLIMIT_FSIZE, (1, resource.RLIM_INFINITY))
    deadline = time.monotonic() + 60.0
    while not any("the log ended" in line for line in manager.hear(0.05)):
        assert time.monotonic() < deadline
    manager.await_line(PING, len(manager.received))
    assert supervised.rig.end(controller)[0] == 1


def test_a_loop_that_is_always_late_gives_no_sign_of_life(tmp_path: Path, manager: Manager) -> None:
    one = Rig(tmp_path)
    period = 0.1
    config = check_config(
        {"rig": {"name": one.name}, "bus": {"endpoint": one.endpoint}, "loop": {"period": period}}, "test"
    )
    setup = CycleSetup.from_config(config)
    late = [(0.0, 1), (0.0, 3), (1.5 * period, 0)] * 5  # after missed deadlines, or woken after the next one

    class Pacer:
        def __init__(self, wakes: list[tuple[float, int]]) -> None:
            self._wakes = iter(wakes)

        def wait(self) -> Wake | None:
            lateness, missed = next(self._wakes, (0.0, -1))
            return None if missed < 0 else Wake(time.monotonic(), Arrivals(), lateness, missed)

    manager.listen()
    for number, (wakes, alive) in enumerate(((late, False), ([(0.0, 0)] * 5, True))):
        log = tmp_path / f"{number}.mcap"
        before = len(manager.received)
        with Hub(config) as hub, RunLog(log, config, setup.rod) as run_log:
            loop = Loop(setup, hub, run_log, supervisor=manager.supervisor())
            loop.run(loop.warm(), Pacer(wakes), lambda: False)
        manager.await_line("STOPPING=1", before)
        assert (PING in manager.received[before:]) is alive


def test_a_socket_that_is_gone_disturbs_nobody(tmp_path: Path) -> None:
    supervisor = Supervisor({"NOTIFY_SOCKET": str(tmp_path / "gone"), "WATCHDOG_USEC": "1000"})
    supervisor.ready("here")
    supervisor.alive()
    supervisor.stopping()


def test_another_processs_watchdog_is_not_fed(manager: Manager) -> None:
    manager.listen()
    manager.supervisor(WATCHDOG_PID="1").alive()
    manager.supervisor(WATCHDOG_PID=str(os.getpid())).status("mine")
    manager.await_line("STATUS=mine")
    assert manager.received == ["STATUS=mine"]
    manager.supervisor(WATCHDOG_PID=str(os.getpid())).alive()
    manager.await_line(PING)


def test_a_supervisor_that_does_not_read_never_makes_the_loop_wait(manager: Manager) -> None:
    supervisor = manager.supervisor()
    for number in range(5000):  # far more than the socket's queue holds
        supervisor.status(f"line {number}\nof two")
    manager.listen()
    manager.await_line("STATUS=line 0; of two")
    supervisor.alive()  # what was lost is said again as soon as there is room
    manager.await_line("STATUS=line 4999; of two")
    assert len(manager.received) < 2500
