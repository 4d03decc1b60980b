// Interactive curves: a cursor that tells values, by mouse and by keys; curves that can be put out.
"use strict";

const lineColours = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

/** Lines through the points that there are, and a dot for one that has no neighbour: a table of one row is to be seen. */
function curveMarks(points, place, stroke) {
  const dots = [];
  let path = "", last = null, length = 0;
  const end = () => {
    if (length === 1) dots.push(svg("circle", { cx: last[0].toFixed(1), cy: last[1].toFixed(1), r: 3, fill: stroke, class: "dot-of-curve" }));
    length = 0;
  };
  for (const [x, y] of points) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) { end(); continue; }
    last = place(x, y);
    path += `${length++ ? "L" : "M"}${last[0].toFixed(1)} ${last[1].toFixed(1)}`;
  }
  end();
  return [svg("path", { d: path, stroke, class: "curve" }), ...dots];
}

/** { label, xName, x: [..], curves: [{ name, y: [..] }], log, onSelect(i) } as a figure. */
function curvesFigure(plot) {
  const wide = 640, high = 300, left = 78, right = 16, top = 14, bottom = 44;
  const shown = plot.curves.map(() => true);
  // To a reader of screens a slider, which moves the cursor and tells the values there.
  const picture = svg("svg", { viewBox: `0 0 ${wide} ${high}`, role: "slider", tabindex: "0", "aria-valuemin": 1, "aria-valuemax": plot.x.length, "aria-valuenow": 1,
    "aria-valuetext": "no value is read yet", "aria-label": `${plot.label}: ${plot.curves.map((c) => c.name).join(", ")} against ${plot.xName}` });
  const values = element("output", { class: "values", "aria-live": "off" });
  const value = (y) => plot.log ? (y > 0 ? Math.log10(y) : NaN) : y;
  let at = -1, place = null;

  function draw() {
    picture.replaceChildren();
    const ys = plot.curves.flatMap((c, i) => shown[i] ? c.y.map(value).filter(Number.isFinite) : []);
    const xs = plot.x.filter(Number.isFinite);
    let [xLow, xHigh] = [Math.min(...xs), Math.max(...xs)];
    let [yLow, yHigh] = ys.length ? [Math.min(...ys), Math.max(...ys)] : [0, 1];
    if (!(xHigh > xLow)) xHigh = xLow + 1;
    const air = yHigh > yLow ? 0.05 * (yHigh - yLow) : Math.abs(yLow) * 0.5 || 1;
    yLow -= air, yHigh += air;
    place = (x, y) => [left + (wide - left - right) * (x - xLow) / (xHigh - xLow),
      top + (high - top - bottom) * (yHigh - y) / (yHigh - yLow)];
    for (const x of ticksAcross(xLow, xHigh, 6, wide - left - right, 5)) {
      const [px] = place(x, yLow);
      picture.append(svg("line", { x1: px, x2: px, y1: top, y2: high - bottom, class: "grid" }),
        svg("text", { x: px, y: high - bottom + 16, "text-anchor": "middle" }, text(x, 5)));
    }
    for (const y of ticks(yLow, yHigh, 5)) {
      if (plot.log && y !== Math.round(y)) continue;
      const [, py] = place(xLow, y);
      picture.append(svg("line", { x1: left, x2: wide - right, y1: py, y2: py, class: "grid" }),
        svg("text", { x: left - 7, y: py + 4, "text-anchor": "end" }, plot.log ? `1e${y}` : text(y, 5)));
    }
    picture.append(svg("text", { x: (left + wide - right) / 2, y: high - 8, "text-anchor": "middle" }, plot.xName));
    plot.curves.forEach((curve, i) => {
      if (!shown[i]) return;
      const points = curve.y.map((y, k) => [plot.x[k], value(y)]);
      picture.append(...curveMarks(points, place, lineColours[i % lineColours.length]));
    });
    cursor();
  }

  function cursor() {
    picture.querySelectorAll(".cursor").forEach((old) => old.remove());
    if (at < 0) { values.textContent = ""; return; }
    const [px] = place(plot.x[at], 0);
    picture.append(svg("line", { x1: px, x2: px, y1: top, y2: high - bottom, class: "cursor" }));
    plot.curves.forEach((curve, i) => {
      const v = value(curve.y[at]);
      if (!shown[i] || !Number.isFinite(v)) return;
      const [cx, cy] = place(plot.x[at], v);
      picture.append(svg("circle", { cx, cy, r: 4, fill: lineColours[i % lineColours.length], class: "cursor" }));
    });
    values.textContent = `${plot.xName} = ${text(plot.x[at], 6)}:  ` + plot.curves
      .filter((_, i) => shown[i]).map((c) => `${c.name} = ${text(c.y[at], 6)}`).join(",  ");
    picture.setAttribute("aria-valuenow", at + 1);
    picture.setAttribute("aria-valuetext", values.textContent);
  }

  function moveTo(i) {
    at = Math.max(0, Math.min(plot.x.length - 1, i));
    cursor();
    if (plot.onSelect) plot.onSelect(plot.x[at]);
  }
  picture.addEventListener("pointermove", (event) => {
    const box = picture.getBoundingClientRect(), x = (event.clientX - box.left) * wide / box.width;
    let best = 0;
    plot.x.forEach((value, i) => {
      if (Math.abs(place(value, 0)[0] - x) < Math.abs(place(plot.x[best], 0)[0] - x)) best = i;
    });
    moveTo(best);
  });
  picture.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1, Home: -Infinity, End: Infinity }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    moveTo(at + step);
  });
  const legend = element("div", { class: "legend" }, ...plot.curves.map((curve, i) => {
    const box = element("input", { type: "checkbox", checked: true,
      onchange: () => { shown[i] = box.checked; draw(); } });
    return element("label", {}, box, element("span", { class: "key", style: `background:${lineColours[i % lineColours.length]}` }), curve.name);
  }));
  draw();
  return element("figure", { class: "curves" }, element("figcaption", {}, plot.label), picture, legend, values,
    numbersTable(plot));
}

/** The numbers behind curves, folded away. */
function numbersTable(plot) {
  const details = element("details", {}, element("summary", {}, "the numbers"));
  details.addEventListener("toggle", () => {
    if (!details.open || details.children.length > 1) return;
    details.append(table([plot.xName, ...plot.curves.map((c) => c.name)],
      plot.x.map((x, i) => [x, ...plot.curves.map((c) => c.y[i])].map((v) => text(v, 8)))));
  });
  return details;
}

/** A table of texts and elements. */
function table(heads, rows, caption = null) {
  return element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption || "table" },
    element("table", {}, caption ? element("caption", {}, caption) : null,
      element("thead", {}, element("tr", {}, ...heads.map((h) => element("th", { scope: "col" }, h)))),
      element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map((cell) => element("td", {}, cell)))))));
}

/** Several curves with an x of each (graphs of laws, kernels): NaN lifts the pen. */
function graphFigure(label, xName, yName, points, note = "") {
  const wide = 300, high = 210, left = 62, right = 12, top = 12, bottom = 38;
  const finite = points.filter(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
  let [xLow, xHigh] = [Math.min(...finite.map((p) => p[0])), Math.max(...finite.map((p) => p[0]))];
  let [yLow, yHigh] = [Math.min(...finite.map((p) => p[1])), Math.max(...finite.map((p) => p[1]))];
  if (!(xHigh > xLow)) xHigh = xLow + 1;
  if (!(yHigh > yLow)) yLow -= 1, yHigh += 1;
  const air = 0.06 * (yHigh - yLow);
  yLow -= air, yHigh += air;
  const place = (x, y) => [left + (wide - left - right) * (x - xLow) / (xHigh - xLow),
    top + (high - top - bottom) * (yHigh - y) / (yHigh - yLow)];
  const picture = svg("svg", { viewBox: `0 0 ${wide} ${high}`, role: "img", "aria-label": `${label}: ${yName} against ${xName}` });
  for (const x of ticksAcross(xLow, xHigh, 4, wide - left - right)) {
    const [px] = place(x, 0);
    picture.append(svg("line", { x1: px, x2: px, y1: top, y2: high - bottom, class: "grid" }),
      svg("text", { x: px, y: high - bottom + 14, "text-anchor": "middle" }, text(x)));
  }
  for (const y of ticks(yLow, yHigh, 4)) {
    const [, py] = place(xLow, y);
    picture.append(svg("line", { x1: left, x2: wide - right, y1: py, y2: py, class: "grid" }),
      svg("text", { x: left - 5, y: py + 4, "text-anchor": "end" }, text(y)));
  }
  picture.append(...curveMarks(points, place, lineColours[0]),
    svg("text", { x: (left + wide - right) / 2, y: high - 6, "text-anchor": "middle" }, xName));
  return element("figure", { class: "graph" }, element("figcaption", {}, label), picture,
    note ? element("p", { class: "note" }, note) : null);
}
