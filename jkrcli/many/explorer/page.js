"use strict";
/* Controls to curve to pictures, numbers, commands and files. */

const content = JSON.parse(document.getElementById("content").textContent);
const table = new Table(content), units = new Units(content.units);
const byId = (id) => document.getElementById(id);
const NAMES = { load: "load control", displacement: "displacement control", machine: "machine" };
const QUANTITIES = [["P", "load"], ["delta", "length"], ["a", "length"]];
const WETS = "w is more than twice the surface tension and wets the indenter";
let waiting = false;

const controls = Object.fromEntries(
  Object.entries(content.controls).map(([name, spec]) => [name, new Control(name, spec, changed)]));

function changed(name) {
  if (name === "stiffness") document.querySelector("input[name=control][value=machine]").checked = true;
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; update(); });
}

const picked = (name) => document.querySelector(`input[name=${name}]:checked`).value;
const stiffnessOf = (name) => ({ load: 0, displacement: Infinity, machine: controls.stiffness.value })[name];

/* The angle at the edge [rad] where the surface has a tension, which goes with the moduli; more than 2 there is none. */
const angleOf = (curve) => Math.sqrt(2 * curve.w / (content.tension * curve.factor));
const wets = (curve) => content.tension > 0 && angleOf(curve) > 2 * (1 + 1e-9);

function update() {
  const curve = new AdhesiveCurve(table, controls.w.value, controls.factor.value);
  const chosen = picked("control"), pulls = {};
  for (const name of Object.keys(NAMES)) pulls[name] = wets(curve) ? { reason: WETS } : curve.pullOff(stiffnessOf(name));
  window.explorer = { curve, pulls, chosen, histories: histories(curve, chosen) };
  if (window.Plotly) pictures(curve, pulls, chosen);
  numbers(pulls, chosen);
  judge(curve, pulls[chosen], chosen);
  byId("commands").textContent = commands();
}

/* ---------------------------------------------------------------- pictures */
function pictures(curve, pulls, chosen) {
  const k = controls.stiffness.value, machine = byId("position").checked;
  const X = machine ? (point) => point.delta + point.P / k : (point) => point.delta;
  const unit = new AdhesiveCurve(table, 0, curve.factor);
  const shown = {
    pulls, chosen, parts: curve.parts(stiffnessOf(chosen)), nonadhesive: table.samples.map((at) => unit.point(at)),
    band: band(curve), level: table.level, measured: measured(k),
  };
  const view = picked("view"), data = shown.measured.flatMap((one) => one.points), origin = { a: 0, delta: 0, P: 0 };
  const points = [...shown.parts.flatMap((part) => part.points), ...data, origin];
  const seen = { near: near(points, pulls), whole: points, data: [...data, origin] }[view];
  const load = { of: (point) => point.P, name: "load", symbol: "P", dimension: "load" };
  const across = machine
    ? { of: X, name: "machine position", symbol: "δ + P/k", dimension: "length" }
    : { of: X, name: "displacement", symbol: "δ", dimension: "length" };
  const radius = { of: (point) => point.a, name: "contact radius", symbol: "a", dimension: "length" };
  for (const one of [across, load, radius]) one.window = seen.map(one.of).filter(Number.isFinite);
  draw(byId("load-plot"), linesOf({ ...shown, measured: kept(shown.measured, across, load) }), across, load, units, view);
  draw(byId("radius-plot"), linesOf({ ...shown, band: null, measured: kept(shown.measured, load, radius) }), load, radius, units, view);
  byId("load-plot").setAttribute("aria-label", `Load over ${across.name}, ${seen.length} points; ${said(pulls[chosen], chosen)}`);
}

/* The measured curves that hold both quantities. */
function kept(curves, x, y) {
  const whole = (point) => Number.isFinite(x.of(point)) && Number.isFinite(y.of(point));
  return curves.map(({ name, points }) => ({ name, points: points.filter(whole) })).filter(({ points }) => points.length);
}

/* What lies around pull-off: loads up to three times its force, or all where there is none. */
function near(points, pulls) {
  const force = -(pulls.load.P ?? pulls.displacement.P ?? 0);
  return force > 0 ? points.filter(({ P }) => P <= 3 * force) : points;
}

/* The outline of the band of P over the curve's displacements. */
function band(curve) {
  const errors = curve.errors();
  if (errors === null || curve.w === 0) return null;
  const { a_m, delta_m, P_N } = curve.columns(), rows = a_m.map((a, i) => i);
  const edge = (sign) => (i) => ({ a: a_m[i], delta: delta_m[i], P: P_N[i] + sign * errors.P[i] });
  return [...rows.map(edge(1)), ...rows.reverse().map(edge(-1))];
}

/* Measured points with the zero points added; without the machine's own give where that is in them. */
function measured(k) {
  const delta0 = controls.delta0.value, P0 = controls.P0.value, give = byId("recorded").checked ? 1 / k : 0;
  return content.measured.map(({ name, a, delta, P }) => ({
    name,
    points: (a ?? delta ?? P).map((_, i) => {
      const force = P ? P[i] + P0 : NaN;
      return { a: a ? a[i] : NaN, P: force, delta: delta ? delta[i] + delta0 - (give && give * force) : NaN };
    }),
  }));
}

/* ---------------------------------------------------------------- numbers */
function said(point, name) {
  if (point.reason) return `no pull-off under ${NAMES[name]}: ${point.reason}`;
  return `pull-off at ${units.show(point.P, "load")}`;
}

const FAST = content.relaxed === null ? "" : ", very fast cycle";
const HISTORIES = {
  slow: "very slow cycle, relaxed moduli", rest: "at rest, then pulled at once", most: "any other history: at most",
};

/* Where a viscoelastic specimen loses contact by its history, under the chosen control. */
function histories(curve, chosen) {
  if (content.relaxed === null || curve.w === 0) return {};
  const { factor, w } = curve;
  return byHistory(table, w, factor, content.relaxed, controls.rest.value, stiffnessOf(chosen));
}

function numbers(pulls, chosen) {
  const body = byId("pull-offs");
  body.replaceChildren(...Object.entries(pulls).map(([name, point]) => {
    const row = document.createElement("tr"), head = document.createElement("th");
    head.scope = "row";
    head.textContent = { load: "● ", displacement: "■ ", machine: "◆ " }[name] + NAMES[name];
    if (name === "machine") head.textContent += ` k = ${controls.stiffness.text} ${pretty(controls.stiffness.spec.unit)}`;
    row.id = `pull-off-${name}`;
    row.classList.toggle("chosen", name === chosen);
    head.textContent += FAST;
    row.append(head, ...cells(point));
    return row;
  }));
  for (const [name, point] of Object.entries(window.explorer.histories)) {
    const row = document.createElement("tr"), head = document.createElement("th");
    head.scope = "row";
    head.textContent = `${NAMES[chosen]}, ${HISTORIES[name]}`;
    row.id = `history-${name}`;
    row.append(head, ...cells(point));
    body.append(row);
  }
  byId("headline").textContent = said(pulls[chosen], chosen).replace("pull-off at", `Pull-off, ${NAMES[chosen]}${FAST}:`);
}

function cells(point) {
  const make = (text, value) => {
    const cell = document.createElement("td");
    cell.textContent = text;
    if (value !== undefined) Object.assign(cell.dataset, { value });
    return cell;
  };
  if (!point.reason) {
    return QUANTITIES.map(([name, dimension]) => (name in point ? make(units.show(point[name], dimension), point[name]) : make("")));
  }
  const cell = make(point.reason === WETS ? WETS : `none in the series: ${point.reason}`);
  cell.colSpan = QUANTITIES.length;
  return [cell];
}

/* Where JKR holds, and how well the numbers are known. */
function judge(curve, point, chosen) {
  const lines = [], { tabor, R, error, tension } = content, angle = angleOf(curve);
  if (wets(curve)) {
    lines.push(`No such contact: ${WETS}; the tension is ${units.show(tension * curve.factor, "stiffness")}.`);
  } else if (tension) {
    lines.push(`Angle at the edge: ${plain(angle, 3)} rad${angle > content.angle ? ", where small slopes err" : ""}.`);
  }
  if (tabor && curve.w > 0 && !wets(curve)) {
    const number = tabor.number * (curve.w / tabor.w / curve.factor) ** (2 / 3);
    const holds = tabor.limits.find(([limit]) => number > limit)[1], strains = strained(curve.w / curve.factor);
    lines.push(`Tabor number ${plain(number, 3)}: ${strains && strains.size > 0.01 ? "short-range adhesion, but large strains" : holds}.`);
    if (strains) lines.push(`Large strains: ${strains.words}.`);
  }
  if (R && !point.reason) lines.push(`a/R at pull-off: ${plain(point.a / R, 3)}.`);
  lines.push(`Estimated relative error of the solution: ${typeof error === "number" ? error.toExponential(1) : error}.`);
  const read = point.reason ? null : pointError(chosen, curve.w / curve.factor);
  if (read !== null) lines.push(`Of the pull-off force, read between its rows: ${read.toExponential(1)}; jkr pull-off solves it.`);
  byId("judged").textContent = lines.join(" ");
}

/* What large strains change of the pull-off force under load control, in words and its size; null where not known, or
   negligible. */
function strained(w) {
  if (content.strains === null) return null;
  const { unit, rows } = content.strains, wc = unit * Math.cbrt(w), i = rows.findIndex(([at]) => at >= wc);
  if (i < 0) return { words: "their change of the pull-off force is not estimated, and large", size: 1 };
  const [before, after] = [rows[Math.max(i - 1, 0)], rows[i]], part = i ? (wc - before[0]) / (after[0] - before[0]) : 0;
  const [low, high] = [1, 2].map((k) => before[k] + part * (after[k] - before[k]));
  if (Math.max(-low, high) < content.strains.said) return null;
  const percent = (value) => `${value < 0 ? "\u2212" : "+"}${plain(100 * Math.abs(value), 2)}`;
  return { words: `${percent(low)} to ${percent(high)} % of the pull-off force`, size: Math.max(-low, high) };
}

/* The relative error of the pull-off force at a w over the modulus factor: the larger of those on either side. */
function pointError(name, w) {
  const { w: works, [name]: errors } = content.point_errors, i = works.findIndex((one) => one >= w);
  const near = (i < 0 ? [works.length - 1] : [Math.max(i - 1, 0), i]).map((at) => errors[at]).filter((one) => one !== null);
  return near.length ? Math.max(...near) : null;
}

/* ---------------------------------------------------------------- commands and files */
function commands() {
  const factor = controls.factor.value === 1 ? "" : ` --modulus-factor ${controls.factor.text}`;
  const common = `${content.file} --w ${controls.w.quantity}${factor}${content.options}`;
  const rest = controls.rest && controls.rest.value !== 0 ? ` --rest-load ${controls.rest.quantity}` : "";
  const held = ` --stiffness load --stiffness rigid --stiffness ${controls.stiffness.quantity}`;
  return `jkr transform ${common}\njkr pull-off ${common}${held}${rest}`;
}

function save(name, type, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

byId("save-csv").addEventListener("click", () => {
  const { curve } = window.explorer, factor = curve.factor === 1 ? "" : `-modulus${plain(curve.factor, 6)}`;
  save(`${content.stem}-w${plain(curve.w, 6)}${factor}.csv`, "text/csv", curve.csv());
});
byId("save-picture").addEventListener("click", () => {
  const [width, height] = [720, 480];
  Plotly.downloadImage(byId("load-plot"), { format: "svg", width, height, filename: `${content.stem}-curve` });
});
byId("copy").addEventListener("click", async () => {
  const area = byId("commands");
  try {
    await navigator.clipboard.writeText(area.textContent);
  } catch {
    getSelection().selectAllChildren(area);
    document.execCommand("copy");
  }
  byId("copied").textContent = "copied";
  setTimeout(() => { byId("copied").textContent = ""; }, 1500);
});
byId("reset").addEventListener("click", () => {
  Object.values(controls).forEach((control) => control.reset());
  update();
});
for (const input of document.querySelectorAll("input[type=radio], input[type=checkbox]")) {
  input.addEventListener("change", () => changed(input.name));
}

/* ---------------------------------------------------------------- what does not change */
byId("title").textContent = content.title || content.stem;
byId("body").textContent = pretty(content.body);
byId("origin").textContent = `${content.file}: series by ${content.method}, slopes ${content.slopes}, jkr ${content.version}`;
byId("notes").replaceChildren(...content.notes.map((note) => Object.assign(document.createElement("li"), { textContent: note })));
byId("legend").append(...content.measured.map(({ name }, i) => {
  const item = document.createElement("li"), mark = document.createElement("span");
  mark.className = "mark";
  mark.style.color = DATA[i % DATA.length][0];
  mark.textContent = { "circle-open": "○", "triangle-up-open": "△", "square-open": "□" }[DATA[i % DATA.length][1]] ?? "+";
  item.append(mark, name);
  return item;
}));
if (content.measured.length) {
  const drawn = content.measured.reduce((sum, { a, delta, P }) => sum + (a ?? delta ?? P).length, 0);
  byId("thinned").textContent = drawn < content.measured_points ? `${drawn} of ${content.measured_points} measured points are drawn.` : "";
} else {
  document.body.classList.add("no-data");
}
document.body.classList.toggle("elastic", content.relaxed === null);
update();
addEventListener("DOMContentLoaded", update); // the pictures, when their library has been read
