"""The page itself in a browser, with frames put in: what is drawn, and what is said of old frames."""

import json
import re
from pathlib import Path

from tendond.cli.dashboard.files import PAGE, still
from tendond.cli.dashboard.frame import frame
from tendond.cli.dashboard.run import welcome
from tendond.cli.watch.bus_snapshot import BusSnapshot
from tendond.daemon.recording.scene import filter_entity
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.health import LoopHealth
from tendond.schemas.messages import Mode, Status, TendonCommand
from tests.unit.offline.browser import browse, browser

CONFIG = RigConfig().with_own_rates()
TIP = (0.2, 0.0, 0.4)
HOSTILE = "</script><script>document.body.dataset.broken = 'yes'</script><img src=x onerror=alert(1)>"

NOTE = """<script>
const pen = element("scene").getContext("2d"), ratio = devicePixelRatio;
const seen = (p) => page.panels.scene.at(p).map((one) => Math.round(one * ratio));
const red = (p) => {
  const [r, g, b, a] = pen.getImageData(...seen(p), 1, 1).data;
  return a > 0 && r > 2 * g && r > 2 * b;
};
document.body.dataset.noted = JSON.stringify({
  tip: red([0.2, 0, 0.42]), force: red([0.17, 0, 0.4]), beside: red([0.2, 0, 0.3]),
  reason: element("reason").textContent, remedy: element("remedy").textContent, mode: element("mode").textContent,
  tension: element("tension-0").textContent, bar: document.querySelector(".bar").className,
  arm: element("arm").disabled, reset: element("reset").disabled, title: document.title,
});
</script>"""
"""Notes colours within the ellipsoid, on the force's arrow, and beside both; and what is written."""


def status(mode: Mode, reason: str) -> Status:
    """A status of the default rig."""
    loop = LoopHealth(cycles=1, missed_ticks=0, cycle_ms_median=1.0, cycle_ms_p99=2.0, log_dropped=0)
    none = (0.0,) * 4
    return Status(
        seq=1, stamp_ns=1, rig="paper", mode=mode, reason=reason, tick=1, law="backstepping", feedback="observer",
        tip=TIP, target=(0.3, 0.0, 0.3), tension=none, displacement=none, rejected={}, loop=loop,
    )  # fmt: skip


def noted(folder: Path, mode: Mode, reason: str) -> dict[str, object]:
    """What a browser shows of a frame."""
    snapshot = BusSnapshot()
    snapshot.add(status(mode, reason), 1.0)
    command = TendonCommand(
        seq=7, stamp_ns=1, pose_seq=None, displacement=(0.02, 0.0, 0.0, 0.0), tension=(59.5, 0.0, 0.0, 0.0), armed=True
    )
    snapshot.add(command, 1.0)
    wide = (1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4)  # 28 mm about the tip
    entity = filter_entity(1, TIP, (-0.5, 0.0, 0.0), wide, (1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4))
    scene = {"entities": [entity.model_dump(mode="json")]}
    shown = {**frame(snapshot, CONFIG, 1.1, " --config rig.toml"), "ghost": None, "scene": scene}
    file = folder / "page.html"
    file.write_text(still(welcome(CONFIG), [json.dumps(shown)]).replace("</body>", f"{NOTE}</body>"), encoding="utf-8")
    dom = browse(folder, "--dump-dom", file.as_uri())
    found = re.search(r'data-noted="([^"]*)"', dom)
    assert found is not None, dom[-2000:]
    assert "data-broken" not in dom.split("<main>")[0]
    values: dict[str, object] = json.loads(found[1].replace("&quot;", '"').replace("&lt;", "<").replace("&gt;", ">"))
    return values


@browser
def test_the_filters_ellipsoid_and_force_are_drawn_where_they_are_and_a_fault_has_its_remedy(tmp_path: Path) -> None:
    found = noted(tmp_path, Mode.FAULT, HOSTILE)
    assert (found["tip"], found["force"], found["beside"]) == (True, True, False)
    assert found["reason"] == HOSTILE  # as text
    assert found["remedy"] == "To clear it: fix the cause, then 'tendond reset --config rig.toml'"
    assert (found["mode"], found["title"]) == ("fault", "FAULT - tendond")
    assert (found["arm"], found["reset"]) == (True, False)
    assert (found["tension"], found["bar"]) == ("59.50", "bar bad")


def test_the_page_loads_nothing_from_elsewhere_and_sets_text_only_as_text() -> None:
    for file in PAGE.iterdir():
        text = file.read_text(encoding="utf-8")
        assert "//" not in re.sub(r"^\s*//.*$| // .*$|`ws://\$\{location\.host\}", "", text, flags=re.M)
        for danger in ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "new Function"):
            assert danger not in text
