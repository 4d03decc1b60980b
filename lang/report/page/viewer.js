// The body in space: turn, move, cut, deform, contours, a probe, time, forces and branches of laws.
"use strict";

class Viewer {
  constructor(fields, points, cells) {
    this.fields = fields;
    this.points = points;
    this.cells = cells;
    this.skin = skinOf(cells, fields.dim);
    this.edges = featureEdges(this.skin, points, fields.dim);
    this.state = { frame: fields.frames.length - 1, quantity: 0, factor: 1, contours: 0, cut: "none", cutAt: 0.5, forces: false, dots: false, mesh: false, fixed: false };
    this.box = [0, 1, 2].map((k) => {
      let low = Infinity, high = -Infinity;
      for (let i = k; i < points.length; i += 3) { low = Math.min(low, points[i]); high = Math.max(high, points[i]); }
      return [low, high];
    });
    this.size = Math.hypot(...this.box.map(([low, high]) => high - low)) || 1;
    this.view = { turn: [0.6, 0.45], zoom: 1, shift: [0, 0] };
    this.decoded = new Map();
    this.quantities = fields.arrays.flatMap((array, a) => quantitiesOf(array, fields).map(([name, read]) => ({ name, read, array: a })));
    this.moves = fields.arrays.findIndex((array) => array.name === "displacement");
    const first = this.quantities.findIndex((q) => fields.arrays[q.array].name !== "displacement" && fields.arrays[q.array].components === 9);
    this.state.quantity = Math.max(0, first);
    this.build();
    this.reset();
  }

  // --- data ------------------------------------------------------------------------------------

  async arrayOf(frame, a) {
    const id = this.fields.frames[frame].data[a];
    if (!this.decoded.has(id)) {
      if (this.decoded.size > 24) this.decoded.clear();
      this.decoded.set(id, floats(id));
    }
    return this.decoded.get(id);
  }

  /** The chosen quantity at every node. */
  async valuesOf(frame) {
    const q = this.quantities[this.state.quantity], data = await this.arrayOf(frame, q.array);
    const out = new Float32Array(this.points.length / 3);
    for (let i = 0; i < out.length; ++i) out[i] = q.read(data, i);
    return out;
  }

  async movedPoints(frame) {
    if (this.moves < 0 || this.state.factor === 0) return this.points;
    const by = await this.arrayOf(frame, this.moves), out = this.points.slice();
    for (let i = 0; i < out.length; ++i) out[i] += this.state.factor * by[i];
    return out;
  }

  /** Makes what is drawn from the state; then draws it. Calls that overlap: the last one counts. */
  async update() {
    const turn = this.turnNumber = (this.turnNumber || 0) + 1, frame = this.state.frame;
    const [values, moved] = await Promise.all([this.valuesOf(frame), this.movedPoints(frame)]);
    const range = this.state.fixed ? await this.rangeOfAll() : rangeOf(values);
    const laws = this.state.forces || this.state.dots ? await this.lawsAt(frame) : [];
    if (turn !== this.turnNumber) return;
    this.now = { values, moved, scale: colourScale(...range), laws };
    this.makeSurface();
    this.makeCut();
    this.makeLaws();
    this.showBar();
    this.say();
    this.draw();
  }

  async rangeOfAll() {
    this.ranges ??= new Map();
    if (!this.ranges.has(this.state.quantity)) {
      let range = [Infinity, -Infinity];
      for (let f = 0; f < this.fields.frames.length; ++f)
        range = rangeOf(await this.valuesOf(f), range);
      this.ranges.set(this.state.quantity, range);
    }
    return this.ranges.get(this.state.quantity);
  }

  async lawsAt(frame) {
    return Promise.all(this.fields.frames[frame].laws.map(async (law) => ({
      name: law.name, points: await floats(law.points), force: law.force && await floats(law.force),
      moved: law.displacement && await floats(law.displacement), branch: law.branch && await floats(law.branch) })));
  }

  // --- what is drawn -----------------------------------------------------------------------------

  makeSurface() {
    const { moved, values } = this.now, n = this.skin.length;
    const points = new Float32Array(3 * n), numbers = new Float32Array(n);
    for (let i = 0; i < n; ++i) {
      const node = this.skin[i];
      points.set(moved.subarray(3 * node, 3 * node + 3), 3 * i);
      numbers[i] = values[node];
    }
    const normals = this.fields.dim === 3 ? cornerNormals(this.skin, moved) : null;
    const lines = new Float32Array(3 * this.edges.length);
    this.edges.forEach((node, i) => lines.set(moved.subarray(3 * node, 3 * node + 3), 3 * i));
    const { painter } = this;
    for (const old of [this.surface, this.lines, this.meshLines]) painter.release(old);
    this.surface = painter.thing("triangles", points, normals, numbers);
    this.lines = painter.thing("lines", lines);
    this.meshLines = null;
    if (!this.state.mesh) return;
    const all = new Float32Array(6 * n);
    for (let t = 0; t < n; t += 3)
      for (let k = 0; k < 3; ++k) {
        all.set(points.subarray(3 * (t + k), 3 * (t + k) + 3), 6 * (t + k));
        const next = t + (k + 1) % 3;
        all.set(points.subarray(3 * next, 3 * next + 3), 6 * (t + k) + 3);
      }
    this.meshLines = painter.thing("lines", all);
  }

  plane() {
    if (this.state.cut === "none") return null;
    const k = "xyz".indexOf(this.state.cut), [low, high] = this.box[k], normal = [0, 0, 0];
    normal[k] = 1;
    return [...normal, low + this.state.cutAt * (high - low)];
  }

  makeCut() {
    this.painter.release(this.cap);
    this.cap = null;
    const plane = this.plane();
    if (!plane || this.fields.dim !== 3) return;
    const cut = cutThrough(this.cells, this.now.moved, this.now.values, plane.slice(0, 3), plane[3]);
    const normals = new Float32Array(cut.points.length);
    for (let i = 0; i < normals.length; ++i) normals[i] = plane[i % 3];
    this.cap = this.painter.thing("triangles", cut.points, normals, cut.values);
  }

  makeLaws() {
    for (const old of [this.arrows, ...(this.dots || []).map((d) => d.thing)]) this.painter.release(old);
    this.arrows = null;
    this.dots = [];
    const points = [], normals = [], by = branches.map(() => []), seen = new Set();
    let largest = 0;
    for (const law of this.now.laws)
      for (let i = 0; law.force && i < law.force.length; i += 3) largest = Math.max(largest, Math.hypot(law.force[i], law.force[i + 1], law.force[i + 2]));
    for (const law of this.now.laws) {
      for (let i = 0; i < law.points.length; i += 3) {
        const at = [0, 1, 2].map((k) => law.points[i + k] + (law.moved ? this.state.factor * law.moved[i + k] : 0));
        if (this.state.dots && law.branch) { by[law.branch[i / 3]].push(...at); seen.add(law.branch[i / 3]); }
        if (!this.state.forces || !law.force || !(largest > 0)) continue;
        const force = [law.force[i], law.force[i + 1], law.force[i + 2]];
        if (Math.hypot(...force) < 0.02 * largest) continue;
        addArrow(points, normals, at.map((x, k) => x - 0.16 * this.size * force[k] / largest), at, 0.006 * this.size);
      }
    }
    if (points.length) this.arrows = this.painter.thing("triangles", Float32Array.from(points), Float32Array.from(normals));
    by.forEach((list, b) => { if (list.length) this.dots.push({ branch: b, thing: this.painter.thing("dots", Float32Array.from(list)) }); });
    this.legend.replaceChildren(...[...seen].sort().map((b) => element("label", {}, element("span", { class: "dot", style: `background:${branches[b][1]}` }), branches[b][0])));
  }

  // --- the view ----------------------------------------------------------------------------------

  matrix() {
    if (this.fields.dim < 3) return [1, 0, 0, 0, 1, 0, 0, 0, 1];
    const [turn, tilt] = this.view.turn, [c, s, ct, st] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
    const toward = [s * ct, st, c * ct], right = [c, 0, -s];
    const up = [toward[1] * right[2] - toward[2] * right[1], toward[2] * right[0] - toward[0] * right[2], toward[0] * right[1] - toward[1] * right[0]];
    return [right[0], up[0], toward[0], right[1], up[1], toward[1], right[2], up[2], toward[2]]; // by columns
  }

  reset() {
    this.view = { turn: [0.6, 0.45], zoom: 1, shift: [0, 0] };
    this.fit();
  }
  /** Plane coordinates of the view's box at the initial turn decide the scale. */
  fit() {
    const m = this.matrix(), low = [Infinity, Infinity], high = [-Infinity, -Infinity], mid = this.box.map(([a, b]) => (a + b) / 2);
    for (let corner = 0; corner < 8; ++corner)
      for (let r = 0; r < 2; ++r) {
        let x = 0;
        for (let k = 0; k < 3; ++k) x += m[3 * k + r] * (this.box[k][corner >> k & 1] - mid[k]);
        low[r] = Math.min(low[r], x), high[r] = Math.max(high[r], x);
      }
    this.extent = [high[0] - low[0], high[1] - low[1]];
    this.centre = mid;
  }
  scale() {
    const { clientWidth: wide, clientHeight: high } = this.canvas;
    const pixels = 0.82 * this.view.zoom * Math.min(wide / (this.extent[0] || 1), high / (this.extent[1] || 1));
    return { pixels, scale: [2 * pixels / wide, 2 * pixels / high] };
  }

  draw() {
    if (!this.now) return;
    const ratio = window.devicePixelRatio || 1, { canvas, painter } = this;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    painter.begin({ turn: this.matrix(), centre: this.centre, scale: this.scale().scale, shift: this.view.shift, depth: 0.4 / this.size });
    const lit = this.fields.dim === 3, { scale } = this.now, contours = this.state.contours, plane = this.plane();
    painter.draw(this.surface, { scale, contours, lit, plane });
    painter.draw(this.cap, { scale, contours, lit: false, nearer: 1e-4 });
    painter.draw(this.meshLines, { colour: [0.25, 0.25, 0.28], nearer: 5e-4, plane });
    painter.draw(this.lines, { colour: [0.1, 0.1, 0.12], nearer: 1e-3, plane });
    painter.draw(this.arrows, { colour: [0.78, 0.16, 0.12], lit, nearer: lit ? 0 : 2e-3 });
    for (const { branch, thing } of this.dots || [])
      painter.draw(thing, { colour: [1, 3, 5].map((k) => parseInt(branches[branch][1].slice(k, k + 2), 16) / 255), dots: 9 * ratio, nearer: 3e-3 });
  }

  /** The value under a place of the canvas. */
  probe(x, y) {
    const box = this.canvas.getBoundingClientRect(), m = this.matrix(), { scale } = this.scale();
    const px = (2 * (x - box.left) / box.width - 1 - this.view.shift[0]) / scale[0];
    const py = (1 - 2 * (y - box.top) / box.height - this.view.shift[1]) / scale[1];
    const { moved } = this.now, seen = new Float32Array(moved.length);
    for (let i = 0; i < moved.length; i += 3)
      for (let r = 0; r < 3; ++r) {
        let sum = 0;
        for (let k = 0; k < 3; ++k) sum += m[3 * k + r] * (moved[i + k] - this.centre[k]);
        seen[i + r] = sum;
      }
    const found = hit(this.skin, seen, px, py);
    if (!found) return this.tellProbe(null);
    const mean = (read) => found.weights.reduce((s, w, k) => s + w * read(found.nodes[k]), 0);
    this.tellProbe([0, 1, 2].map((k) => mean((i) => this.points[3 * i + k])), mean((i) => this.now.values[i]));
  }
  tellProbe(point, value) {
    const { name, array } = this.quantities[this.state.quantity];
    this.probed.textContent = point ? `at (${point.slice(0, this.fields.dim).map((x) => text(x)).join(", ")})${unitOf("length")}: ${name} = ${text(value, 6)}${this.fields.arrays[array].unit}` : "nothing there";
  }
  /** The value at the node nearest to coordinates, for those who type. */
  probeAt(point) {
    let best = 0, least = Infinity;
    for (let i = 0; i < this.points.length; i += 3) {
      const d = Math.hypot(...point.map((x, k) => this.points[i + k] - x));
      if (d < least) least = d, best = i / 3;
    }
    this.tellProbe([...this.points.subarray(3 * best, 3 * best + 3)], this.now.values[best]);
  }

  showBar() {
    const { scale } = this.now, context = this.bar.getContext("2d"), list = lookup[scale.list];
    this.bar.width = 16, this.bar.height = 200;
    for (let row = 0; row < 200; ++row) {
      const value = scale.high + (scale.low - scale.high) * (row + 0.5) / 200;
      const i = Math.round(255 * Math.max(0, Math.min(1, (value - scale.from) / (scale.to - scale.from))));
      context.fillStyle = `rgb(${list[4 * i]},${list[4 * i + 1]},${list[4 * i + 2]})`;
      context.fillRect(0, row, 16, 1);
    }
    this.numbers.replaceChildren(...[1, 0.75, 0.5, 0.25, 0].map((p) => element("span", {}, text(scale.low + p * (scale.high - scale.low)))));
    const { name, array } = this.quantities[this.state.quantity];
    this.barName.textContent = name + this.fields.arrays[array].unit;
    this.meansNote.textContent = this.fields.arrays[array].means ? "means at nodes" : "";
  }
  say() {
    const { scale } = this.now, time = `t = ${text(this.fields.frames[this.state.frame].t)}${unitOf("time")}`;
    const { name, array } = this.quantities[this.state.quantity];
    this.timeText.textContent = time;
    this.canvas.setAttribute("aria-label", `The body, coloured by ${name}, from ${text(scale.low)} to ${text(scale.high)}${this.fields.arrays[array].unit}, at ${time}. Arrow keys turn it, plus and minus zoom, 0 shows all, comma and full stop go through time, space plays.`);
  }

  // --- controls ----------------------------------------------------------------------------------

  build() {
    const { fields, state } = this, frames = fields.frames.length;
    this.canvas = element("canvas", { tabindex: "0", role: "application", "aria-roledescription": "body that can be turned" });
    this.bar = element("canvas", { "aria-hidden": "true" });
    this.numbers = element("div", { class: "numbers" });
    this.barName = element("div", {});
    this.meansNote = element("div", { class: "means" });
    this.probed = element("output", { class: "values", "aria-live": "polite" });
    this.legend = element("div", {});
    this.timeText = element("output", {});
    const set = (change) => { Object.assign(this.state, change); return this.update(); };
    const check = (name, key, id) => element("label", {}, element("input", { type: "checkbox", id, onchange: (e) => set({ [key]: e.target.checked }) }), ` ${name}`);
    const choose = (id, options, chosen, then) => element("select", { id, onchange: (e) => then(e.target.value) }, ...options.map(([value, name]) => element("option", { value, selected: value === chosen }, name)));
    this.slider = element("input", { type: "range", id: "time", min: 0, max: frames - 1, value: state.frame, "aria-label": "time", oninput: (e) => set({ frame: Number(e.target.value) }) });
    this.play = element("button", { id: "play", type: "button", onclick: () => this.toggle() }, "play");
    const factor = element("input", { type: "number", id: "factor", step: "any", value: state.factor, onchange: (e) => set({ factor: Number(e.target.value) || 0 }) });
    const cutAt = element("input", { type: "range", id: "cut-at", min: 0, max: 1, step: 0.005, value: state.cutAt, "aria-label": "where the cut is", oninput: (e) => set({ cutAt: Number(e.target.value) }) });
    const coordinates = Array.from({ length: fields.dim }, (_, k) => element("input", { type: "number", step: "any", value: (this.box[k][0] + this.box[k][1]) / 2, "aria-label": `${"xyz"[k]} of the place that is read` }));
    const group = (legend, ...content) => element("fieldset", {}, element("legend", {}, legend), ...content);
    const panel = element("div", { class: "panel" },
      group("Field", element("label", {}, "colours ", choose("quantity", this.quantities.map((q, i) => [String(i), q.name]), String(state.quantity), (v) => set({ quantity: Number(v) }))),
        check("colours of all times", "fixed", "fixed"),
        element("label", {}, "contours ", choose("contours", [["0", "none"], ["8", "8"], ["16", "16"], ["32", "32"]], "0", (v) => set({ contours: Number(v) })))),
      group("Shape", this.moves < 0 ? null : element("label", {}, "deformed, times", factor),
        check("mesh", "mesh", "mesh"),
        element("label", {}, "cut ", choose("cut", [["none", "none"], ...[..."xyz"].slice(0, fields.dim).map((c) => [c, `across ${c}`])], "none", (v) => set({ cut: v }))), cutAt),
      fields.frames[0].laws.length === 0 ? null : group("Contact", check("forces on the body", "forces", "forces"), check("branches of the laws", "dots", "dots"), this.legend),
      group("Probe", ...coordinates, element("button", { type: "button", id: "probe", onclick: () => this.probeAt(coordinates.map((c) => Number(c.value))) }, "value there"), this.probed),
      element("button", { type: "button", id: "reset", onclick: () => { this.reset(); this.draw(); } }, "whole body"),
      element("button", { type: "button", id: "save", onclick: () => this.save() }, "save as PNG"));
    const time = element("div", { class: "time" }, this.play, this.slider, this.timeText);
    const stage = element("div", { class: "stage" }, this.canvas, element("div", { class: "bar" }, element("div", {}, this.barName, element("div", { style: "display:flex;gap:6px" }, this.bar, this.numbers), this.meansNote)));
    this.element = element("div", { class: "viewer" }, element("div", {}, stage, frames > 1 ? time : null), panel);
    this.painter = new Painter(this.canvas);
    this.listen();
  }

  listen() {
    const { canvas } = this;
    let drag = null;
    canvas.addEventListener("pointerdown", (e) => {
      canvas.setPointerCapture(e.pointerId);
      drag = { x: e.clientX, y: e.clientY, moved: false, shift: e.shiftKey || e.button === 2 || this.fields.dim < 3 };
    });
    canvas.addEventListener("pointermove", (e) => {
      if (!drag) return;
      const dx = e.clientX - drag.x, dy = e.clientY - drag.y;
      if (!drag.moved && Math.hypot(dx, dy) < 3) return;
      Object.assign(drag, { x: e.clientX, y: e.clientY, moved: true });
      if (drag.shift) this.move(2 * dx / canvas.clientWidth, -2 * dy / canvas.clientHeight);
      else this.turn(-0.01 * dx, 0.01 * dy);
    });
    canvas.addEventListener("pointerup", (e) => {
      if (drag && !drag.moved) this.probe(e.clientX, e.clientY);
      drag = null;
    });
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => { e.preventDefault(); this.zoom(Math.exp(-0.001 * e.deltaY)); }, { passive: false });
    const step = (by) => () => this.show(this.state.frame + by);
    const keys = { ArrowLeft: () => this.turn(-0.1, 0), ArrowRight: () => this.turn(0.1, 0), ArrowUp: () => this.turn(0, 0.1), ArrowDown: () => this.turn(0, -0.1),
      "+": () => this.zoom(1.2), "=": () => this.zoom(1.2), "-": () => this.zoom(1 / 1.2), 0: () => { this.reset(); this.draw(); }, ",": step(-1), ".": step(1), " ": () => this.toggle() };
    canvas.addEventListener("keydown", (e) => {
      if (!keys[e.key] || e.ctrlKey || e.altKey || e.metaKey) return;
      e.preventDefault();
      keys[e.key]();
    });
    document.addEventListener("show-time", (e) => {
      const nearest = this.fields.frames.reduce((best, f, i, all) => Math.abs(f.t - e.detail) < Math.abs(all[best].t - e.detail) ? i : best, 0);
      if (nearest !== this.state.frame) this.show(nearest);
    });
    new ResizeObserver(() => this.draw()).observe(canvas);
  }
  turn(by, tilt) {
    if (this.fields.dim < 3) return this.move(-by, -tilt);
    this.view.turn = [this.view.turn[0] + by, Math.max(-1.57, Math.min(1.57, this.view.turn[1] + tilt))];
    this.draw();
  }
  move(x, y) {
    this.view.shift = [this.view.shift[0] + x, this.view.shift[1] + y];
    this.draw();
  }
  zoom(by) {
    this.view.zoom *= by;
    this.view.shift = this.view.shift.map((s) => s * by);
    this.draw();
  }
  show(frame) {
    const n = this.fields.frames.length;
    this.state.frame = (frame + n) % n;
    this.slider.value = this.state.frame;
    return this.update();
  }
  toggle() {
    this.playing = !this.playing;
    this.play.textContent = this.playing ? "stop" : "play";
    const next = async () => {
      if (!this.playing) return;
      await this.show(this.state.frame + 1);
      setTimeout(next, 120);
    };
    next();
  }
  save() {
    const link = element("a", { href: this.canvas.toDataURL("image/png"), download: `${report.title}.png` });
    link.click();
  }
}

async function fieldsSection() {
  const fields = report.fields;
  if (!fields) return;
  const out = section("fields", "Fields on the mesh",
    element("p", { class: "note hint" }, "Drag to turn, with shift to move, wheel to zoom, click to read a value. Stresses are means at nodes of what the cells have."));
  if (fields.since) out.append(element("p", { class: "note" }, `The run went on from a checkpoint at step ${fields.since}: fields of the steps before are not on this page.`));
  const [points, cells] = await Promise.all([floats(fields.points), integers(fields.cells)]);
  if (fields.dim < 2) { out.append(await barFigure(fields, points)); return; }
  try {
    const viewer = new Viewer(fields, points, cells);
    out.append(viewer.element);
    await viewer.update();
    document.body.viewer = viewer;
  } catch (problem) {
    out.append(element("p", { class: "bad" }, `The fields cannot be shown: ${problem.message}.`));
  }
}
