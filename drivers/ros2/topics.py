"""The topics on which a rig speaks to ROS 2, of a bag and of the bridge alike."""

from dataclasses import dataclass

from tendond.drivers.ros2.names import Qos, ros_name

POSE = "geometry_msgs/msg/PoseStamped"
POINT = "geometry_msgs/msg/PointStamped"
ESTIMATE = "geometry_msgs/msg/PoseWithCovarianceStamped"
JOINTS = "sensor_msgs/msg/JointState"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
MARKERS = "visualization_msgs/msg/MarkerArray"
TEXT = "std_msgs/msg/String"
USUAL = Qos()
"""rclcpp's default: reliable, the newest ten."""


@dataclass(frozen=True)
class Topic:
    """Topic of ROS 2: name with namespace, type, and what its publisher offers."""

    name: str
    type_name: str
    qos: Qos = USUAL


class RigTopics:
    """Topics of a rig; those that ROS shares between robots have no namespace.

    Args:
        rig: its name.
    """

    def __init__(self, rig: str) -> None:
        self.namespace = f"/{ros_name(rig)}"
        self.tip_pose = self._own("tip/pose", POSE)
        self.tip_estimate = self._own("tip/estimate", ESTIMATE)
        self.tendon_state = self._own("tendon/state", JOINTS)
        self.tendon_command = self._own("tendon/command", JOINTS)
        self.reference = self._own("reference", POINT)
        self.rod = self._own("rod", MARKERS)
        self.transforms = Topic("/tf", TRANSFORMS, Qos(depth=100))
        self.diagnostics = Topic("/diagnostics", DIAGNOSTICS)
        self.description = Topic("/robot_description", TEXT, Qos(depth=1, latched=True))
        self.goal_point = self._own("goal_point", POINT)
        self.goal_pose = self._own("goal_pose", POSE)

    @property
    def published(self) -> tuple[Topic, ...]:
        """Those that a rig publishes."""
        return (
            self.tip_pose,
            self.tip_estimate,
            self.tendon_state,
            self.tendon_command,
            self.reference,
            self.rod,
            self.transforms,
            self.diagnostics,
            self.description,
        )

    def service(self, name: str) -> str:
        """Return the name of one of the rig's services, with namespace."""
        return f"{self.namespace}/{name}"

    def _own(self, name: str, type_name: str) -> Topic:
        return Topic(f"{self.namespace}/{name}", type_name)
