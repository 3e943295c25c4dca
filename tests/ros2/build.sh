# Sourced by run.sh, in the project's folder, where there is a venv with rosbags: builds
# ros2/pickline_interfaces with colcon and ROS's own code generators, in a workspace under
# the target folder, and a package in C++ that uses it. Sets `fields` to what ROS reads in it.

. tests/debian.sh
debian colcon=colcon cmake=cmake g++=g++ make=make \
    /usr/lib/python3/dist-packages/colcon_cmake=python3-colcon-cmake \
    /usr/lib/python3/dist-packages/colcon_ros=python3-colcon-ros \
    /usr/lib/python3/dist-packages/colcon_recursive_crawl=python3-colcon-recursive-crawl \
    /usr/lib/python3/dist-packages/colcon_package_selection=python3-colcon-package-selection \
    /usr/share/ament_cmake=ament-cmake /usr/share/rosidl_generator_c=rosidl-core

workspace=$target/ros2-workspace
fields=$workspace/fields.json
rm -rf "$workspace"
mkdir -p "$workspace/src"
"$python" tests/ros2/workspace.py "$workspace/src" ros2/pickline_interfaces
# ROS is installed for Debian's own Python.
(cd "$workspace" && colcon build --packages-up-to bridge \
    --cmake-args -DBUILD_TESTING=OFF -DPython3_EXECUTABLE=/usr/bin/python3) \
    > "$workspace/told.txt" 2>&1 || { cat "$workspace/told.txt" >&2; exit 1; }
/usr/bin/python3 tests/ros2/fields.py \
    "$workspace/install/pickline_interfaces/share/pickline_interfaces" > "$fields"
