// Draws a picture of the scope: lanes one below the other, each with its own axis, on one time axis.
// One path per signal.  Everything is drawn by its instant; what is not known is not drawn, and lost samples are said.

export const GUTTER = 52; // width of the axes on the left
const STRIP = 20; // height of the time line of events, below the lanes
const AXIS = STRIP + 22; // and of the time axis below it
const DIGITAL = 34;
const LEAST = 44;
const PAD = 17; // above a trace: there is the label of its lane

// Returns the lanes of the columns for a height: top and height of each, and of the strip of events.
export function lanes(columns, height) {
  const digital = columns.filter(isDigital).length;
  const free = height - AXIS - digital * DIGITAL;
  const analog = Math.max(free / Math.max(columns.length - digital, 1), LEAST);
  let top = 0;
  return columns.map((column) => {
    const lane = { top, height: isDigital(column) ? DIGITAL : analog };
    top += lane.height;
    return lane;
  });
}

// The height that these columns need at least.
export function heightOf(columns, least) {
  const needed = columns.reduce((sum, column) => sum + (isDigital(column) ? DIGITAL : LEAST), AXIS);
  return Math.max(needed, least);
}

export function isDigital(column) {
  return column.kind === 'truth' || column.kind === 'text';
}

// The colour of a row: neighbours differ in hue and in lightness.
export function colour(row, isDark) {
  const light = isDark ? (row % 2 ? 0.82 : 0.74) : (row % 2 ? 0.58 : 0.5);
  return `oklch(${light} .15 ${(255 + row * 137.5) % 360})`;
}

// The axis of each row: it grows at once, and shrinks when the signal fills less than half of it.
export class Axes {
  #ranges = [];

  of(row, found) {
    const kept = this.#ranges[row];
    if (found === null) return kept ?? [0, 1];
    let [low, high] = found;
    if (low === high) [low, high] = [low - Math.max(Math.abs(low) * 0.01, 0.5), high + Math.max(Math.abs(high) * 0.01, 0.5)];
    const fits = kept !== undefined && low >= kept[0] && high <= kept[1] && high - low > 0.45 * (kept[1] - kept[0]);
    if (!fits) this.#ranges[row] = [low, high];
    return this.#ranges[row];
  }

  clear() { this.#ranges = []; }
}

// Draws on a 2D context that is scaled to CSS pixels.  `picture` has buckets, columns, lanes, axes, gaps, trigger,
// cursors, events, and zero: the instant from which the time axis counts.
export function draw(g, width, height, picture, look) {
  g.clearRect(0, 0, width, height);
  g.font = look.font;
  const { buckets } = picture;
  const plot = { x: GUTTER, width: Math.max(width - GUTTER, 1), bottom: height - AXIS };
  const span = Math.max(buckets.endNs - buckets.firstNs, 1);
  const xOf = (instantNs) => plot.x + ((instantNs - buckets.firstNs) / span) * plot.width;
  if (picture.columns.some((column) => column.is_there)) drawTime(g, plot, picture, look, xOf); // else no instant is known
  if (picture.trigger) drawBefore(g, plot, picture, look, xOf);
  picture.columns.forEach((column, row) => {
    const lane = picture.lanes[row];
    g.fillStyle = look.edge;
    g.fillRect(0, lane.top + lane.height - 0.5, width, 0.5);
    g.save();
    g.beginPath();
    g.rect(plot.x, lane.top, plot.width, lane.height);
    g.clip();
    const axis = isDigital(column) ? null : picture.axes.of(row, buckets.range(row));
    if (axis !== null) drawLine(g, plot, lane, row, axis, picture, look);
    else if (column.kind === 'truth') drawLevel(g, plot, lane, row, picture, look);
    else drawStates(g, plot, lane, row, picture, look);
    g.restore();
    if (axis !== null && column.is_there) drawAxis(g, lane, axis, look);
    drawName(g, plot, lane, column, look.colours[row], look);
  });
  for (const gap of picture.gaps) drawGap(g, plot, gap, picture, look, xOf);
  drawEvents(g, plot, picture.events, look, xOf);
  if (picture.trigger) drawTrigger(g, plot, picture, look, xOf);
  picture.cursors.forEach((instantNs, place) => drawCursor(g, plot, instantNs, 'AB'[place], look, xOf));
}

// A line is one pixel wide: the outline of a wider one is made before it is filled, which took most of the time of a picture
// where no GPU draws it (16 signals: 34 ms, and 18 ms so).
function drawLine(g, plot, lane, row, [low, high], picture, look) {
  const { buckets } = picture;
  const scale = (lane.height - PAD - 6) / (high - low);
  const bottom = lane.top + lane.height - 4;
  const step = plot.width / buckets.count;
  const { holds } = picture.columns[row];
  let held = buckets.before[row] ?? NaN;
  let isDown = false;
  g.beginPath();
  g.strokeStyle = look.colours[row];
  g.lineWidth = 1;
  const [lows, highs] = buckets.shown(row);
  for (let place = 0; place < lows.length; place++) {
    const least = lows[place];
    const most = highs[place];
    const x = plot.x + (place + 0.5) * step;
    if (least === Infinity && held === held) {
      if (!isDown) g.moveTo(x - 0.5, bottom - (held - low) * scale);
      if (holds || place === lows.length - 1) g.lineTo(x + 0.5, bottom - (held - low) * scale); // else the next sample ends the line
      isDown = true;
    } else if (least === Infinity || least !== least) {
      isDown = false;
      held = NaN;
    } else {
      const [near, far] = held > most ? [most, least] : [least, most];
      if (!isDown) g.moveTo(x - 0.5, bottom - (near - low) * scale);
      else if (holds) g.lineTo(x, bottom - (held - low) * scale);
      g.lineTo(isDown ? x : x + 0.5, bottom - (near - low) * scale); // a sample alone is a dot
      if (near !== far) g.lineTo(x, bottom - (far - low) * scale);
      held = far;
      isDown = true;
    }
  }
  g.stroke();
}

function drawLevel(g, plot, lane, row, picture, look) {
  const { buckets } = picture;
  const step = plot.width / buckets.count;
  const bottom = lane.top + lane.height - 5;
  const top = lane.top + lane.height * 0.48;
  let held = buckets.before[row] ?? NaN;
  g.fillStyle = look.colours[row];
  const line = (x, y) => g.fillRect(x, y - 0.75, step + 0.5, 1.5);
  const [lows, highs] = buckets.shown(row);
  for (let place = 0; place < lows.length; place++) {
    const least = lows[place];
    const most = highs[place];
    const x = plot.x + place * step;
    if (least !== least) { held = NaN; continue; }
    const isEdge = least !== Infinity && (least !== most || (held === held && most !== held));
    const level = least === Infinity ? held : most;
    if (level !== level) continue;
    if (isEdge) g.fillRect(x, top, Math.max(step, 1.3), bottom - top);
    line(x, level ? top : bottom);
    if (level && !isEdge) { g.globalAlpha = 0.16; g.fillRect(x, top, step + 0.5, bottom - top); g.globalAlpha = 1; }
    held = level;
  }
}

function drawStates(g, plot, lane, row, picture, look) {
  const { buckets } = picture;
  const step = plot.width / buckets.count;
  const top = lane.top + lane.height * 0.42;
  const height = lane.height * 0.5;
  const names = picture.columns[row].states;
  let run = null;
  const end = (place) => {
    if (run === null) return;
    const x = plot.x + run.place * step;
    const width = (place - run.place) * step;
    g.globalAlpha = 0.2;
    g.fillStyle = look.colours[row];
    g.fillRect(x, top, width, height);
    g.globalAlpha = 1;
    g.fillRect(x, top, Math.min(1.3, width), height);
    g.fillRect(x, top + height - 1, width, 1);
    const name = run.value === 'mixed' ? '' : names[run.value] ?? String(run.value);
    g.fillStyle = look.ink;
    g.textBaseline = 'middle';
    g.textAlign = 'left';
    if (name && g.measureText(name).width + 8 < width) g.fillText(name, x + 5, top + height / 2 + 0.5);
    run = null;
  };
  let held = buckets.before[row] ?? NaN;
  const [lows, highs] = buckets.shown(row);
  for (let place = 0; place < lows.length; place++) {
    const least = lows[place];
    const most = highs[place];
    const isKnown = least === least && (least !== Infinity || held === held);
    if (!isKnown) { end(place); held = NaN; continue; }
    const value = least === Infinity ? held : least === most ? most : 'mixed';
    if (run === null || run.value !== value) { end(place); run = { place, value }; }
    if (least !== Infinity) held = most;
  }
  end(buckets.count);
}

function drawName(g, plot, lane, column, colour, look) {
  const words = column.unit ? `${column.name} (${column.unit})` : column.name;
  const trouble = column.trouble ? column.trouble.split('\n')[0] : column.is_there ? '' : 'no sample yet';
  g.textAlign = 'left';
  g.textBaseline = 'top';
  g.fillStyle = look.card;
  g.globalAlpha = 0.75;
  g.fillRect(plot.x + 2, lane.top + 1, g.measureText(words).width + 18, 13);
  g.globalAlpha = 1;
  g.fillStyle = colour;
  g.fillRect(plot.x + 5, lane.top + 5, 8, 5);
  g.fillStyle = look.ink;
  g.fillText(words, plot.x + 17, lane.top + 2);
  if (!trouble) return;
  g.fillStyle = column.trouble ? look.down : look.quiet;
  g.textBaseline = 'middle';
  g.fillText(trouble, plot.x + 17, lane.top + lane.height * 0.65);
}

function drawAxis(g, lane, [low, high], look) {
  g.fillStyle = look.quiet;
  g.textAlign = 'right';
  g.textBaseline = 'bottom';
  g.fillText(number(low, high - low), GUTTER - 6, lane.top + lane.height - 2, GUTTER - 8);
  g.textBaseline = 'top';
  g.fillText(number(high, high - low), GUTTER - 6, lane.top + PAD - 4, GUTTER - 8);
}

function drawTime(g, plot, picture, look, xOf) {
  const { firstNs, endNs } = picture.buckets;
  const step = niceStep((endNs - firstNs) / Math.max(plot.width / 110, 1));
  const zero = picture.zeroNs;
  g.textAlign = 'center';
  g.textBaseline = 'bottom';
  for (let tick = Math.ceil((firstNs - zero) / step); tick * step + zero <= endNs; tick++) {
    const x = xOf(tick * step + zero);
    g.fillStyle = look.edge;
    g.fillRect(x, 0, 1, plot.bottom);
    g.fillStyle = look.quiet;
    const text = duration(tick * step, step);
    const half = g.measureText(text).width / 2;
    if (x - half > plot.x && x + half < plot.x + plot.width) g.fillText(text, x, plot.bottom + AXIS - 4);
  }
}

function drawBefore(g, plot, picture, look, xOf) {
  const x = Math.min(Math.max(xOf(picture.trigger.ns), plot.x), plot.x + plot.width);
  g.fillStyle = look.accent;
  g.globalAlpha = 0.06;
  g.fillRect(plot.x, 0, x - plot.x, plot.bottom);
  g.globalAlpha = 1;
}

function drawTrigger(g, plot, picture, look, xOf) {
  const x = xOf(picture.trigger.ns);
  if (x < plot.x || x > plot.x + plot.width) return;
  g.fillStyle = look.accent;
  const begin = Math.max(xOf(picture.trigger.afterNs), plot.x);
  if (x - begin > 1) { // the edge lies somewhere in a gap
    g.globalAlpha = 0.25;
    g.fillRect(begin, 0, x - begin, plot.bottom);
    g.globalAlpha = 1;
  }
  g.fillRect(x - 0.5, 0, 1.2, plot.bottom);
  g.beginPath();
  g.moveTo(x - 5, plot.bottom + 6);
  g.lineTo(x + 5, plot.bottom + 6);
  g.lineTo(x, plot.bottom - 2);
  g.fill();
}

function drawGap(g, plot, gap, picture, look, xOf) {
  const left = Math.max(xOf(gap.first_ns), plot.x);
  const right = Math.min(Math.max(xOf(gap.end_ns), left + 2), plot.x + plot.width);
  if (right <= plot.x || left >= plot.x + plot.width) return;
  // One that was lost says nothing of how many others never were: the time of the gap does.
  const words = `${gap.lost ? `${gap.lost} lost` : 'not sampled'} in ${exactly(gap.end_ns - gap.first_ns, 2)}`;
  for (const row of gap.rows) {
    const lane = picture.lanes[row];
    g.fillStyle = gap.lost ? look.down : look.late;
    g.globalAlpha = 0.14;
    g.fillRect(left, lane.top, right - left, lane.height);
    g.globalAlpha = 1;
    g.fillRect(left, lane.top + lane.height - 2, right - left, 2);
    if (g.measureText(words).width + 6 < right - left) {
      g.textAlign = 'center';
      g.textBaseline = 'middle';
      g.fillText(words, (left + right) / 2, lane.top + lane.height / 2);
    }
  }
}

// The time line under the lanes: a mark for each event, and its words where there is room.
function drawEvents(g, plot, events, look, xOf) {
  const middle = plot.bottom + STRIP / 2;
  let free = plot.x;
  g.fillStyle = look.edge;
  g.fillRect(0, plot.bottom + STRIP, plot.x + plot.width, 0.5);
  events.forEach((event, number) => {
    const x = xOf(event.at_ns);
    if (x < plot.x || x > plot.x + plot.width) return;
    g.fillStyle = event.is_over ? look.ok : event.sort === 'event' ? look.quiet : look.fault;
    g.globalAlpha = 0.4;
    g.fillRect(x - 0.5, 0, 1, plot.bottom);
    const begin = Math.max(xOf(event.after_ns), plot.x); // it happened between this and the mark
    g.fillRect(begin, middle - 1, Math.max(x - begin, 0), 2);
    g.globalAlpha = 1;
    g.beginPath();
    g.arc(x, middle, 4, 0, 7);
    if (event.is_over) { g.lineWidth = 1.5; g.strokeStyle = g.fillStyle; g.stroke(); } else g.fill();
    const words = `${event.part} ${event.text}${event.is_over ? ': over' : ''}`;
    const end = x + 8 + g.measureText(words).width;
    const next = number + 1 < events.length ? xOf(events[number + 1].at_ns) - 8 : Infinity;
    if (x < free || end > Math.min(next, plot.x + plot.width)) return;
    g.textAlign = 'left';
    g.textBaseline = 'middle';
    g.fillText(words, x + 8, middle + 0.5);
    free = end + 8;
  });
}

function drawCursor(g, plot, instantNs, name, look, xOf) {
  const x = xOf(instantNs);
  if (x < plot.x || x > plot.x + plot.width) return;
  g.fillStyle = look.ink;
  for (let y = 0; y < plot.bottom; y += 6) g.fillRect(x - 0.5, y, 1, 3);
  g.fillRect(x - 7, plot.bottom + 3, 14, 14); // below the lanes, which have their names at the top
  g.fillStyle = look.card;
  g.textAlign = 'center';
  g.textBaseline = 'middle';
  g.fillText(name, x, plot.bottom + 10.5);
}

// Draws two signals over each other.
export function drawXy(g, width, height, points, look) {
  g.clearRect(0, 0, width, height);
  const x = new Float64Array(points.x);
  const y = new Float64Array(points.y);
  const [left, right] = extent(x);
  const [low, high] = extent(y);
  if (!(left <= right && low <= high)) return;
  const xOf = (value) => 8 + ((value - left) / (right - left || 1)) * (width - 16);
  const yOf = (value) => height - 22 - ((value - low) / (high - low || 1)) * (height - 30);
  g.beginPath();
  g.strokeStyle = look.colours[0];
  g.lineWidth = 1.3;
  g.lineCap = 'round'; // a line without length is a dot: both values rest
  let isDown = false;
  for (let place = 0; place < x.length; place++) {
    if (!Number.isFinite(x[place]) || !Number.isFinite(y[place])) { isDown = false; continue; }
    if (!isDown) g.moveTo(xOf(x[place]), yOf(y[place]));
    g.lineTo(xOf(x[place]), yOf(y[place]));
    isDown = true;
  }
  g.stroke();
  g.font = look.font;
  g.fillStyle = look.quiet;
  g.textAlign = 'left';
  g.textBaseline = 'bottom';
  g.fillText(`${number(left, right - left)} to ${number(right, right - left)} across, ${number(low, high - low)} to ${number(high, high - low)} up`, 8, height - 1);
}

function extent(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

function niceStep(least) {
  const power = 10 ** Math.floor(Math.log10(Math.max(least, 1)));
  return [1, 2, 5, 10].find((factor) => factor * power >= least) * power;
}

const UNITS = [[1e9, 's'], [1e6, 'ms'], [1e3, 'us'], [1, 'ns']];

// A time with as many decimals as a step of the axis needs.
export function duration(ns, stepNs = 1) {
  const [size, unit] = UNITS.find(([one]) => Math.abs(stepNs) >= one || one === 1);
  const [shown, name] = Math.abs(ns) >= 1e9 && size < 1e9 && stepNs >= 1e5 ? [1e9, 's'] : [size, unit];
  const decimals = Math.min(Math.max(Math.ceil(Math.log10(shown / Math.max(stepNs, 1))), 0), 9);
  return `${(ns / shown).toFixed(decimals)} ${name}`;
}

// A time with so many digits, in the unit that fits it.
export function exactly(ns, digits = 6) {
  const [size, unit] = UNITS.find(([one]) => Math.abs(ns) >= one) ?? UNITS[3];
  return `${Number((ns / size).toPrecision(digits))} ${unit}`;
}

// A number with as many decimals as the range around it needs.
export function number(value, range = Math.abs(value)) {
  if (value === null || value !== value) return 'no value';
  if (Number.isInteger(value) && Math.abs(value) < 1e6) return String(value);
  if (Math.abs(value) >= 1e6 && Math.abs(value) < 1e12) return `${number(value / 1e6, range / 1e6)}M`;
  if (Math.abs(value) >= 1e6 || (value !== 0 && Math.abs(value) < 1e-4 && range < 1e-3)) return value.toExponential(2);
  const decimals = range > 0 ? Math.min(Math.max(Math.ceil(2 - Math.log10(range)), 0), 6) : 3;
  return value.toFixed(decimals);
}
