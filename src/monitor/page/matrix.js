// The inertia matrix during a run: by method C after each test, by method A after the last one, compared with the nominal matrix.
import { at, fillTable, fixed, figures } from "./words.js";

const SURE = 1.96, SCALE_PCT = 10; // half of a 95 % interval in standard deviations; end of the bar's scale
const COLUMNS = 6;

// Returns the difference of an entry from nominal, in per cent of sqrt(Mii Mjj) as in hexid's reports, and the factor to per cent.
function difference(machine, { row, column }, matrix) {
  const nominal = machine.nominal_mt_si, place = COLUMNS * row + column;
  const scale = 100 / Math.sqrt(nominal[COLUMNS * row + row] * nominal[COLUMNS * column + column]);
  return matrix?.[place] == null ? { value: NaN, scale } : { value: scale * (matrix[place] - nominal[place]), scale };
}

function whisker(value, half) {
  const bar = document.createElement("div"), percent = (x) => 50 + 50 * Math.max(-1, Math.min(1, x / SCALE_PCT));
  bar.className = "whisker";
  if (!Number.isFinite(value)) return bar;
  const interval = bar.appendChild(document.createElement("i")), dot = bar.appendChild(document.createElement("b"));
  interval.style.left = `${percent(value - half)}%`;
  interval.style.right = `${100 - percent(value + half)}%`;
  dot.style.left = `${percent(value)}%`;
  return bar;
}

function entryRow(machine, entry, c, a) {
  const place = COLUMNS * entry.row + entry.column, nominal = machine.nominal_mt_si[place];
  const ofC = difference(machine, entry, c?.mt_si), ofA = difference(machine, entry, a?.method_a_mt_si);
  const std = c?.mt_std_si[place], found = c?.mt_si[place];
  const digits = Number.isFinite(std) && std > 0 ? Math.max(0, Math.min(4, 1 - Math.floor(Math.log10(std)))) : 3;
  const signed = (x) => (x > 0 ? "+" : "") + fixed(x, 2);
  return [`${entry.name}, ${entry.unit.replace("^2", "²")}`, figures(nominal, 5),
    found == null ? "–" : `${fixed(found, digits)} ± ${fixed(SURE * std, digits)}`,
    Number.isFinite(ofC.value) ? signed(ofC.value) : "–", Number.isFinite(ofA.value) ? signed(ofA.value) : "–",
    whisker(ofC.value, SURE * (std ?? 0) * ofC.scale)];
}

export function showMatrix(machine, { method_c: c, identification: a }) {
  if (machine.mechanism === "axis") return;
  const rows = machine.entries.map((entry) => entryRow(machine, entry, c, a));
  fillTable(at("matrix"), [["", "nominal", "method C", "C, %", "A, %", "C ± 95 %"], ...rows]);
  const soFar = c ? `Method C after ${c.tests} ${c.tests === 1 ? "test" : "tests"}: ${c.determined} of 21 entries determined.` :
    "Comes after the first test.";
  at("matrix_state").textContent = soFar + " Differences in % of √(Mii Mjj); the bar ends at ±10 %." +
    (a ? "" : " Method A comes after the sixth test.");
  at("verdict").textContent = a ? `Verdict of the run: ${[a.verdict.replaceAll("_", " "), ...a.reasons].join("; ")}.` : "";
}
