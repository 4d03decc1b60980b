// WebGL 2: triangles with light and colours, lines, dots. Knows arrays, nothing of meshes.
"use strict";

const vertexCode = `#version 300 es
uniform mat3 turn; uniform vec3 centre; uniform vec2 scale; uniform vec2 shift; uniform float depth; uniform float nearer; uniform float dot_size;
in vec3 point; in vec3 normal; in float value;
out vec3 seen_normal; out float seen_value; out vec3 place;
void main() {
  vec3 p = turn * (point - centre);
  gl_Position = vec4(p.xy * scale + shift, -p.z * depth - nearer, 1.0);
  gl_PointSize = dot_size;
  seen_normal = turn * normal; seen_value = value; place = point;
}`;
const fragmentCode = `#version 300 es
precision highp float;
uniform sampler2D colours; uniform vec2 range; uniform vec4 flat_colour; uniform float contours; uniform bool lit; uniform bool dots; uniform bool clips; uniform vec4 plane;
in vec3 seen_normal; in float seen_value; in vec3 place;
out vec4 colour;
void main() {
  if (clips && dot(place, plane.xyz) > plane.w) discard;
  if (dots && length(gl_PointCoord - 0.5) > 0.5) discard;
  vec3 own = flat_colour.rgb;
  if (flat_colour.a == 0.0) {
    float at = (seen_value - range.x) / (range.y - range.x);
    own = isnan(at) ? vec3(0.80, 0.82, 0.84) : texture(colours, vec2(clamp(at, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
    if (contours > 0.0 && !isnan(at)) {
      float level = at * contours, width = fwidth(level);
      float away = abs(fract(level - 0.5) - 0.5);
      if (width < 0.7) own = mix(own, vec3(0.1), 0.75 * (1.0 - smoothstep(0.6 * width, 1.5 * width, away)));
    }
  }
  float bright = 1.0;
  if (lit) {
    vec3 n = normalize(seen_normal);
    if (n.z < 0.0) n = -n;
    bright = 0.66 + 0.33 * max(dot(n, normalize(vec3(-0.30, 0.60, 0.8))), 0.0) + 0.10 * pow(max(dot(n, normalize(vec3(-0.30, 0.60, 1.8))), 0.0), 40.0);
  }
  colour = vec4(own * bright, 1.0);
}`;

class Painter {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    this.program = gl.createProgram();
    for (const [kind, code] of [[gl.VERTEX_SHADER, vertexCode], [gl.FRAGMENT_SHADER, fragmentCode]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, code);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    gl.useProgram(this.program);
    this.places = {};
    this.textures = Object.fromEntries(Object.entries(lookup).map(([name, bytes]) => {
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
      for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
      return [name, texture];
    }));
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.clearColor(1, 1, 1, 1);
  }
  place(name) {
    return this.places[name] ??= this.gl.getUniformLocation(this.program, name);
  }
  /** A buffer on the card; `parts` numbers to a vertex. */
  upload(array) {
    const buffer = this.gl.createBuffer();
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, buffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, array, this.gl.STATIC_DRAW);
    return buffer;
  }
  release(thing) {
    if (thing) for (const buffer of [thing.points, thing.normals, thing.values]) if (buffer) this.gl.deleteBuffer(buffer);
  }
  /** What `draw` takes: { kind, count, points, normals, values }. */
  thing(kind, points, normals = null, values = null) {
    return { kind, count: points.length / 3, points: this.upload(points),
      normals: normals && this.upload(normals), values: values && this.upload(values) };
  }
  begin(view) {
    const gl = this.gl;
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix3fv(this.place("turn"), false, view.turn);
    gl.uniform3fv(this.place("centre"), view.centre);
    gl.uniform2fv(this.place("scale"), view.scale);
    gl.uniform2fv(this.place("shift"), view.shift);
    gl.uniform1f(this.place("depth"), view.depth);
  }
  attribute(name, buffer, parts) {
    const gl = this.gl, at = gl.getAttribLocation(this.program, name);
    if (at < 0) return;
    if (!buffer) { gl.disableVertexAttribArray(at); gl.vertexAttrib3f(at, 0, 0, 1); return; }
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, parts, gl.FLOAT, false, 0, 0);
  }
  /** how: { scale, contours, colour, lit, nearer, plane, dots } */
  draw(thing, how) {
    if (!thing || thing.count === 0) return;
    const gl = this.gl, scale = how.scale || { list: "viridis", from: 0, to: 1 };
    this.attribute("point", thing.points, 3);
    this.attribute("normal", thing.normals, 3);
    this.attribute("value", thing.values, 1);
    gl.bindTexture(gl.TEXTURE_2D, this.textures[scale.list]);
    gl.uniform2f(this.place("range"), scale.from, scale.to);
    gl.uniform4f(this.place("flat_colour"), ...(how.colour || [0, 0, 0]), how.colour ? 1 : 0);
    gl.uniform1f(this.place("contours"), how.contours || 0);
    gl.uniform1i(this.place("lit"), how.lit ? 1 : 0);
    gl.uniform1f(this.place("nearer"), how.nearer || 0);
    gl.uniform1i(this.place("dots"), how.dots ? 1 : 0);
    gl.uniform1f(this.place("dot_size"), how.dots || 1);
    gl.uniform1i(this.place("clips"), how.plane ? 1 : 0);
    gl.uniform4fv(this.place("plane"), how.plane || [0, 0, 0, 0]);
    gl.drawArrays({ triangles: gl.TRIANGLES, lines: gl.LINES, dots: gl.POINTS }[thing.kind], 0, thing.count);
  }
}
