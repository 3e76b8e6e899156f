"""A pacer with the plant behind it: controller and plant in one process, without a clock."""

import time

from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.pacing import Wake
from tendond.drivers.simulator.plant import Plant


class PlantPacer:
    """A pacer with the plant in it: one cycle per pose, in this process."""

    def __init__(self, hub: Hub, plant: Plant) -> None:
        self._hub = hub
        self._plant = plant

    def wait(self) -> Wake:
        arrivals = self._hub.receive()
        arrivals.pose, arrivals.tendon_state, _ = self._plant.observe(0)
        if self._hub.last_command is not None:
            self._plant.step(self._hub.last_command)
        return Wake(time.monotonic(), arrivals, 0.0, 0)
