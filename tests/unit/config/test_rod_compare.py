"""The simulated rod beside the controller's: which keys differ, said once."""

from typing import Any

import pytest

from tendond.daemon.runtime.plant_check import PlantCheck
from tendond.drivers.simulator.introduction import Introduction
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.config.rod.compare import difference_remark, differences, figures
from tendond.schemas.messages import SimulatorTruth
from tendond.schemas.wire import decode, encode

SOFT = "[simulator.rod]\nyoungs_modulus = 171e9\nnodes = 20\n"
TAPER = """
[[rod.section]]
length = 0.2
radius = 1e-3
youngs_modulus = 2e11
density = 8000.0
[[rod.tendon]]
position = [0.01, 0.0]
[[rod.tendon]]
position = [-0.01, 0.0]
turns = 0.25
"""
TURNED = f"""{TAPER}
[[simulator.rod.tendon]]
position = [0.012, 0.0]
[[simulator.rod.tendon]]
position = [-0.01, 0.0]
turns = 0.3
"""


def compared(text: str) -> list[str]:
    config = parse_config(text, "rig.toml")
    return differences(figures(config.simulator.rod), figures(config.rod))


def truth(seq: int) -> SimulatorTruth:
    return SimulatorTruth(
        seq=seq, stamp_ns=1, position=(0.0, 0.0, 0.5), velocity=(0.0, 0.0, 0.0), displacement=(0.0,), tension=(0.0,),
        tip_force=(0.0, 0.0, 0.0),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("", []),
        ("[rod]\ndamping_ratio = 0.1\n", []),
        (SOFT, ["youngs_modulus = 1.71e+11, not 1.9e+11"]),
        ('[simulator.rod]\nspace = "euler"\n', []),
        ("[simulator.rod]\ntendon_stiffness = 2e4\n", ["tendon_stiffness = 20000, not none"]),
        (TURNED, ["tendon[0].position = [0.012, 0], not [0.01, 0]", "tendon[1].turns = 0.3, not 0.25"]),
    ],
)
def test_differences_are_named_by_key_with_both_values(text: str, found: list[str]) -> None:
    assert compared(text) == found


def test_a_remark_names_a_few_keys_and_the_number_of_the_others() -> None:
    text = "[simulator.rod]\nlength = 0.4\nradius = 2e-3\ndensity = 1e4\npoisson_ratio = 0.2\ntip_mass = 0.1\n"
    config = parse_config(text, "rig.toml")
    remark = difference_remark(figures(config.simulator.rod), figures(config.rod))
    assert remark.startswith("the simulated rod is not the controller's: simulator.rod has length = 0.4, not 0.5; ")
    assert remark.endswith("; and 1 more")


def test_the_simulator_describes_its_rod_once_a_second_and_the_controller_says_once_what_differs() -> None:
    plant = Introduction(parse_config(SOFT, "plant"))
    said: list[Any] = []
    check = PlantCheck(RigConfig().rod, lambda line: said.append(("log", line)), lambda line: said.append(line))
    sent = [decode(SimulatorTruth, encode(plant.added_to(truth(seq)))) for seq in range(250)]
    assert [one.seq for one in sent if one.rod] == [0, 1, 100, 101, 200, 201]
    kept = [check.without_rod(one) for one in sent]
    assert not any(one.rod for one in kept if one is not None)
    assert [one for one in said if isinstance(one, tuple)] == [
        ("log", "the simulated rod is not the controller's: simulator.rod has youngs_modulus = 1.71e+11, not 1.9e+11")
    ]


def test_the_same_rod_is_no_remark() -> None:
    said: list[str] = []
    check = PlantCheck(RigConfig().rod, said.append, said.append)
    check.without_rod(Introduction(RigConfig()).added_to(truth(0)))
    assert check.without_rod(None) is None
    assert said == []
