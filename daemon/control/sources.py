"""Sources in use: one of poses, one of tendon states, and no other controller. Pure.

The first source of a topic is followed as long as it is alive; another one is refused, named, and remembered for a
while. Another one is followed only after the first has fallen silent, and never while tendons are pulled: what is seen
then would be another rig's.
"""

from dataclasses import dataclass

from tendond.schemas.keys import ALIVE, SENSOR, TENDON_STATE, TIP_POSE
from tendond.schemas.record import CycleInputs

UNNAMED = "one without a name"


@dataclass(frozen=True)
class Source:
    """A publisher: its identity, and the tick at which it was heard last."""

    name: str
    heard: int


@dataclass(frozen=True)
class Sources:
    """The publishers of a cycle's inputs.

    Attributes:
        followed: the one in use, by topic.
        others: further ones that were heard within the last `faults.source_time`, by topic; of each topic the newest.
    """

    followed: dict[str, Source]
    others: dict[str, Source]

    def in_words(self) -> str:
        """Describe the topics with two publishers; empty where all have one."""
        lines = []
        for topic, other in self.others.items():
            if topic == ALIVE:
                lines.append(f"another controller of this rig is on the bus: {_quoted(other.name)}")
            else:
                first = self.followed[topic].name if topic in self.followed else ""
                lines.append(f"two sources of {topic}: {_quoted(first)} and {_quoted(other.name)}")
        return "; ".join(lines) + ": end one of them" if lines else ""


def _quoted(name: str) -> str:
    return f"'{name}'" if name else UNNAMED


def without_sensors(others: dict[str, str]) -> dict[str, str]:
    """Return the publishers of other topics than the sensors', which are judged by themselves (`phases.readings`)."""
    return {topic: name for topic, name in others.items() if not topic.startswith(f"{SENSOR}/")}


@dataclass(frozen=True)
class Heard:
    """Sources after a cycle's inputs; which of pose and tendon state are to be refused as another source's."""

    sources: Sources
    pose_refused: bool
    tendons_refused: bool


def _differs(other: Source, first: Source | None) -> bool:
    return first is None or not other.name or other.name != first.name


def with_unnamed(sources: Sources, topic: str, tick: int) -> Sources:
    """Return the sources with one more, that has no name but a count of its own."""
    return Sources(sources.followed, {**sources.others, topic: Source("", tick)})


def hear(
    sources: Sources, tick: int, inputs: CycleInputs, alive: dict[str, int], remembered: int, *, pulling: bool
) -> Heard:
    """Take note of who has sent a cycle's inputs.

    Args:
        sources: so far.
        tick: index of the cycle.
        inputs: inputs of the cycle.
        alive: cycles without a message after which the followed source counts as gone, by topic.
        remembered: cycles for which another source is remembered.
        pulling: tendons are pulled, or being released: no other source is taken up.
    """
    followed, others = sources.followed, sources.others
    refused = {TIP_POSE: False, TENDON_STATE: False}
    for topic, message in ((TIP_POSE, inputs.pose), (TENDON_STATE, inputs.tendon_state)):
        if message is None:
            continue
        first = followed.get(topic)
        if first is None or first.name == message.source or (tick - first.heard > alive[topic] and not pulling):
            followed = {**followed, topic: Source(message.source, tick)}
        else:
            refused[topic] = True
            others = {**others, topic: Source(message.source, tick)}
    for topic, name in without_sensors(inputs.others).items():
        others = {**others, topic: Source(name, tick)}
    if others:
        others = {
            topic: other
            for topic, other in others.items()
            if tick - other.heard <= remembered and _differs(other, followed.get(topic))
        }
    return Heard(Sources(followed, others), refused[TIP_POSE], refused[TENDON_STATE])
