// An arm's position during a trip: out along a straight line, grasp, back along the same line,
// release.

/** The arm of `robot` at `time` [s] of a trip { decide_s, grasp_s, release_s, meet, item },
 * or at rest if there is no trip or it is over. */
function armOnTrip(robot, trip, time) {
  const [binX, binY] = robot.bin;
  if (!trip || time >= trip.release_s) {
    return { phase: "idle", x: binX, y: binY, meet: null, item: null, dwell: 0 };
  }
  const out = trip.grasp_s - trip.decide_s;
  const leaves = trip.grasp_s + robot.grasp_time;
  const home = trip.release_s - robot.release_time;
  let phase = "out";
  let way = 0; // share of the way from the bin to the meeting point
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
    dwell = Math.min(1, (time - home) / (robot.release_time || 1));
  }
  const [meetX, meetY] = trip.meet;
  return {
    phase,
    x: binX + way * (meetX - binX),
    y: binY + way * (meetY - binY),
    meet: trip.meet,
    item: trip.item,
    dwell,
  };
}
