// The sections of the page, each from what the report has of it.
"use strict";

/** A section with its link in the menu. */
function section(id, title, ...content) {
  document.querySelector("nav ul").append(element("li", {}, element("a", { href: `#${id}` }, title)));
  const out = element("section", { id, "aria-labelledby": `${id}-title` },
    element("h2", { id: `${id}-title` }, title), ...content);
  document.querySelector("main").append(out);
  return out;
}

const badge = (good, words) => element("strong", { class: good ? "good" : "bad" }, words);

function headSection() {
  document.title = `${report.title}: report`;
  const head = document.querySelector("header");
  head.append(element("h1", {}, report.title), element("p", { class: "subtitle" }, report.script));
  const run = report.result, verdicts = element("p", { class: "verdicts" });
  if (run) verdicts.append(badge(run.certificate.certified, run.certificate.certified ? "every step certified" : "not certified"), ` ${run.unknowns} unknowns, ${run.steps} steps `);
  if (report.hypotheses) {
    const verdict = report.hypotheses.verdict;
    verdicts.append(element("span", {}, `on this mesh: ${verdict.discrete.says}; continuous problem: ${verdict.continuous.says}`));
  }
  head.append(verdicts);
}

function modelSection() {
  const model = report.model;
  if (!model) return;
  const out = section("model", "The model");
  if (model.find) out.append(element("div", { class: "problem scroll", tabindex: "0", role: "region", "aria-label": "the inequality" }, mathematics(model.find, true)));
  if (model.declarations.length)
    out.append(element("ul", { class: "declarations" }, ...model.declarations.map((d) =>
      element("li", {}, element("span", { class: "what" }, d.what), mathematics(d.mathematics)))));
  const graphs = element("div", { class: "graphs" });
  for (const law of model.laws)
    graphs.append(graphFigure(law.unit ? `${law.name}: ${law.multiplier}` : law.name, law.argument, law.multiplier, law.graph, law.note));
  for (const kernel of model.kernels)
    graphs.append(graphFigure(`kernel ${kernel.name}`, "t − s" + unitOf("time"), "q", kernel.graph, kernel.note));
  out.append(graphs);
  if (report.parameters.length)
    out.append(table(["parameter", "value", ""], report.parameters.map((p) => [p.name, String(p.value), p.doc]), "Parameters"));
}

function hypothesesSection() {
  const h = report.hypotheses;
  if (!h) return;
  const word = (holds) => holds === true ? badge(true, "holds") : holds === false ? badge(false, "fails") : element("span", {}, "open");
  section("hypotheses", "Hypotheses of the theorem",
    element("p", {}, `On this mesh: ${h.verdict.discrete.says}. Continuous problem: ${h.verdict.continuous.says}.`),
    table(["hypothesis", "what is asked", "value", "verdict", "line", "note"], h.hypotheses.map((one) =>
      [one.name, one.bound, text(one.value), word(one.holds), one.line ? String(one.line) : "", one.note || ""])));
}

/** Apart: both the plan and the seconds have `sweeps`. */
const numbersOf = (of, head, caption) =>
  table(head, Object.entries(of).filter(([, v]) => typeof v === "number").map(([k, v]) => [k.replaceAll("_", " "), text(v)]), caption);

function planSection() {
  const run = report.result;
  if (!run || !run.plan) return;
  const plan = run.plan;
  section("plan", "Plan and cost",
    table(["effect", "state", "line", "why"], (plan.effects || []).map((e) => [e.name, e.state, e.line ? String(e.line) : "", e.why || ""]), "Effects"),
    numbersOf(plan, ["what", "number"], "Work"), numbersOf(run.timing, ["phase", "seconds"], "CPU time"));
}

function certificateSection() {
  const run = report.result;
  if (!run) return;
  const c = run.certificate;
  const out = section("certificate", "Certificate and conditioning",
    table(["what", "value"], Object.entries(c).filter(([, v]) => typeof v !== "object" || v === null).map(([k, v]) => [k.replaceAll("_", " "), typeof v === "number" ? text(v) : String(v)])));
  const m = report.monitors;
  if (!m) return;
  const chosen = m.names.map((name, i) => [name, i]).filter(([name]) => m.certificate.includes(name));
  if (chosen.length)
    out.append(curvesFigure({ label: "Certificate, step by step", xName: timeName, x: m.times, log: true,
      curves: chosen.map(([name, i]) => ({ name, y: m.columns[i] })) }));
}

function tablesSection() {
  const run = report.result;
  const names = run && run.table ? Object.keys(run.table).filter((n) => n !== "t") : [];
  if (names.length === 0) return;
  const out = section("tables", "Tables");
  const figures = element("div", { class: "plots" });
  const columns = names.filter((n) => n !== "event");
  if (run.table.t.length > 1)
    for (const name of columns)
      figures.append(curvesFigure({ label: withUnit(name), xName: timeName, x: run.table.t, curves: [{ name: withUnit(name), y: run.table[name] }],
        onSelect: (t) => document.dispatchEvent(new CustomEvent("show-time", { detail: t })) }));
  out.append(figures);
  if (run.table.t.length > 1 && columns.length > 1) out.append(phaseFigure(run.table, columns));
  out.append(table(["column", "last value"], names.map((n) => [withUnit(n), text(run.table[n].at(-1), 8)])));
}

/** One column against another. */
function phaseFigure(values, names) {
  const choice = (start) => element("select", {}, ...names.map((n, i) => element("option", { value: n, selected: i === start }, n)));
  const x = choice(0), y = choice(1), place = element("div");
  const draw = () => place.replaceChildren(graphFigure(`${withUnit(y.value)} against ${withUnit(x.value)}`, withUnit(x.value), withUnit(y.value),
    values[x.value].map((v, i) => [v, values[y.value][i]])));
  x.addEventListener("change", draw);
  y.addEventListener("change", draw);
  draw();
  return element("div", { class: "phase" }, element("label", {}, "across ", x), element("label", {}, " up ", y), place);
}

function energiesSection() {
  const m = report.monitors;
  if (!m) return;
  const chosen = m.names.map((name, i) => [name, i]).filter(([name]) => !m.certificate.includes(name));
  const plots = element("div", { class: "plots" });
  const energies = chosen.filter(([name]) => m.energies.includes(name));
  if (energies.length) plots.append(curvesFigure({ label: "Energies" + unitOf("energy"), xName: timeName, x: m.times, curves: energies.map(([name, i]) => ({ name, y: m.columns[i] })) }));
  const others = chosen.filter(([name]) => !m.energies.includes(name));
  if (others.length) plots.append(curvesFigure({ label: "Quantities of the a-priori bounds", xName: timeName, x: m.times, curves: others.map(([name, i]) => ({ name, y: m.columns[i] })) }));
  section("energies", "Energies", element("p", {}, `The balance of work closes to ${text(m.balance_error)} of its parts.`), plots);
}

/** Studies and reports of stability: their JSON as tables, with a curve of what accuracy costs. */
function studySection() {
  const s = report.study;
  if (!s) return;
  const sweep = s.reference === "none", left = sweep ? ["order", "front"] : [];
  const numbers = (row) => Object.fromEntries(Object.entries(row).filter(([k, v]) => !left.includes(k) && (v === null || typeof v !== "object")));
  const words = { cpu: "CPU seconds", wall: "seconds", order: "observed order" };
  const withUnitOf = (kind) => (name) => { const unit = ((s.units_by_kind || {})[kind] || {})[name]; return unit && unit !== "1" ? `${name} [${unit}]` : name; };
  // Kind by kind: a parameter may be called `order` or as a column.
  const kinds = [[(row) => row.params, withUnitOf("params")], [(row) => row.probes, withUnitOf("columns")], [numbers, (name) => words[name] || name.replaceAll("_", " ")],
    [(row) => row.error || {}, (name) => `error ${name.replaceAll("_", " ")}`]];
  const heads = [], cells = s.rows.map(() => []);
  for (const [read, head] of kinds)
    for (const name of new Set(s.rows.flatMap((row) => Object.keys(read(row))))) {
      heads.push(head(name));
      s.rows.forEach((row, i) => { const value = read(row)[name]; cells[i].push(value === undefined ? "" : text(value)); });
    }
  const out = section("study", "What accuracy costs", element("p", {}, sweep ? "The columns at the end for each setting." : `Errors against ${s.reference}.`), table(heads, cells));
  const points = s.rows.filter((r) => r.cpu > 0 && r.error && r.error.V_max > 0).map((r) => [Math.log10(r.cpu), Math.log10(r.error.V_max)]).sort((a, b) => a[0] - b[0]);
  if (points.length > 1) out.append(graphFigure("Error in V against CPU seconds", "log₁₀ seconds", "log₁₀ error", points));
}

const cell = (v) => v !== null && typeof v === "object" ? JSON.stringify(v) : text(v);

function stabilitySection() {
  const s = report.stability;
  if (!s) return;
  const out = section("stability", "How far the model can be trusted");
  for (const [name, value] of Object.entries(s)) {
    if (value === null || name === "schema") continue;
    if (name === "monitors") {
      out.append(curvesFigure({ label: "Step by step", xName: "t" + (s.units && s.units.t ? ` [${s.units.t}]` : ""), x: value.t,
        curves: Object.entries(value).filter(([k, v]) => !["t", "inclusion", "equilibrium"].includes(k) && v.length === value.t.length).map(([k, v]) => ({ name: k.replaceAll("_", " "), y: v })) }));
    } else if (Array.isArray(value) && value.length && typeof value[0] === "object" && value[0] !== null) {
      const heads = [...new Set(value.flatMap(Object.keys))];
      out.append(table(heads, value.map((row) => heads.map((h) => cell(row[h]))), name));
    } else if (typeof value !== "object") {
      out.append(element("p", {}, `${name.replaceAll("_", " ")}: `, element("strong", {}, text(value))));
    } else if (!Array.isArray(value)) {
      out.append(table(["what", "value"], Object.entries(value).map(([k, v]) => [k.replaceAll("_", " "), cell(v)]), name));
    }
  }
}

function sourceSection() {
  const lines = report.source.replace(/\n$/, "").split("\n");
  section("source", "The script", element("pre", { tabindex: "0" },
    ...lines.map((line, i) => element("span", { id: `line-${i + 1}`, class: "line" }, line + "\n"))));
}
