"""What ROS 2 is told of a rig beside its motion: a URDF, and its health as diagnostics."""

from xml.sax.saxutils import quoteattr

from tendond.drivers.ros2.messages import Health, Level, RigMessages
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, Status
from tendond.schemas.record import CycleRecord


def urdf(config: RigConfig, messages: RigMessages) -> str:
    """Return a URDF: base and tip, between them a floating joint, since a rod is no chain of links.

    `/tf` has the tip's pose; the bent rod itself is drawn by the markers on `<rig>/rod`.
    """
    radius = max(0.01, max(max(abs(x), abs(y)) for x, y in config.rod.tendon_positions))
    base, tip = quoteattr(messages.base), quoteattr(messages.tip)
    return f"""<?xml version="1.0"?>
<robot name={quoteattr(messages.rig)}>
  <link name={base}>
    <visual>
      <origin xyz="0 0 -0.005"/>
      <geometry><cylinder radius="{radius:g}" length="0.01"/></geometry>
    </visual>
  </link>
  <link name={tip}>
    <visual>
      <geometry><sphere radius="0.006"/></geometry>
    </visual>
  </link>
  <joint name="rod" type="floating">
    <parent link={base}/>
    <child link={tip}/>
    <origin xyz="0 0 {config.rod.backbone_length:g}"/>
  </joint>
</robot>
"""


def controller_health(status: Status) -> Health:
    """Return the controller's health: an error while it is in a fault, a warning while it refuses its inputs."""
    level = Level.OK
    if status.mode is Mode.FAULT:
        level = Level.ERROR
    elif status.refused or status.safety or status.loop.log_error:
        level = Level.WARN
    values = {
        "mode": status.mode.value,
        "reason": status.reason,
        "law": status.law,
        "cycle": str(status.tick),
        "deadlines missed": str(status.loop.missed_ticks),
        "cycle p99 [ms]": f"{status.loop.cycle_ms_p99:.3f}",
        "rejected": ", ".join(f"{count} {reason}" for reason, count in status.rejected.items()) or "nothing",
        **{f"sensor {name}": health.in_words for name, health in status.sensors.items()},
        **({"filter": status.filter.in_words} if status.filter else {}),
        **({"safety": status.safety} if status.safety else {}),
        **({"refused": status.refused} if status.refused else {}),
        **({"log": status.loop.log_error} if status.loop.log_error else {}),
    }
    return level, f"tendond {status.rig}: controller", f"{status.mode.value}: {status.reason}", values


def cycle_health(rig: str, record: CycleRecord) -> Health:
    """Return the controller's health in a cycle, from its record."""
    level = Level.OK
    if record.mode is Mode.FAULT:
        level = Level.ERROR
    elif record.rejected or record.safety is not None:
        level = Level.WARN
    values = {
        "mode": record.mode.value,
        "reason": record.reason,
        "law": record.law,
        "cycle": str(record.tick),
        "rejected": ", ".join(record.rejected) or "nothing",
        "limited": ", ".join(record.limited) or "nothing",
    }
    return level, f"tendond {rig}: controller", f"{record.mode.value}: {record.reason}", values
