"""The ROS messages as another DDS implementation needs them, made from the .msg files."""

from pathlib import Path

from cyclonedds.idl import make_idl_struct, types
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

# vision_msgs as of ROS 2 Jazzy; not among the packages that rosbags knows.
VISION = {
    "BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
    "ObjectHypothesis": "string class_id\nfloat64 score\n",
    "ObjectHypothesisWithPose": "ObjectHypothesis hypothesis\n"
    "geometry_msgs/PoseWithCovariance pose\n",
    "Detection3D": "std_msgs/Header header\nObjectHypothesisWithPose[] results\n"
    "BoundingBox3D bbox\nstring id\n",
    "Detection3DArray": "std_msgs/Header header\nDetection3D[] detections\n",
}
BASE = {
    "bool": bool,
    "string": str,
    "uint8": types.uint8,
    "int32": types.int32,
    "uint32": types.uint32,
    "uint64": types.uint64,
    "float64": types.float64,
}


class Interfaces:
    """All messages by name, as classes that Cyclone DDS can send."""

    def __init__(self, folder: Path):
        self.fields = dict(get_typestore(Stores.ROS2_JAZZY).fielddefs)
        for name, text in VISION.items():
            self.fields.update(get_types_from_msg(text, f"vision_msgs/msg/{name}"))
        self.own = []
        for file in sorted(folder.glob("*.msg")):
            name = f"pickline_interfaces/msg/{file.stem}"
            self.fields.update(get_types_from_msg(file.read_text(), name))
            self.own.append(name)
        self.made = {}

    def kind(self, field):
        """The type of a field."""
        node, what = field
        if node == Nodetype.BASE:
            return BASE[what[0]]
        if node == Nodetype.NAME:
            return self.message(what)
        of, count = self.kind(what[0]), what[1]
        return types.array[of, count] if node == Nodetype.ARRAY else types.sequence[of]

    def message(self, name):
        """The class of a message."""
        if name not in self.made:
            package, _, short = name.split("/")
            fields = {field: self.kind(kind) for field, kind in self.fields[name][1]}
            typename = f"{package}::msg::dds_::{short}_"
            self.made[name] = make_idl_struct(short, typename, fields)
        return self.made[name]

    def __getattr__(self, short):
        for package in ("pickline_interfaces", "vision_msgs", "std_msgs", "geometry_msgs",
                        "builtin_interfaces"):
            if f"{package}/msg/{short}" in self.fields:
                return self.message(f"{package}/msg/{short}")
        raise AttributeError(short)

    def constants(self, short):
        """The constants of a message, by name."""
        return {name: value for name, _, value in self.fields[f"pickline_interfaces/msg/{short}"][0]}
