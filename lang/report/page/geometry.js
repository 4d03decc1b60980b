// Triangles of a mesh: its skin, its sharp edges, a cut through it. Plain arrays, nothing of WebGL.
"use strict";

const sharp = 0.8; // cosine from which an edge between two faces is one that is drawn

/** Triangles (node numbers) of the skin: the cells in 2D, the faces of one cell only in 3D. */
function skinOf(cells, dim) {
  if (dim < 3) return cells;
  const faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
  const n = cells.length;
  let nodes = 0;
  for (let i = 0; i < n; ++i) nodes = Math.max(nodes, cells[i] + 1);
  const count = new Map();
  for (let c = 0; c < n; c += 4)
    for (let f = 0; f < 4; ++f) {
      let a = cells[c + faces[f][0]], b = cells[c + faces[f][1]], d = cells[c + faces[f][2]];
      if (a > b) [a, b] = [b, a];
      if (b > d) [b, d] = [d, b];
      if (a > b) [a, b] = [b, a];
      // Two faces with the same two smallest nodes are told apart by the third.
      const key = a * nodes + b;
      let others = count.get(key);
      if (others === undefined) count.set(key, others = []);
      const at = others.findIndex((o) => o[0] === d);
      if (at < 0) others.push([d, c, f]);
      else others.splice(at, 1);
    }
  const out = [];
  for (const others of count.values())
    for (const [, c, f] of others) for (const k of faces[f]) out.push(cells[c + k]);
  return Uint32Array.from(out);
}

/** Normals by corner, three numbers each: the mean over the faces at a node without a sharp edge. */
function cornerNormals(triangles, points) {
  const n = triangles.length / 3, faces = new Float32Array(3 * n);
  const start = new Uint32Array(points.length / 3 + 1);
  for (let t = 0; t < n; ++t) {
    const [a, b, c] = [3 * triangles[3 * t], 3 * triangles[3 * t + 1], 3 * triangles[3 * t + 2]];
    const u = [points[b] - points[a], points[b + 1] - points[a + 1], points[b + 2] - points[a + 2]];
    const v = [points[c] - points[a], points[c + 1] - points[a + 1], points[c + 2] - points[a + 2]];
    faces[3 * t] = u[1] * v[2] - u[2] * v[1];
    faces[3 * t + 1] = u[2] * v[0] - u[0] * v[2];
    faces[3 * t + 2] = u[0] * v[1] - u[1] * v[0];
    for (let k = 0; k < 3; ++k) ++start[triangles[3 * t + k] + 1];
  }
  for (let i = 1; i < start.length; ++i) start[i] += start[i - 1];
  const around = new Uint32Array(3 * n), next = start.slice();
  for (let i = 0; i < 3 * n; ++i) around[next[triangles[i]]++] = Math.floor(i / 3);
  const size = (t) => Math.hypot(faces[3 * t], faces[3 * t + 1], faces[3 * t + 2]) || 1;
  const out = new Float32Array(9 * n);
  for (let t = 0; t < n; ++t) {
    const own = size(t);
    for (let k = 0; k < 3; ++k) {
      const node = triangles[3 * t + k], sum = [0, 0, 0];
      for (let i = start[node]; i < start[node + 1]; ++i) {
        const f = around[i];
        const cosine = (faces[3 * t] * faces[3 * f] + faces[3 * t + 1] * faces[3 * f + 1] + faces[3 * t + 2] * faces[3 * f + 2]) / (own * size(f));
        if (cosine > sharp) for (let j = 0; j < 3; ++j) sum[j] += faces[3 * f + j];
      }
      const length = Math.hypot(...sum) || 1;
      for (let j = 0; j < 3; ++j) out[9 * t + 3 * k + j] = sum[j] / length;
    }
  }
  return out;
}

/** Pairs of nodes: edges of one triangle only, and sharp ones. */
function featureEdges(triangles, points, dim) {
  const uses = new Map(), nodes = points.length / 3;
  for (let t = 0; t < triangles.length; t += 3)
    for (let k = 0; k < 3; ++k) {
      const a = triangles[t + k], b = triangles[t + (k + 1) % 3];
      const key = Math.min(a, b) * nodes + Math.max(a, b);
      const known = uses.get(key);
      if (known === undefined) uses.set(key, [a, b, t, -1]);
      else known[3] = t;
    }
  const normal = (t) => {
    const p = [0, 1, 2].map((k) => points.subarray(3 * triangles[t + k], 3 * triangles[t + k] + 3));
    const u = [0, 1, 2].map((j) => p[1][j] - p[0][j]), v = [0, 1, 2].map((j) => p[2][j] - p[0][j]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const size = Math.hypot(...n) || 1;
    return n.map((x) => x / size);
  };
  const out = [];
  for (const [a, b, first, second] of uses.values()) {
    let drawn = second < 0;
    if (!drawn && dim === 3) {
      const [p, q] = [normal(first), normal(second)];
      drawn = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] < sharp;
    }
    if (drawn) out.push(a, b);
  }
  return Uint32Array.from(out);
}

/** Triangles in the plane { x : x . normal = at } through tetrahedra: points and values in a row. */
function cutThrough(cells, points, values, normal, at) {
  const outPoints = [], outValues = [];
  const height = (i) => points[3 * i] * normal[0] + points[3 * i + 1] * normal[1] + points[3 * i + 2] * normal[2] - at;
  const heights = new Float32Array(points.length / 3);
  for (let i = 0; i < heights.length; ++i) heights[i] = height(i);
  for (let c = 0; c < cells.length; c += 4) {
    const above = [], below = [];
    for (let k = 0; k < 4; ++k) (heights[cells[c + k]] > 0 ? above : below).push(cells[c + k]);
    if (above.length === 0 || below.length === 0) continue;
    const ring = [];
    const cross = (i, j) => {
      const part = heights[i] / (heights[i] - heights[j]);
      ring.push([0, 1, 2].map((k) => points[3 * i + k] + part * (points[3 * j + k] - points[3 * i + k])).concat(values[i] + part * (values[j] - values[i])));
    };
    if (above.length === 1) for (const j of below) cross(above[0], j);
    else if (below.length === 1) for (const i of above) cross(i, below[0]);
    else { cross(above[0], below[0]); cross(above[0], below[1]); cross(above[1], below[1]); cross(above[1], below[0]); }
    for (let k = 1; k + 1 < ring.length; ++k)
      for (const p of [ring[0], ring[k], ring[k + 1]]) { outPoints.push(p[0], p[1], p[2]); outValues.push(p[3]); }
  }
  return { points: Float32Array.from(outPoints), values: Float32Array.from(outValues) };
}

/** An arrow as triangles, appended to lists of points and normals. */
function addArrow(points, normals, tail, tip, thick) {
  const axis = [0, 1, 2].map((k) => tip[k] - tail[k]), length = Math.hypot(...axis) || 1e-30;
  const ahead = axis.map((x) => x / length);
  const helper = Math.abs(ahead[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0];
  const crossed = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  let aside = crossed(ahead, helper);
  const size = Math.hypot(...aside);
  aside = aside.map((x) => x / size);
  const over = crossed(ahead, aside), around = 8, head = Math.min(4 * thick, 0.5 * length);
  const ring = (at, radius) => Array.from({ length: around }, (_, k) => {
    const angle = 2 * Math.PI * k / around, c = Math.cos(angle), s = Math.sin(angle);
    return { p: [0, 1, 2].map((j) => tail[j] + at * ahead[j] + radius * (c * aside[j] + s * over[j])),
      n: [0, 1, 2].map((j) => c * aside[j] + s * over[j]) };
  });
  const rings = [ring(0, thick / 2), ring(length - head, thick / 2), ring(length - head, 1.4 * thick), ring(length, 0)];
  for (let r = 0; r < 3; ++r)
    for (let k = 0; k < around; ++k) {
      const [a, b] = [rings[r][k], rings[r][(k + 1) % around]], [c, d] = [rings[r + 1][k], rings[r + 1][(k + 1) % around]];
      for (const v of [a, b, c, b, d, c]) { points.push(...v.p); normals.push(...v.n); }
    }
}

/** The nearest point of the skin under (x, y) of a view: barycentric in a triangle; null: none. */
function hit(triangles, seen, x, y) {
  let best = null;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const area = (seen[b] - seen[a]) * (seen[c + 1] - seen[a + 1]) - (seen[b + 1] - seen[a + 1]) * (seen[c] - seen[a]);
    if (area === 0) continue;
    const u = ((seen[b] - x) * (seen[c + 1] - y) - (seen[b + 1] - y) * (seen[c] - x)) / area;
    const v = ((seen[c] - x) * (seen[a + 1] - y) - (seen[c + 1] - y) * (seen[a] - x)) / area;
    const w = 1 - u - v;
    if (u < 0 || v < 0 || w < 0) continue;
    const depth = u * seen[a + 2] + v * seen[b + 2] + w * seen[c + 2];
    if (best === null || depth > best.depth) best = { depth, nodes: [a / 3, b / 3, c / 3], weights: [u, v, w] };
  }
  return best;
}
