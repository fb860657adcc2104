// Signals of the last 10 s, one canvas for each strip. Measured signals are solid, references dashed. Rings of fixed size bound the memory.
import { fixed } from "./words.js";

const POINTS = 1024, WINDOW_S = 10, GAP_S = 0.3, STEPS_APART = 2.5; // a gap is longer than both GAP_S and STEPS_APART times step_s
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"]; // as in hexid's reports
const LEFT = 52, RIGHT = 8, TOP = 8, BOTTOM = 20; // margins of a strip's field, in pixels

// A series has a name, a function that takes its value from a cycle, and a colour. References are dashed.
const legs = (of, scale = 1) => [...Array(6).keys()].map((i) => ({ name: i ? String(i + 1) : "leg 1", of: (c) => c[of][i], scale, colour: i }));
const axes = (names, first) => names.flatMap((name, i) => [
  { name, of: (c) => c.pose_m_rad[first + i], scale: 1e3, colour: i },
  { name: "", of: (c) => c.ref_m_rad[first + i], scale: 1e3, colour: i, dashed: true }]);
const one = (name, of, scale, colour, dashed) => ({ name, of, scale, colour, dashed });

const PLATFORM = [
  { title: "Position, mm", least: 0.2, series: axes(["x", "y", "z"], 0) },
  { title: "Angle, mrad", least: 0.2, series: axes(["φ", "θ", "ψ"], 3) },
  { title: "Leg force, N", least: 10, series: legs("force_n") },
  { title: "Valve command, % of full opening", least: 1, series: legs("valve", 100) },
];
const AXIS = [
  { title: "Position, mm", least: 0.2,
    series: [one("measured", (c) => c.pose_m_rad[0], 1e3, 0), one("", (c) => c.ref_m_rad[0], 1e3, 1, true)] },
  { title: "Force, N", least: 10, series: [one("cylinder", (c) => c.force_n[0], 1, 0)] },
  { title: "Pressure, MPa", least: 0.1, series: [one("P1", (c) => c.p1_pa[0], 1e-6, 0), one("P2", (c) => c.p2_pa[0], 1e-6, 1)] },
  { title: "Valve command, % of full opening", least: 1, series: [one("cylinder", (c) => c.valve[0], 100, 0)] },
];

// Returns a round step, of which 3 to 7 fit into the range.
function stepOf(range) {
  const ten = 10 ** Math.floor(Math.log10(range / 3));
  return ten * [1, 2, 5, 10].findLast((s) => s * ten <= range / 3);
}

export class Strips {
  constructor(parent, machine) {
    this.time = new Float64Array(POINTS);
    this.strips = (machine.mechanism === "axis" ? AXIS : PLATFORM).map((of) => ({ ...of, canvas: document.createElement("canvas"),
      series: of.series.map((s) => ({ ...s, value: new Float32Array(POINTS) })) }));
    this.forget();
    parent.replaceChildren(...this.strips.map(figure));
  }

  forget() {
    this.count = 0;
    this.age_s = 0; // age of the newest message if it is old, else 0
    this.step_s = Infinity; // shortest time between two cycles received
  }

  take(cycle) {
    const passed_s = this.count ? cycle.time_s - this.time[(this.count - 1) % POINTS] : 0;
    if (passed_s < 0) this.forget(); // the loop's clock has started again
    else if (passed_s > 0) this.step_s = Math.min(this.step_s, passed_s);
    const i = this.count++ % POINTS;
    this.time[i] = cycle.time_s;
    for (const strip of this.strips)
      for (const s of strip.series) {
        const value = s.of(cycle);
        s.value[i] = value === null ? NaN : value * s.scale;
      }
  }

  draw() {
    if (!this.count) return;
    for (const strip of this.strips) this.drawStrip(strip);
  }

  // Yields the ring's places within the window, oldest first.
  *shown() {
    const end = this.time[(this.count - 1) % POINTS];
    for (let n = Math.max(0, this.count - POINTS); n < this.count; n++) {
      const t = this.time[n % POINTS];
      if (t >= end - WINDOW_S && t <= end) yield n % POINTS;
    }
  }

  drawStrip({ canvas, series, least }) {
    const ratio = devicePixelRatio, width = canvas.clientWidth, height = canvas.clientHeight;
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const pen = canvas.getContext("2d"), style = getComputedStyle(canvas), places = [...this.shown()];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "12px " + style.fontFamily;
    pen.fillStyle = style.getPropertyValue("--soft");
    const range = rangeOf(series, places, least);
    canvas.classList.toggle("empty", !range);
    if (!range) return void pen.fillText("not in these messages", LEFT, height / 2);
    const end = this.time[(this.count - 1) % POINTS];
    const x = (t) => LEFT + (width - LEFT - RIGHT) * (1 + (t - end) / WINDOW_S);
    const y = (v) => TOP + (height - TOP - BOTTOM) * (range.high - v) / (range.high - range.low);
    drawField(pen, style, range, width, height, y, this.age_s);
    for (const s of series) this.drawSeries(pen, s, places, x, y);
  }

  drawSeries(pen, s, places, x, y) {
    const gap_s = Math.max(GAP_S, STEPS_APART * this.step_s);
    let before = NaN;
    pen.beginPath();
    for (const i of places) {
      const v = s.value[i], t = this.time[i];
      if (Number.isNaN(v)) before = NaN;
      else {
        if (t - before < gap_s) pen.lineTo(x(t), y(v));
        else pen.moveTo(x(t), y(v));
        before = t;
      }
    }
    Object.assign(pen, { strokeStyle: COLOURS[s.colour], lineWidth: s.dashed ? 1 : 1.5, lineJoin: "round" });
    pen.setLineDash(s.dashed ? [4, 3] : []);
    pen.stroke();
    pen.setLineDash([]);
  }
}

function figure({ title, series, canvas }) {
  const box = document.createElement("figure"), caption = document.createElement("figcaption");
  const word = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });
  caption.append(word("b", title));
  for (const s of series.filter((s) => s.name)) {
    const key = word("i", s.name);
    key.style.setProperty("--of", COLOURS[s.colour]);
    caption.append(key);
  }
  if (series.some((s) => s.dashed)) caption.append(Object.assign(word("i", "reference"), { className: "dashed" }));
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", title + ", last 10 seconds");
  box.className = "strip";
  box.append(caption, canvas);
  return box;
}

// Returns the range of the scale. Returns null if no series has a number, or if the numbers are so close that a scale has no steps.
function rangeOf(series, places, least) {
  let low = Infinity, high = -Infinity;
  for (const s of series)
    for (const i of places) {
      if (s.value[i] < low) low = s.value[i];
      if (s.value[i] > high) high = s.value[i];
    }
  if (!(low <= high)) return null;
  const room = Math.max(0.06 * (high - low), (least - (high - low)) / 2);
  if (!(high - low + 2 * room > 1e-9 * Math.max(Math.abs(low), Math.abs(high)))) return null;
  return { low: low - room, high: high + room };
}

function drawField(pen, style, { low, high }, width, height, y, age_s) {
  const step = stepOf(high - low), digits = Math.max(0, -Math.floor(Math.log10(step)));
  pen.strokeStyle = style.getPropertyValue("--grid");
  pen.lineWidth = 1;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (let k = Math.ceil(low / step); k <= Math.floor(high / step); k++) {
    pen.beginPath();
    pen.moveTo(LEFT, y(k * step));
    pen.lineTo(width - RIGHT, y(k * step));
    pen.stroke();
    pen.fillText(fixed(k * step, digits), LEFT - 6, y(k * step));
  }
  pen.textBaseline = "alphabetic";
  for (let s = 0; s <= WINDOW_S; s += WINDOW_S / 5) {
    const x = LEFT + (width - LEFT - RIGHT) * (1 - s / WINDOW_S);
    pen.textAlign = s ? "center" : "right";
    pen.fillText(s + age_s ? `−${s + age_s} s` : "now", x + (s ? 0 : RIGHT), height - 4);
  }
}
