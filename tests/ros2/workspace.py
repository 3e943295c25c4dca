"""Makes the `src` folder of a ROS 2 workspace with what pickline_interfaces needs of ROS: the
common packages, with the messages that it uses, and which code generators there are. The
package itself is linked into it, and so is a package `bridge` that uses it.

    python workspace.py SRC PACKAGE
"""

import re
import sys
from pathlib import Path

from rosbags.typesys import Stores, get_typestore

# Of ROS, a message that is needed here and, in `rosbags`, whatever these are made of.
NEEDED = [
    "builtin_interfaces/msg/Time",
    "geometry_msgs/msg/Point",
    "std_msgs/msg/Header",
    # What every action speaks of.
    "action_msgs/msg/GoalInfo",
    "action_msgs/msg/GoalStatus",
    "action_msgs/msg/GoalStatusArray",
]
# The service that every action has; not among the messages that `rosbags` knows.
CANCEL = "GoalInfo goal_info\n---\nint8 return_code\nGoalInfo[] goals_canceling\n"
MANIFEST = """<package format="3">
  <name>{name}</name>
  <version>0.0.0</version>
  <description>As far as pickline_interfaces needs it</description>
  <maintainer email="pickline@example.org">pickline</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
{depends}  <export><build_type>ament_cmake</build_type></export>
</package>
"""
BEGINNING = """cmake_minimum_required(VERSION 3.8)
project({name})
find_package(ament_cmake REQUIRED)
"""
# Those of Debian: for C and C++, without the ones for a particular DDS.
GENERATORS = """find_package(rosidl_adapter REQUIRED)
find_package(rosidl_cmake REQUIRED)
find_package(rosidl_generator_c REQUIRED)
find_package(rosidl_generator_cpp REQUIRED)
"""


# With the package as any other uses it.
BRIDGE = """find_package(pickline_interfaces REQUIRED)
add_library(bridge {source})
target_compile_features(bridge PRIVATE cxx_std_17)
target_compile_options(bridge PRIVATE -Wall -Wextra -Werror)
ament_target_dependencies(bridge pickline_interfaces)
ament_package()
"""


def package(folder, cmake, depends=(), groups=()):
    folder.mkdir(parents=True)
    lines = [f"  <depend>{name}</depend>\n" for name in depends]
    lines += [f"  <member_of_group>{name}</member_of_group>\n" for name in groups]
    manifest = MANIFEST.format(name=folder.name, depends="".join(lines))
    (folder / "package.xml").write_text(manifest)
    (folder / "CMakeLists.txt").write_text(BEGINNING.format(name=folder.name) + cmake)


def interfaces(folder, messages):
    """A package of messages: their definitions by file."""
    own = folder.name
    used = {name for text in messages.values() for name in re.findall(r"^(\w+)/", text, re.M)}
    used = sorted(used - {own})
    files = "".join(f'\n  "{file}"' for file in messages)
    find = "".join(f"find_package({name} REQUIRED)\n" for name in used)
    cmake = f"{find}find_package(rosidl_default_generators REQUIRED)\n"
    cmake += f"rosidl_generate_interfaces({own}{files}\n  DEPENDENCIES {' '.join(used)})\n"
    cmake += "ament_package()\n"
    depends = [*used, "rosidl_default_generators"]
    package(folder, cmake, depends, ["rosidl_interface_packages"])
    for file, text in messages.items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_text(text)


def definitions():
    """The definitions of what is needed: text by file by package."""
    store, packages = get_typestore(Stores.ROS2_JAZZY), {}
    packages["action_msgs"] = {"srv/CancelGoal.srv": CANCEL}
    for needed in NEEDED:
        text, _ = store.generate_msgdef(needed, ros_version=2)
        # Itself, and after lines that name them, whatever it is made of.
        parts = re.split(r"^=+\nMSG: (\S+)\n", text, flags=re.M)
        for name, part in zip([needed, *parts[1::2]], parts[0::2]):
            folder, short = name.split("/")[0], name.split("/")[-1]
            packages.setdefault(folder, {})[f"msg/{short}.msg"] = part
    return packages


def main():
    source, own = Path(sys.argv[1]), Path(sys.argv[2]).resolve()
    extras = "rosidl_default_generators-extras.cmake"
    generators = source / "rosidl_default_generators"
    package(generators, f"ament_package(CONFIG_EXTRAS {extras})\n")
    (generators / extras).write_text(GENERATORS)
    package(source / "rosidl_default_runtime", "ament_package()\n")
    for name, messages in definitions().items():
        interfaces(source / name, messages)
    (source / own.name).symlink_to(own)
    bridge = BRIDGE.format(source=Path(__file__).with_name("bridge.cpp").resolve())
    package(source / "bridge", bridge, [own.name])


main()
