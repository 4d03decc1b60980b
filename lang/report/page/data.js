// What the page shows, as the program wrote it: one JSON, and blocks of numbers (deflated, base64).
"use strict";

const report = JSON.parse(document.getElementById("report-data").textContent);

/** An element with attributes and children; texts are texts, never markup. */
function element(name, attributes = {}, ...children) {
  const out = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) out.addEventListener(key.slice(2), value);
    else if (value !== null && value !== false) out.setAttribute(key, value === true ? "" : value);
  }
  out.append(...children.filter((child) => child !== null));
  return out;
}

/** The same for SVG and MathML. */
function elementOf(namespace, name, attributes = {}, ...children) {
  const out = document.createElementNS(namespace, name);
  for (const [key, value] of Object.entries(attributes)) out.setAttribute(key, value);
  out.append(...children);
  return out;
}
const svg = (name, attributes, ...children) =>
  elementOf("http://www.w3.org/2000/svg", name, attributes, ...children);

/** ["mi", "u"] as MathML. */
function mathematics(node, block = false) {
  const isCases = (n) => n[0] === "mrow" && n.length === 3 && n[1][1] === "{" && n[2][0] === "mtable"; // no brace grows without a font for it
  const make = (n) => typeof n === "string" ? n
    : elementOf("http://www.w3.org/1998/Math/MathML", n[0], isCases(n) ? { class: "cases" } : {}, ...n.slice(1).map(make));
  return elementOf("http://www.w3.org/1998/Math/MathML", "math",
    block ? { display: "block" } : {}, make(node));
}

/** The bytes of a block: base64 of a zlib stream. */
async function bytesOf(id) {
  const text = document.getElementById(id).textContent;
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}
const floats = async (id) => new Float32Array(await bytesOf(id));
const integers = async (id) => new Uint32Array(await bytesOf(id));

/** A number for reading. */
function text(x, digits = 4) {
  if (x === null || x === undefined || Number.isNaN(x)) return "–";
  if (typeof x !== "number") return String(x);
  const short = Number(x.toPrecision(digits));
  return (Math.abs(short) < 1e6 ? String(short) : short.toExponential().replace("e+", "e")).replaceAll("-", "−");
}

/** Behind the name of what is shown: " [mm]"; nothing where its unit is 1 or not known. */
const unitOf = (kind) => report.units[kind] || "";
const withUnit = (column) => column + (report.units.columns && report.units.columns[column] || "");
const timeName = "t" + unitOf("time");

/** Multiples of 1, 2 or 5 times a power of ten in [low, high]. */
function ticks(low, high, wanted) {
  if (!(high > low)) return [low];
  const rough = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(rough));
  const digit = rough / power, step = power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) out.push(k * step);
  return out;
}
/** As many of them, at most `wanted`, as find room side by side with their numbers of so many digits. */
function ticksAcross(low, high, wanted, room, digits = 4) {
  const letter = 7.5, air = 14; // pixels
  for (let n = wanted; n > 1; --n) {
    const out = ticks(low, high, n), widest = Math.max(...out.map((x) => text(x, digits).length));
    if (out.length * (letter * widest + air) <= room) return out;
  }
  return ticks(low, high, 1);
}
