// The machine in motion: a platform as a wire drawing, a single cylinder from its side. Frames as in hexid: x forward, y right, z down.
import { fixed } from "./words.js";

const TILT = 20 * Math.PI / 180; // angle of view from above; the eye is behind and to the right
const TURNS = Array.from({ length: 11 }, (_, i) => (20 + 5 * i) * Math.PI / 180); // angles of view from the right; the clearest is used
const NUMBER = 0.28, BODY = 0.55; // places of a leg's number and of its cylinder's end, as shares of the leg from its foot
const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200]; // factors by which small motion is enlarged
const ROOM = 0.12; // largest enlarged motion, as a share of the drawing's size
const AXIS = 0.25; // length of a drawn axis, as a share of the drawing's size
const HALF_LIFE_S = 4; // time in which the remembered largest motion halves

const points = (flat) => Array.from({ length: flat.length / 3 }, (_, i) => flat.slice(3 * i, 3 * i + 3));
const between = (a, b, share) => a.map((x, i) => x + share * (b[i] - x));

// Returns the point p of the platform in this pose: Rz(psi) Ry(theta) Rx(phi) p + (x y z).
function moved(p, [x, y, z, phi, theta, psi]) {
  const [cf, sf, ct, st, cp, sp] = [phi, theta, psi].flatMap((a) => [Math.cos(a), Math.sin(a)]);
  const [a, b, c] = [p[0], cf * p[1] - sf * p[2], sf * p[1] + cf * p[2]];
  const [d, e] = [ct * a + st * c, ct * c - st * a];
  return [cp * d - sp * b + x, sp * d + cp * b + y, e + z];
}

// Returns a point's coordinates in the picture, right and down, in metres.
function seen([x, y, z], turn) {
  const across = x * Math.sin(turn) + y * Math.cos(turn), away = x * Math.cos(turn) - y * Math.sin(turn);
  return [across, z * Math.cos(TILT) - away * Math.sin(TILT)];
}

// Returns the box around points in the picture: [left, right], [top, bottom].
function boxOf(list, turn) {
  const flat = list.map((p) => seen(p, turn));
  return [0, 1].map((i) => [Math.min(...flat.map((p) => p[i])), Math.max(...flat.map((p) => p[i]))]);
}

// Returns the distance of a point from the line between a and b, in the picture.
function distance(p, a, b) {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]], along = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy);
  const [x, y] = between(a, b, Math.min(1, Math.max(0, along)));
  return Math.hypot(p[0] - x, p[1] - y);
}

// Returns the least distance in the picture of a leg's number from another leg, or of a cylinder's end from another cylinder.
export function apart(upper, lower, turn) {
  const legs = lower.map((foot, i) => [0, NUMBER, BODY, 1].map((share) => seen(between(foot, upper[i], share), turn)));
  return Math.min(...legs.flatMap(([, number, end], i) => legs.filter((_, j) => j !== i)
    .map(([foot, , body, joint]) => Math.min(distance(number, foot, joint), distance(end, foot, body)))));
}

// Returns the angle of view from which the legs overlap least.
const clearest = (upper, lower) => TURNS.reduce((best, turn) => (apart(upper, lower, turn) > apart(upper, lower, best) ? turn : best));

export class Drawing {
  constructor(canvas, machine) {
    this.canvas = canvas;
    this.machine = machine;
    this.faultyLegs = 0; // one bit for each leg
    this.caption = "";
    if (machine.mechanism === "axis") return;
    this.upper = points(machine.upper_m);
    this.lower = points(machine.lower_m);
    this.turn = clearest(this.upper, this.lower);
    const joints = [...this.upper, ...this.lower];
    this.size = Math.max(...boxOf(joints, this.turn).map(([low, high]) => high - low));
    this.axis = AXIS * this.size;
    this.box = boxOf([...joints, [1.2 * this.axis, 0, 0], [0, 1.2 * this.axis, 0]], this.turn);
    this.arm = Math.max(...this.upper.map((p) => Math.hypot(...p)));
    this.peak = 0;
    this.factor = 1;
  }

  draw(cycle) {
    const { canvas } = this, ratio = devicePixelRatio;
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const style = getComputedStyle(canvas);
    this.colour = (name) => style.getPropertyValue("--" + name);
    this.pen = canvas.getContext("2d");
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    this.pen.font = "600 13px " + style.fontFamily;
    this.pen.textAlign = "center";
    this.pen.textBaseline = "middle";
    if (this.machine.mechanism === "axis") this.drawCylinder(cycle);
    else this.drawPlatform(cycle);
  }

  // ---- strokes of the pen ----

  path(corners, close) {
    this.pen.beginPath();
    corners.forEach(([x, y], i) => (i ? this.pen.lineTo(x, y) : this.pen.moveTo(x, y)));
    if (close) this.pen.closePath();
  }

  line(a, b, colour, width) {
    this.path([a, b], false);
    Object.assign(this.pen, { strokeStyle: colour, lineWidth: width, lineCap: "butt" });
    this.pen.stroke();
  }

  outline(corners, colour, width, dash = []) {
    this.path(corners, true);
    Object.assign(this.pen, { strokeStyle: colour, lineWidth: width });
    this.pen.setLineDash(dash);
    this.pen.stroke();
    this.pen.setLineDash([]);
  }

  area(corners, colour, alpha) {
    this.path(corners, true);
    this.pen.globalAlpha = alpha;
    this.pen.fillStyle = colour;
    this.pen.fill();
    this.pen.globalAlpha = 1;
  }

  word(text, [x, y], colour) {
    this.pen.fillStyle = colour;
    this.pen.fillText(text, x, y);
  }

  // ---- the platform ----

  // Converts a point to pixels. The neutral machine is in the middle, with a margin for its travel.
  place(p) {
    const [[left, right], [top, bottom]] = this.box, margin = 1.2;
    const scale = Math.min(this.canvas.clientWidth / (right - left), this.canvas.clientHeight / (bottom - top)) / margin;
    const [x, y] = seen(p, this.turn);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return [width / 2 + scale * (x - (left + right) / 2), height / 2 + scale * (y - (top + bottom) / 2)];
  }

  // Chooses the factor by which small motion is enlarged. It falls at once, so that the motion stays in the drawing, and rises slowly.
  enlarge(cycle) {
    const size = Math.max(...cycle.pose_m_rad.map((x, i) => Math.abs(x) * (i < 3 ? 1 : this.arm)), 1e-6);
    const passed = Math.max(0, cycle.time_s - (this.then ?? cycle.time_s));
    this.then = cycle.time_s;
    this.peak = Math.max(size, this.peak * 0.5 ** (passed / HALF_LIFE_S));
    const room = ROOM * this.size;
    if (this.factor * this.peak > room || 3 * this.factor * this.peak < room)
      this.factor = FACTORS.findLast((f) => f * this.peak <= room) ?? 1;
    this.caption = this.factor > 1 ? `Motion from neutral drawn ${this.factor} times as large.` : "Drawn to scale.";
  }

  drawPlatform(cycle) {
    const known = (pose) => pose.every((x) => x !== null);
    if (!known(cycle.pose_m_rad)) return;
    this.enlarge(cycle);
    const at = (pose) => this.upper.map((p) => moved(p, pose.map((x) => x * this.factor)));
    const upper = at(cycle.pose_m_rad), base = this.lower.map((p) => this.place(p));
    this.area(base, this.colour("grid"), 1);
    this.outline(base, this.colour("rod"), 1);
    const farFirst = [...upper.keys()].sort((a, b) => base[a][1] - base[b][1]);
    for (const leg of farFirst) this.drawLeg(leg, upper[leg]);
    this.area(upper.map((p) => this.place(p)), this.colour("plate"), 0.7);
    this.outline(upper.map((p) => this.place(p)), this.colour("ink"), 1.5);
    if (known(cycle.ref_m_rad)) this.outline(at(cycle.ref_m_rad).map((p) => this.place(p)), this.colour("accent"), 1.5, [6, 4]);
    this.drawAxes(cycle.pose_m_rad.map((x) => x * this.factor));
    if (known(cycle.ref_m_rad)) this.caption += " Dashed: the reference.";
  }

  drawLeg(leg, joint) {
    const foot = this.lower[leg], faulty = (this.faultyLegs >> leg) & 1;
    this.line(this.place(foot), this.place(joint), faulty ? this.colour("alarm") : this.colour("rod"), 3.5);
    this.line(this.place(foot), this.place(between(foot, joint, BODY)), faulty ? this.colour("alarm") : this.colour("body"), 13);
    this.word(String(leg + 1), this.place(between(foot, joint, NUMBER)), this.colour("paper"));
  }

  drawAxes(pose) {
    const origin = moved([0, 0, 0], pose);
    ["x", "y", "z"].forEach((name, i) => {
      const end = [0, 0, 0], beyond = [0, 0, 0];
      end[i] = this.axis, beyond[i] = 1.15 * this.axis;
      this.line(this.place(origin), this.place(moved(end, pose)), this.colour("alarm"), 2);
      this.word(name, this.place(moved(beyond, pose)), this.colour("alarm"));
    });
  }

  // ---- one cylinder ----

  drawCylinder(cycle) {
    const { clientWidth: width, clientHeight: height } = this.canvas, { middle_m: middle, stroke_m: stroke } = this.machine;
    const position = cycle.pose_m_rad[0], reference = cycle.ref_m_rad[0], y = 0.45 * height;
    const [left, bodyEnd, travelFrom, travel] = [0.04, 0.42, 0.48, 0.4].map((share) => share * width);
    const x = (reading) => travelFrom + travel * Math.min(1, Math.max(0, (reading - middle) / stroke + 0.5));
    const box = (from, to, half) => [[from, y - half], [to, y - half], [to, y + half], [from, y + half]];
    this.area(box(left, bodyEnd, 34), this.faultyLegs ? this.colour("alarm") : this.colour("body"), 1);
    if (position !== null) {
      this.line([bodyEnd, y], [x(position), y], this.colour("rod"), 16);
      this.area(box(x(position), x(position) + 0.06 * width, 46), this.colour("plate"), 1);
      this.outline(box(x(position), x(position) + 0.06 * width, 46), this.colour("ink"), 1.5);
    }
    if (reference !== null) this.line([x(reference), y - 62], [x(reference), y + 62], this.colour("accent"), 2);
    this.drawStroke(x, y + 84);
    const known = reference !== null ? " Blue: the reference." : "";
    this.caption = `Position ${position === null ? "–" : fixed(1e3 * position, 2)} mm; the stroke is ${fixed(1e3 * stroke, 0)} mm.${known}`;
  }

  drawStroke(x, y) {
    const { middle_m: middle, stroke_m: stroke } = this.machine, ends = [-0.5, 0, 0.5].map((share) => middle + share * stroke);
    this.line([x(ends[0]), y], [x(ends[2]), y], this.colour("rod"), 1);
    for (const reading of ends) {
      this.line([x(reading), y - 5], [x(reading), y + 5], this.colour("rod"), 1);
      this.word(`${fixed(1e3 * reading, 0)} mm`, [x(reading), y + 18], this.colour("soft"));
    }
  }
}
