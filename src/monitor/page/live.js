// The live page: receives the server's stream (/events) and shows the newest state, results and events. Text from messages is inserted
// as text, never as HTML.
import { Drawing } from "./drawing.js";
import { Strips } from "./strips.js";
import { showMatrix } from "./matrix.js";
import { at, fillTable, fixed, sentence } from "./words.js";

const OLD_S = 2, MISFIT_M = 1e-3, EVENTS_SHOWN = 14, EVENTS_KEPT = 64;
const PHASES = ["", "settling", "ramp in", "evaluated part", "ramp out"];
const FLAGS = ["stale", "late", "samples dropped", "invalid", "overrun", "I/O error", "another master", "interlock open",
  "command not written", "two devices answer"];
const DOF_NAMES = { phi: "φ", theta: "θ", psi: "ψ" };

let machine = null; // the machine as the configuration describes it
let run = null; // number of the run that is shown
let newest = null; // last cycle received
let drawn = null; // cycle that is on the screen; null: draw again
let fault = null;
let events = [], results = [];
let matrices = {};
let drawing, strips;

const axis = () => machine.mechanism === "axis";
const dofName = (dof) => DOF_NAMES[machine.dofs[dof]] ?? machine.dofs[dof];

// ---- the machine ----

function meet(data) {
  machine = data;
  drawing = new Drawing(at("drawing"), machine);
  strips = new Strips(at("strips"), machine);
  at("machine").textContent = (axis() ? "a single cylinder" : "a platform with six legs") + " on " + machine.lcm_url;
  at("drawing").setAttribute("aria-label", axis() ? "the cylinder" : "the platform with its six legs");
  document.body.classList.toggle("axis", axis());
  at("tests_part").hidden = at("matrix_part").hidden = axis();
  forget();
}

// Clears the page for another run of hexid; only the events of earlier runs stay.
function forget() {
  newest = drawn = null;
  showFault(null);
  results = [];
  matrices = {};
  strips.forget();
  showTests();
  showMatrix(machine, matrices);
  showLoop(null);
}

// ---- state ----

const testName = (c) => (c.dof >= 0 ? dofName(c.dof) : machine.tests?.[c.test] ?? "any motion");

function doing(c) {
  if (axis()) return "recorded motion of the cylinder";
  if (c.test < 0) return c.flags ? "samples: " + FLAGS.filter((_, bit) => (c.flags >> bit) & 1).join(", ") : "";
  const phase = PHASES[c.phase] ? ", " + PHASES[c.phase] : "";
  return `test ${c.test + 1} of ${machine.tests.length}: ${testName(c)}${phase}, ${fixed(c.test_time_s, 1)} s`;
}

// Returns the state to show. Not every cycle is sent, so an event may report a later state than the newest cycle has.
function stateOf(c) {
  const said = events.findLast((e) => e.kind === "state" && e.run === run);
  return fault ? "fault" : said && said.seq > c.seq ? said.text : machine.states[c.state];
}

function showState(c) {
  const state = stateOf(c);
  at("state").textContent = state;
  at("state").classList.toggle("alarm", state === "fault");
  at("doing").textContent = doing(c);
  document.title = `${state === "fault" ? "FAULT" : state} - hexid`;
}

const UNIT = (dof) => (dof < 3 ? "mm" : "mrad");

function showPose(c) {
  const rows = axis()
    ? [["", "measured", "reference", "difference"], poseRow("position", "mm", c, 0)]
    : [["", "measured", "reference", "difference"], ...c.pose_m_rad.map((_, i) => poseRow(dofName(i), UNIT(i), c, i))];
  fillTable(at("pose"), rows);
}

function poseRow(name, unit, c, i) {
  const pose = c.pose_m_rad[i], ref = c.ref_m_rad[i];
  const scaled = (x, known) => (known ? fixed(1e3 * x, 2) : "–");
  return [`${name}, ${unit}`, scaled(pose, pose !== null), scaled(ref, ref !== null), scaled(pose - ref, pose !== null && ref !== null)];
}

// Shows the legs. The length of a single cylinder is its position, which the table above shows.
function showLegs(c) {
  const given = (x, scale, digits) => (x === null ? "–" : fixed(x * scale, digits));
  const row = (i) => [given(c.p1_pa[i], 1e-6, 2), given(c.p2_pa[i], 1e-6, 2), given(c.force_n[i], 1, 0), given(c.valve[i], 100, 1)];
  const head = ["P1, MPa", "P2, MPa", "force, N", "valve, %"];
  if (axis()) fillTable(at("legs"), [["", ...head], ["cylinder", ...row(0)]]);
  else {
    const rows = c.length_m.map((length, i) => [String(i + 1), given(length, 1, 4), ...row(i)]);
    fillTable(at("legs"), [["leg", "length, m", ...head], ...rows]);
  }
}

// Shows a fault. A run that ends with its fault may send no cycle in the state `fault`, so the state follows from the fault itself.
function showFault(told) {
  fault = told;
  if (newest) showState(newest);
  at("fault").hidden = !fault;
  drawing.faultyLegs = fault?.legs ?? 0;
  drawn = null; // draws again, because the drawing marks the faulty legs
  if (!fault) return;
  at("fault_name").textContent = "Fault: " + fault.name.replaceAll("_", " ") + (fault.measured ? `: ${fault.measured}` : "");
  at("fault_cause").textContent = sentence(fault.cause);
  at("fault_remedy").textContent = sentence(fault.remedy.replaceAll("`", ""), false);
}

// ---- health ----

function showHealth(health) {
  if (run !== null && health.run !== run) forget();
  run = health.run;
  const never = health.silence_s === null, silent = never || health.silence_s > OLD_S;
  at("live").classList.toggle("silent", silent);
  at("link").classList.toggle("broken", silent);
  at("link").textContent = never ? "no hexid heard yet" : silent ? `nothing heard for ${Math.floor(health.silence_s)} s` : "live";
  const age_s = silent && !never ? Math.floor(health.silence_s) : 0;
  if (strips.age_s !== age_s) [strips.age_s, drawn] = [age_s, null];
  at("last_seconds").textContent = age_s ? `The last 10 seconds heard, until ${age_s} s ago` : "The last 10 seconds";
  at("misfit").hidden = !(health.misfit_m > MISFIT_M);
  at("misfit").textContent = `Pose and leg lengths do not fit this configuration, by ${fixed(1e3 * health.misfit_m, 0)} mm: give hexid ` +
    "monitor the configuration (-c) of the hexid that it shows, or drawing and nominal matrix are another machine's.";
  at("live").hidden = never && !events.length && at("gap_part").hidden;
  if (never) {
    at("state").classList.remove("alarm");
    document.title = "hexid";
    at("state").textContent = "waiting for hexid";
    at("doing").textContent = `None is heard on ${machine.lcm_url}: is one running, with this lcm.url?`;
  }
  const again = health.run > 1 ? `run ${health.run} since this page has been served, ` : "";
  at("when").textContent = newest ? `${again}${fixed(newest.time_s, 1)} s of the loop's time` : "";
  fillTable(at("loop"), loopRows(health), false);
}

let loopStats = null, lastHealth = null;
function showLoop(stats) {
  loopStats = stats;
  if (lastHealth) fillTable(at("loop"), loopRows(lastHealth), false);
}

// Returns the words for missed deadlines. A paced simulation misses none: if the host is late, the simulated time is stretched.
function missed(s) {
  const stretched = s.stalls > 0 && s.overruns === 0;
  return stretched ? `0: simulated time was stretched at ${s.stalls} late wake-up${s.stalls > 1 ? "s" : ""}` : String(s.overruns);
}

function loopRows(health) {
  lastHealth = health;
  const s = loopStats, rows = [];
  const us = (name, of) => rows.push([name, ["p50", "p99", "max"].map((q) => fixed(s[`${of}_${q}_us`], 0)).join(", ") + " µs"]);
  if (s) {
    rows.push(["cycles", `${s.cycles} of ${fixed(1e3 * s.period_s, 1)} ms`], ["deadlines missed", missed(s)]);
    if (s.timed) {
      us("wake-up latency: median, 99 %, maximum", "wake");
      us("execution: median, 99 %, maximum", "exec");
      if (s.pace_ratio !== undefined) rows.push(["pace", `${fixed(s.pace_ratio, 3)} of real time`],
        ["stalls of the host", s.stalls ? `${s.stalls}, the longest ${fixed(1e3 * s.longest_stall_s, 0)} ms` : "none"]);
    }
    rows.push(["records lost by the recorder", String(s.lost_records)]);
  }
  rows.push(["messages of its state", String(health.messages)], ["lost on the way", String(health.lost)],
    ["not understood", String(health.dropped)]);
  if (health.silence_s !== null) rows.push(Object.assign(["last message of its state", `${fixed(health.silence_s, 1)} s ago`],
    { kind: health.silence_s > OLD_S ? "old" : "" }));
  return rows;
}

// ---- tests ----

function progress(c) {
  const whole = machine.settle_s + machine.test_s;
  if (machine.test_s === null) return `${fixed(c.test_time_s, 1)} s`;
  const bar = document.createElement("progress");
  bar.value = Math.min(1, Math.max(0, (c.test_time_s + machine.settle_s) / whole));
  bar.title = `${fixed(100 * bar.value, 0)} %`;
  return bar;
}

function resultCells(r) {
  const unit = r.dof >= 3 ? "mrad" : "mm";
  const unwanted = Math.max(...r.unwanted_pct.filter((x, i) => x !== null && i !== r.dof), 0);
  return [`${fixed(1e3 * r.achieved_m_or_rad, 3)} ${unit}`, fixed(r.phase_deg, 1), fixed(unwanted, 1), String(r.excluded)];
}

function showTests() {
  if (axis()) return;
  const rows = machine.tests.map((name, i) => {
    const r = results[i], now = newest?.test === i;
    const shown = r?.dof_name ?? (now ? (newest.dof >= 0 ? machine.dofs[newest.dof] : name) : name);
    const row = [DOF_NAMES[shown] ?? shown, ...(now ? [progress(newest), "", "", ""] : r ? resultCells(r) : ["", "", "", ""])];
    return Object.assign(row, { kind: now ? "now" : r ? "" : "pending" });
  });
  fillTable(at("tests"), [["", "achieved", "phase, °", "unwanted, %", "excluded"], ...rows]);
}

// ---- events ----

function showEvents(list) {
  events = [...events, ...list].filter((e, i, all) => !i || e.number > all[i - 1].number).slice(-EVENTS_KEPT);
  const rows = events.slice(-EVENTS_SHOWN).reverse().map((e) => [`${fixed(e.time_s, 2)} s`, e.kind, e.text]);
  if (rows.length) at("live").hidden = false;
  fillTable(at("events"), rows.length ? rows : [["none yet", "", ""]], false);
  if (newest) showState(newest);
}

// ---- the stream ----

function take(cycles) {
  for (const c of cycles) strips.take(c);
  newest = cycles[cycles.length - 1];
}

// Draws the newest cycle when the browser is about to paint, which it does not do while the page is hidden.
function draw() {
  requestAnimationFrame(draw);
  if (!newest || newest === drawn) return;
  drawn = newest;
  showState(newest);
  showPose(newest);
  showLegs(newest);
  showTests();
  drawing.draw(newest);
  at("drawing_caption").textContent = drawing.caption;
  strips.draw();
}

const matrix = (name) => (data) => { matrices[name] = data; showMatrix(machine, matrices); };
const handlers = {
  machine: meet, health: showHealth, cycles: take, events: showEvents, fault: showFault, loop_stats: showLoop,
  method_c: matrix("method_c"), identification: matrix("identification"),
  test_result: (r) => { if (r) results[r.test] = r; if (newest) showTests(); },
  gap: (g) => {
    at("gap_part").hidden = !g;
    if (g) at("live").hidden = false;
    if (g) [at("gap_verdict").textContent, at("gap_reason").textContent] = [g.verdict + ":", g.reason];
  },
};

// Canvases do not follow the page's colours and size by themselves, so they are drawn again.
const again = () => { drawn = null; };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
addEventListener("resize", again);

function listen() {
  const source = new EventSource("events");
  for (const [name, handler] of Object.entries(handlers)) source.addEventListener(name, (event) => handler(JSON.parse(event.data)));
  source.onerror = () => {
    at("link").classList.add("broken");
    at("live").classList.add("silent");
    const refused = source.readyState === EventSource.CLOSED; // by a monitor that serves as many pages as it can, or by another program
    at("link").textContent = refused ? "not let in: as many watch as are served, or another program is there; trying again" : "hexid monitor is gone; trying again";
    if (refused) setTimeout(listen, 2000);
  };
  source.onopen = () => { events = []; showEvents([]); };
}

listen();
requestAnimationFrame(draw);
