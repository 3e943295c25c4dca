// A library that uses the interfaces as a controller's bridge would: that it is built is the
// test (build.sh).

#include <type_traits>

#include "pickline_interfaces/action/pick_and_place.hpp"
#include "pickline_interfaces/msg/belt_state.hpp"
#include "pickline_interfaces/msg/line_status.hpp"
#include "pickline_interfaces/msg/robot_state.hpp"
#include "pickline_interfaces/msg/task.hpp"
#include "pickline_interfaces/msg/task_ack.hpp"
#include "pickline_interfaces/msg/task_cancel.hpp"
#include "pickline_interfaces/msg/task_result.hpp"

using pickline_interfaces::action::PickAndPlace;
using pickline_interfaces::msg::RobotState;
using pickline_interfaces::msg::Task;
using pickline_interfaces::msg::TaskAck;
using pickline_interfaces::msg::TaskResult;

static_assert(std::is_same_v<decltype(PickAndPlace::Goal::task), Task>);
static_assert(std::is_same_v<decltype(PickAndPlace::Result::result), TaskResult>);
static_assert(PickAndPlace::Feedback::RETURNING == 3);
static_assert(RobotState::FAULT == 2);

PickAndPlace::Goal goal(const Task &task) {
  PickAndPlace::Goal goal;
  goal.task = task;
  return goal;
}

TaskAck accepted(const PickAndPlace::Goal &goal) {
  TaskAck ack;
  ack.header.frame_id = goal.task.header.frame_id;
  ack.task = goal.task.id;
  return ack;
}

TaskResult aborted(const PickAndPlace::Goal &goal) {
  TaskResult result;
  result.task = goal.task.id;
  result.result = TaskResult::REJECTED;
  return result;
}
