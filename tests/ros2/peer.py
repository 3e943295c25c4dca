"""Plays a line's camera, belt and robots for `pickline run --ros2`, over Cyclone DDS.

Checks every task against the belt as it knows it, and prints what it found as JSON.
"""

import heapq
import itertools
import json
import math
import sys
import time
from pathlib import Path

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from interfaces import Interfaces

SPEED, ITEMS, ROBOTS = 0.4, 20, {"r1": (1.2, 0.7), "r2": (2.8, 0.7)}
BASES, REACH, GRASP, ARM = {"r1": (1.2, 0.6), "r2": (2.8, 0.6)}, 1.0, 0.1, 4.0
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile,
               Policy.History.KeepAll)
LOSSY = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepAll)

messages = Interfaces(Path(sys.argv[1]))
domain, best_effort = int(sys.argv[2]), "best-effort" in sys.argv
participant = DomainParticipant(domain)
publisher, subscriber = Publisher(participant), Subscriber(participant)


def writer(name, kind, qos=RELIABLE):
    topic = Topic(participant, f"rt/line1/{name}", kind, qos=qos)
    return DataWriter(publisher, topic, qos=qos)


def reader(name, kind):
    topic = Topic(participant, f"rt/line1/{name}", kind, qos=RELIABLE)
    return DataReader(subscriber, topic, qos=RELIABLE)


def moment(stamp):
    whole = math.floor(stamp)
    return messages.Time(sec=whole, nanosec=min(int(round((stamp - whole) * 1e9)), 999_999_999))


def stamp_of(moment):
    return moment.sec + moment.nanosec * 1e-9


def header(stamp, frame="belt"):
    return messages.Header(stamp=moment(stamp), frame_id=frame)


detections = writer("detections", messages.Detection3DArray, LOSSY if best_effort else RELIABLE)
belt = writer("belt_state", messages.BeltState)
states = writer("robot_states", messages.RobotState)
acks = writer("acks", messages.TaskAck)
results = writer("results", messages.TaskResult)
tasks, status = reader("tasks", messages.Task), reader("status", messages.LineStatus)
PICKED = messages.constants("TaskResult")["PICKED"]
IDLE = messages.constants("RobotState")["IDLE"]

# Both ends of every topic have to have found each other.
while not all(end.get_publication_matched_status().current_count
              for end in (detections, belt, states, acks, results)) or not all(
        end.get_subscription_matched_status().current_count for end in (tasks, status)):
    time.sleep(0.05)


def tell_robots(stamp):
    for name in ROBOTS:
        states.write(messages.RobotState(header=header(stamp), name=name, state=IDLE,
                                         has_available_at=False, available_at=moment(0.0),
                                         has_task=False, task=0))


# The node may find a writer later than the writer finds it: it has to know the robots.
while not any(all(robot.state == "idle" for robot in figures.robots) for figures in status.take(64)):
    tell_robots(time.time())
    time.sleep(0.05)

origin = time.time()
items = {f"i{i}": (-0.12 * i, 0.1 * (i % 5) - 0.2) for i in range(ITEMS)}


def place(item, stamp):
    x0, y = items[item]
    return x0 + SPEED * (stamp - origin), y


def seen(item, stamp, frame="belt", x=None):
    here, y = place(item, stamp)
    spot = messages.Point(x=here if x is None else x, y=y, z=0.0)
    pose = messages.Pose(position=spot, orientation=messages.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = 1e-6
    guess = messages.ObjectHypothesisWithPose(
        hypothesis=messages.ObjectHypothesis(class_id="bottle", score=0.9),
        pose=messages.PoseWithCovariance(pose=pose, covariance=covariance))
    box = messages.BoundingBox3D(center=pose, size=messages.Vector3(x=0.1, y=0.05, z=0.02))
    # What is not said of the item is said of the picture.
    nothing = messages.Header(stamp=messages.Time(sec=0, nanosec=0), frame_id="")
    item = messages.Detection3D(header=nothing, results=[guess], bbox=box, id=item)
    return messages.Detection3DArray(header=header(stamp, frame), detections=[item])


events, order = [], itertools.count()


def plan(when, what):
    heapq.heappush(events, (when, next(order), what))


def tell_belt():
    now = time.time()
    belt.write(messages.BeltState(header=header(now), speed=SPEED, has_position=True,
                                  position=SPEED * (now - origin)))
    plan(now + 1.0, tell_belt)


tell_belt()
tell_robots(origin)
# Three that must be refused.
detections.write(seen("i0", origin, frame="camera"))
detections.write(seen("i0", origin, x=math.nan))
states.write(messages.RobotState(header=header(origin), name="r1", state=9,
                                 has_available_at=False, available_at=moment(0.0),
                                 has_task=False, task=0))
for item, (x0, _) in items.items():
    when = origin + max(0.0, (-0.5 - x0) / SPEED)
    plan(when, lambda item=item: detections.write(seen(item, time.time())))

found = {"tasks": 0, "revisions": 0, "picked": [], "wrong": [], "resent": False, "status": None}
known, deaf = {}, None


def check(task):
    """What is wrong with a task."""
    times = [stamp_of(moment) for moment in (task.earliest_start, task.start, task.latest_start)]
    meet_at, free_at = stamp_of(task.meet_at), stamp_of(task.free_at)
    decided = stamp_of(task.header.stamp)
    x, y = place(task.item, meet_at)
    base, bin = BASES[task.robot], ROBOTS[task.robot]
    way = math.dist((task.meet.x, task.meet.y), bin)
    return [name for name, holds in {
        "frame": task.header.frame_id == "belt",
        "window": times == sorted(times),
        "decided": origin <= decided <= times[1] + 1e-6,
        "place": math.dist((task.meet.x, task.meet.y), (x, y)) < 2e-3,
        "plane": task.meet.z == 0.0 and task.bin.z == 0.0,
        "reach": math.dist((task.meet.x, task.meet.y), base) <= REACH + 1e-6,
        "travel": abs(way / ARM - (meet_at - times[1])) < 1e-3,
        "free": free_at >= meet_at + GRASP,
        # One bin for everything has no name.
        "bin": (task.bin.x, task.bin.y) == bin and task.bin_name == "",
        # The weight that follows from the area in cm^2 and the probability of the detection.
        "priority": abs(task.priority - 0.9 / (1 + math.exp(-50 / 100))) < 1e-9,
        "strategy": task.strategy.startswith("rules:"),
        "item": task.item not in found["picked"],
    }.items() if not holds]


def finish(task):
    """A robot is back with the item."""
    if known.get(task.id) is not task:
        return
    found["picked"].append(task.item)
    results.write(messages.TaskResult(header=header(time.time()), task=task.id, result=PICKED,
                                      has_available_at=False, available_at=moment(0.0)))


def take(task):
    """A robot is given a task."""
    global deaf
    before = known.get(task.id)
    if before is not None and task.revision <= before.revision:
        return
    found["tasks" if before is None else "revisions"] += 1
    found["wrong"] += [f"task {task.id}.{task.revision}: {word}" for word in check(task)]
    known[task.id] = task
    if deaf is None:
        # One task is not heard the first time: it has to come again.
        deaf = task.id
        return
    if task.id == deaf:
        found["resent"] = True
    acks.write(messages.TaskAck(header=header(time.time()), task=task.id))
    plan(stamp_of(task.free_at), lambda: finish(task))


until = origin + 60
while time.time() < until and not (found["status"] and found["status"]["last"]):
    while events and events[0][0] <= time.time():
        heapq.heappop(events)[2]()
    for task in tasks.take(64):
        take(task)
    for figures in status.take(64):
        found["status"] = {
            "last": figures.last, "seen": figures.seen, "picked": figures.picked,
            "on_belt": figures.on_belt, "claimed": figures.claimed, "unwanted": figures.unwanted,
            "frame": figures.header.frame_id, "decisions": figures.decisions,
            "rejected": {count.what: count.count for count in figures.rejected},
            "robots": {robot.name: robot.picked for robot in figures.robots},
        }
        if len(found["picked"]) == figures.picked == ITEMS and not figures.claimed:
            print("done", flush=True)
    time.sleep(0.005)
print(json.dumps(found), flush=True)
