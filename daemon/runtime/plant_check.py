"""The simulated rod beside the controller's model, from the truth that a simulator publishes."""

from collections.abc import Callable
from threading import Thread

from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.rod.compare import difference_remark, figures
from tendond.schemas.messages import SimulatorTruth


class PlantCheck:
    """Says once in which keys a simulated rod is not the controller's.

    Args:
        section: [rod] of the controller.
        warn: puts a line into the log. say: prints one for people; called from a thread of its own, since a terminal
            that is held would hold the loop.
    """

    def __init__(self, section: RodSection, warn: Callable[[str], None], say: Callable[[str], None]) -> None:
        self._figures, self._warn, self._say = figures(section), warn, say
        self._done = False

    def without_rod(self, truth: SimulatorTruth | None) -> SimulatorTruth | None:
        """Compare the rod that a truth has, the first time; return the truth without it, for the log."""
        if truth is None or not truth.rod:
            return truth
        if not self._done:
            self._done = True
            if remark := difference_remark(truth.rod, self._figures):
                self._warn(remark)
                Thread(target=self._say, args=(remark,), daemon=True).start()
        return truth.model_copy(update={"rod": {}})
