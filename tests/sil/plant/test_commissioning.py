"""`tendond doctor` against real processes: the rest is compared, and with --probe the tendons are pulled a little."""

import time
from pathlib import Path

import pytest

from tests.sil.rig import rig

SWAPPED = "[simulator.rod]\ntendon_positions = [[-0.02, 0.0], [0.0, 0.02], [0.02, 0.0], [0.0, -0.02]]\n"


@pytest.mark.parametrize(("extra", "status", "words"), [("", 0, "as the model says"), (SWAPPED, 1, "0 and 2 swapped")])
def test_the_doctor_probes_the_tendons_on_request(tmp_path: Path, extra: str, status: int, words: str) -> None:
    with rig(tmp_path, extra) as one:
        controller, _ = one.controller(), one.start("simulate")
        with one.session() as session:
            one.until(session, lambda s: s.tip is not None)
            time.sleep(1.0)
            found = one.command("doctor", "--probe", "--no-servos")
        lines = {line[6:20].strip(): line for line in found.stdout.splitlines()}
        assert lines["rest"].startswith("pass")
        assert words in lines["tendons"]
        assert lines["tendons"].startswith("pass" if status == 0 else "fail")
        assert (found.returncode != 0) == (status != 0)
        one.end(controller)
