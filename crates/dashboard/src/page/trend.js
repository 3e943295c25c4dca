// A graph of the picking rate over the last minutes.

const TREND_HEIGHT = 150;
// The time that the trend shows [s].
const TREND_SPAN = 600;
const TREND_LEFT = 50;

/** Draws the rates of `trend` onto a canvas that is `width` wide [px], up to now. */
function drawTrend(ctx, width, trend, theme) {
  ctx.clearRect(0, 0, width, TREND_HEIGHT);
  const { rates_per_min: rates, step_s: step } = trend;
  const [left, right, top, bottom] = [TREND_LEFT, width - 14, 20, TREND_HEIGHT - 36];
  const most = 1.1 * Math.max(1, ...rates);
  const x = (ago) => right - (ago / TREND_SPAN) * (right - left);
  const y = (rate) => bottom - (rate / most) * (bottom - top);
  ctx.lineWidth = 1;
  for (const { value, label } of ticks(0, most, 4)) {
    ctx.strokeStyle = theme.belt;
    line(ctx, left, y(value), right, y(value));
    text(ctx, label, left - 8, y(value), theme.faint, SMALL_FONT, "right");
  }
  text(ctx, `picks/min, mean over ${step} s`, left, 8, theme.faint, SMALL_FONT, "left");
  ctx.strokeStyle = theme.faint;
  line(ctx, left, bottom + 0.5, right, bottom + 0.5);
  for (let minutes = 0; minutes <= TREND_SPAN / 60; minutes += 2) {
    const at = x(60 * minutes);
    line(ctx, at, bottom, at, bottom + 4);
    text(ctx, minutes ? `-${minutes}` : "now", at, bottom + 12, theme.faint, SMALL_FONT, "center");
  }
  text(ctx, "time [min]", (left + right) / 2, bottom + 27, theme.faint, SMALL_FONT, "center");
  ctx.strokeStyle = theme.ink;
  ctx.lineWidth = 1.8;
  ctx.beginPath();
  // Each rate is a horizontal step over its interval.
  rates.forEach((rate, i) => {
    const ago = step * (rates.length - i);
    ctx.lineTo(x(ago), y(rate));
    ctx.lineTo(x(ago - step), y(rate));
  });
  ctx.stroke();
}
