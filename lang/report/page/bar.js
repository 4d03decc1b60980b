// A body in one dimension: its fields as curves over its length, at a time that a slider chooses.
"use strict";

async function barFigure(fields, points) {
  const order = Array.from({ length: points.length / 3 }, (_, i) => i).sort((a, b) => points[3 * a] - points[3 * b]);
  const plots = element("div", { class: "plots" }), frames = fields.frames, timeText = element("output", {});
  let shown = -1, playing = false;
  const show = async (frame) => {
    shown = (frame + frames.length) % frames.length;
    const now = shown, all = await Promise.all(frames[now].data.map(floats));
    if (now !== shown) return; // asked for another one meanwhile
    slider.value = now;
    timeText.textContent = `t = ${text(frames[now].t)}${unitOf("time")}`;
    plots.replaceChildren(...fields.arrays.map((array, a) => {
      const name = array.name + array.unit;
      return curvesFigure({ label: frames.length > 1 ? `${name} at ${timeText.textContent}` : name, xName: "x" + unitOf("length"),
        x: order.map((i) => points[3 * i]), curves: [{ name, y: order.map((i) => all[a][array.components * i]) }] });
    }));
  };
  const slider = element("input", { type: "range", id: "time", min: 0, max: frames.length - 1, "aria-label": "time", oninput: (e) => show(Number(e.target.value)) });
  const play = element("button", { id: "play", type: "button", onclick: () => {
    playing = !playing;
    play.textContent = playing ? "stop" : "play";
    const next = async () => {
      if (!playing) return;
      await show(shown + 1);
      setTimeout(next, 120);
    };
    next();
  } }, "play");
  await show(frames.length - 1);
  return element("div", {}, frames.length > 1 ? element("div", { class: "time" }, play, slider, timeText) : null, plots);
}
