"""Compares travel times with ruckig's.

usage: compare.py MOVES.csv

MOVES.csv has the columns length_m, speed_m_s, acceleration_m_s2, deceleration_m_s2 and time_s.
"""

import csv
import random
import sys

from ruckig import InputParameter, Result, Ruckig, Trajectory

# So high that it plays no part.
JERK = 1e9
# Largest relative difference of a time.
TOLERANCE = 1e-3


def duration(length, speed, acceleration, deceleration, end=0.0):
    """Time [s] for a move of `length` [m] from rest that ends with the velocity `end` [m/s]."""
    move = InputParameter(1)
    move.current_position = [0.0]
    move.target_position = [length]
    move.target_velocity = [end]
    move.max_velocity = [speed]
    move.min_velocity = [-speed]
    move.max_acceleration = [acceleration]
    move.min_acceleration = [-deceleration]
    move.max_jerk = [JERK]
    trajectory = Trajectory(1)
    result = Ruckig(1).calculate(move, trajectory)
    if result not in (Result.Working, Result.Finished):
        sys.exit(f"ruckig has no trajectory for {length} m: {result}")
    return trajectory.duration


def compare(path):
    """Holds every move of the file at `path` to ruckig."""
    worst, count = 0.0, 0
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            length, speed, acceleration, deceleration, time = map(float, row.values())
            expected = duration(length, speed, acceleration, deceleration)
            off = abs(time - expected) / expected
            if off > TOLERANCE:
                sys.exit(f"{row}: ruckig takes {expected} s")
            worst, count = max(worst, off), count + 1
    if count < 1000:
        sys.exit(f"{path}: {count} moves, of 1000")
    print(f"{count} moves from rest to rest: at most {worst:.1e} relative from ruckig")


def table():
    """Prints how much less a move along the belt takes if it ends with the belt's velocity."""
    draw = random.Random(1)
    moves = [(draw.uniform(0.05, 0.6), draw.uniform(30, 120)) for _ in range(1000)]
    print("belt [m/s]  less time, mean [%]  at most [%]")
    for belt in (0.1, 0.5, 1.0):
        less = []
        for length, acceleration in moves:
            rest = duration(length, 10.0, acceleration, acceleration)
            moving = duration(length, 10.0, acceleration, acceleration, end=belt)
            less.append(100 * (1 - moving / rest))
        print(f"{belt:10}  {sum(less) / len(less):19.1f}  {max(less):11.1f}")


compare(sys.argv[1])
table()
