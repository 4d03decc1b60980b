// Numbers that fields offer: components, norms, invariants of stresses.
"use strict";

/** Scalars that an array of several components offers: name -> (values, node) -> number. */
function quantitiesOf(array, fields) {
  const n = array.components, at = (k) => (v, i) => v[n * i + k];
  if (n === 1) return [[array.name, at(0)]];
  if (n === 3) {
    const out = [[`|${array.name}|`, (v, i) => Math.hypot(v[3 * i], v[3 * i + 1], v[3 * i + 2])]];
    for (let k = 0; k < Math.min(3, fields.dim); ++k) out.push([`${array.name}.${"xyz"[k]}`, at(k)]);
    return out;
  }
  const full = fields.dim === 3 || fields.axisymmetric;
  const out = [];
  if (full) out.push([`${array.name}: von Mises`, (v, i) => {
    const s = v.subarray(9 * i, 9 * i + 9), m = (s[0] + s[4] + s[8]) / 3;
    const deviator = (s[0] - m) ** 2 + (s[4] - m) ** 2 + (s[8] - m) ** 2 + 2 * (s[1] * s[3] + s[2] * s[6] + s[5] * s[7]);
    return Math.sqrt(Math.max(0, 1.5 * deviator));
  }], [`${array.name}: mean`, (v, i) => (v[9 * i] + v[9 * i + 4] + v[9 * i + 8]) / 3]);
  else out.push([`${array.name}: largest in the plane`, (v, i) => principal(v, i, 1)],
    [`${array.name}: smallest in the plane`, (v, i) => principal(v, i, -1)],
    [`${array.name}: shear in the plane`, (v, i) => (principal(v, i, 1) - principal(v, i, -1)) / 2]);
  const names = full ? [["xx", 0], ["yy", 4], ["zz", 8], ["xy", 1], ...(fields.dim === 3 ? [["yz", 5], ["xz", 2]] : [])] : [["xx", 0], ["yy", 4], ["xy", 1]];
  for (const [name, k] of names) out.push([`${array.name}.${name}`, at(k)]);
  return out;
}
function principal(v, i, sign) {
  const [xx, xy, yx, yy] = [v[9 * i], v[9 * i + 1], v[9 * i + 3], v[9 * i + 4]];
  const shear = (xy + yx) / 2, half = (xx - yy) / 2;
  return (xx + yy) / 2 + sign * Math.hypot(half, shear);
}
