// An arm's position during a trip: out along a straight line, grasp, to the bin along a straight
// line, release.

/** The bins of `robot`: one for everything, where it rests, or those with names. */
function binsOf(robot) {
  return robot.bins ?? [{ at: robot.bin, release_time: robot.release_time }];
}

/** The bin that `trip` of `robot` ends at. */
function binOf(robot, trip) {
  const bins = binsOf(robot);
  return bins.find((bin) => bin.name === trip.bin) ?? bins[0];
}

/** The arm of `robot` at `time` [s] of a trip { decide_s, grasp_s, release_s, meet, item } and,
 * with several bins, { from, bin }: at the bin if the trip is over, at rest if there is none. */
function armOnTrip(robot, trip, time) {
  if (!trip || time >= trip.release_s) {
    const [x, y] = trip ? binOf(robot, trip).at : robot.bin;
    return { phase: "idle", x, y, meet: null, item: null, dwell: 0 };
  }
  const bin = binOf(robot, trip);
  const [fromX, fromY] = trip.from ?? robot.bin;
  const out = trip.grasp_s - trip.decide_s;
  const leaves = trip.grasp_s + robot.grasp_time;
  const home = trip.release_s - bin.release_time;
  let phase = "out";
  let way = 0; // share of the way to the meeting point
  let dwell = 0; // share of the dwell that is over
  if (time < trip.grasp_s) {
    way = Math.max(0, (time - trip.decide_s) / out);
  } else if (time < leaves) {
    phase = "grasp";
    way = 1;
    dwell = (time - trip.grasp_s) / robot.grasp_time;
  } else if (time < home) {
    phase = "back";
    way = 1 - (time - leaves) / (home - leaves);
  } else {
    phase = "release";
    dwell = Math.min(1, (time - home) / (bin.release_time || 1));
  }
  const [meetX, meetY] = trip.meet;
  const [binX, binY] = time < leaves ? [fromX, fromY] : bin.at;
  return {
    phase,
    x: binX + way * (meetX - binX),
    y: binY + way * (meetY - binY),
    meet: trip.meet,
    from: [fromX, fromY],
    bin: bin.at,
    item: trip.item,
    dwell,
  };
}
