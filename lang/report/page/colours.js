// Colours of values: viridis (S. van der Walt, N. Smith, CC0) for one sign, ColorBrewer's RdBu
// (C. Brewer, M. Harrower) for both, white at zero.
"use strict";

const colourLists = {
  viridis: ["440154", "482878", "3e4a89", "31688e", "26828e", "1f9e89", "35b779", "6dcd59", "b4de2c", "fde725"],
  diverging: ["053061", "2166ac", "4393c3", "92c5de", "d1e5f0", "f7f7f7", "fddbc7", "f4a582", "d6604d", "b2182b", "67001f"],
};
const lookup = Object.fromEntries(Object.entries(colourLists).map(([name, list]) => {
  const colours = list.map((c) => [0, 2, 4].map((k) => parseInt(c.slice(k, k + 2), 16)));
  const out = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; ++i) {
    const at = i / 255 * (colours.length - 1), k = Math.min(Math.floor(at), colours.length - 2);
    for (let j = 0; j < 3; ++j) out[4 * i + j] = Math.round(colours[k][j] + (at - k) * (colours[k + 1][j] - colours[k][j]));
    out[4 * i + 3] = 255;
  }
  return [name, out];
}));

/** The least and the largest number; what has no value (NaN) does not count. */
function rangeOf(values, [low, high] = [Infinity, -Infinity]) {
  for (const v of values) {
    if (v < low) low = v;
    if (v > high) high = v;
  }
  return [low, high];
}

/** { low, high, list, from, to }: values from `from` to `to` run through the whole list. */
function colourScale(low, high) {
  if (low > high) low = high = 0; // of no number
  const size = Math.max(-low, high), both = Math.min(-low, high) > 0.15 * size;
  return both ? { low, high, list: "diverging", from: -size, to: size }
    : { low, high, list: "viridis", from: low, to: high > low ? high : low + 1 };
}

/** Branches of points of laws (BranchKind of the program): words and colours. */
const branches = [
  ["open", "#9aa0a8"], ["loaded", "#0072b2"], ["softened", "#d55e00"], ["held", "#000000"],
  ["stick", "#009e73"], ["slip", "#e69f00"], ["slip, softened", "#cc79a7"],
];
