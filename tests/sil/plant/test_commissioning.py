"""`tendond doctor` against real processes: the rest is compared, and with --probe the tendons are pulled a little."""

import subprocess
from collections.abc import Iterator

import pytest
import zenoh

from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.sil.rig import Rig, rig

pytestmark = pytest.mark.sil

SWAPPED = "[simulator.rod]\ntendon_positions = [[-0.02, 0.0], [0.0, 0.02], [0.02, 0.0], [0.0, -0.02]]\n"


@pytest.fixture(scope="module")
def controlled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Rig, zenoh.Session]]:
    """Yield a rig with a controller, whose tests start the simulator."""
    with rig(tmp_path_factory.mktemp("commissioning")) as one:
        controller = one.controller()
        with one.session() as session:
            yield one, session
        assert one.end(controller)[0] == 0


def simulated(one: Rig, session: zenoh.Session, extra: str) -> "subprocess.Popen[str]":
    """Start a simulator with more of the configuration; return it once the arm has rested for a second."""
    text = one.config.read_text()
    one.config.write_text(text + extra)
    simulator = one.start("simulate")
    tip = one.status(session).tip
    one.until(session, lambda status: status.tip is not None and status.tip != tip)
    one.config.write_text(text)
    one.pass_ticks(session, 100)
    return simulator


@pytest.mark.parametrize(("extra", "status", "words"), [("", 0, "as the model says"), (SWAPPED, 1, "0 and 2 swapped")])
def test_the_doctor_probes_the_tendons_on_request(
    controlled: tuple[Rig, zenoh.Session], extra: str, status: int, words: str
) -> None:
    one, session = controlled
    simulator = simulated(one, session, extra)
    found = one.command("doctor", "--probe", "--no-servos")
    lines = {line[6:20].strip(): line for line in found.stdout.splitlines()}
    assert lines["rest"].startswith("pass")
    assert words in lines["tendons"]
    assert lines["tendons"].startswith("pass" if status == 0 else "fail")
    assert (found.returncode != 0) == (status != 0)
    one.end(simulator)
    one.until(session, lambda s: one.ask(session, ControlAction.RESET).done or s.mode is Mode.IDLE)
