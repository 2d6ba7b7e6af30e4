"use strict";
// Shows the scene of the page: lines, dots and sheets, turned about the origin.

const scene = JSON.parse(document.getElementById("scene").textContent);
const canvas = document.getElementById("view");
const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
const FIELD = (30 * Math.PI) / 180;
const STEP = (7.5 * Math.PI) / 180;

// Vectors and matrices (columns first, as WebGL has them)

const sub = (a, b) => a.map((x, i) => x - b[i]);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const scale = (a, s) => a.map((x) => x * s);
const add = (a, b) => a.map((x, i) => x + b[i]);
const unit = (a) => scale(a, 1 / Math.hypot(...a));
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

function lookAtOrigin(eye, up) {
  const z = unit(eye);
  const x = unit(cross(up, z));
  const y = cross(z, x);
  const shift = [x, y, z].map((axis) => -dot(axis, eye));
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, ...shift, 1];
}

function perspective(aspect, near, far) {
  // The narrower side of the window has the whole field, so that a phone sees it all.
  const f = 1 / Math.tan(FIELD / 2);
  const fy = aspect >= 1 ? f : f * aspect;
  const depth = near - far;
  return [fy / aspect, 0, 0, 0, 0, fy, 0, 0,
    0, 0, (far + near) / depth, -1, 0, 0, (2 * far * near) / depth, 0];
}

function multiply(a, b) {
  const out = [];
  for (let column = 0; column < 4; column++)
    for (let row = 0; row < 4; row++)
      out.push([0, 1, 2, 3].reduce((s, k) => s + a[4 * k + row] * b[4 * column + k], 0));
  return out;
}

// The view: a turntable, its axis the scene's upright

const axis = unit(scene.up);
const home = (() => {
  const distance = Math.hypot(...scene.eye);
  const height = Math.asin(dot(scene.eye, axis) / distance);
  const level = unit(sub(scene.eye, scale(axis, dot(scene.eye, axis))));
  return { distance, height, level, side: cross(axis, level) };
})();
const view = {
  turn: 0, height: home.height, distance: home.distance, untouched: true,
};

function eye() {
  const { turn, height, distance } = view;
  const level = add(
    scale(home.level, Math.cos(turn)), scale(home.side, Math.sin(turn)));
  return scale(
    add(scale(level, Math.cos(height)), scale(axis, Math.sin(height))), distance);
}

function turnBy(across, upwards) {
  const most = Math.PI / 2 - 0.01;
  view.untouched = false;
  view.turn -= across;
  view.height = Math.max(-most, Math.min(most, view.height + upwards));
  redraw();
}

function approach(factor) {
  view.untouched = false;
  const least = scene.radius / 50;
  view.distance = Math.max(least, Math.min(20 * home.distance, view.distance * factor));
  redraw();
}

function start() {
  Object.assign(view, { turn: 0, height: home.height, untouched: true });
  stepBack();
  redraw();
}

const ACTIONS = {
  left: () => turnBy(-STEP, 0),
  right: () => turnBy(STEP, 0),
  up: () => turnBy(0, -STEP),
  down: () => turnBy(0, STEP),
  nearer: () => approach(0.85),
  farther: () => approach(1 / 0.85),
  start,
};
const KEYS = {
  ArrowLeft: "left", ArrowRight: "right", ArrowUp: "up", ArrowDown: "down",
  "+": "nearer", "=": "nearer", "-": "farther", 0: "start", Home: "start",
};

// Programs: lines and dots keep their width in pixels, so both are small squares
// set up on the screen, one instance each.

const VERTEX = {
  lines: `in vec3 a, b; in vec2 corner;
    void main() {
      vec4 p = matrix * vec4(a, 1), q = matrix * vec4(b, 1);
      // Cut at the near plane: a direction on the screen needs both ends before it.
      float pn = p.z + p.w, qn = q.z + q.w;
      if (pn < 0. && qn > 0.) p = mix(p, q, pn / (pn - qn));
      if (qn < 0. && pn > 0.) q = mix(q, p, qn / (qn - pn));
      vec2 along = (q.xy / q.w - p.xy / p.w) * window;
      along = length(along) > 1e-6 ? normalize(along) : vec2(1, 0);
      vec4 end = corner.x < 0. ? p : q;
      vec2 out_ = vec2(-along.y, along.x) * corner.y;
      gl_Position = end + vec4(out_ * size / window * end.w, 0, 0);
    }`,
  points: `in vec3 a; in vec2 corner; out vec2 at;
    void main() {
      at = corner;
      vec4 centre = matrix * vec4(a, 1);
      gl_Position = centre + vec4(corner * size / window * centre.w, 0, 0);
    }`,
  surface: `in vec3 a; in vec2 uv; out vec3 place; out vec2 at;
    void main() { place = a; at = uv; gl_Position = matrix * vec4(a, 1); }`,
};
const FRAGMENT = {
  lines: "void main() { painted = vec4(colour, 1); }",
  points: `in vec2 at;
    void main() { if (dot(at, at) > 1.) discard; painted = vec4(colour, 1); }`,
  surface: `in vec3 place; in vec2 at; uniform sampler2D picture;
    uniform float opacity, textured; uniform vec3 eye;
    void main() {
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      float lit = .55 + .45 * abs(dot(normal, normalize(eye - place)));
      vec3 own = textured > .5 ? texture(picture, at).rgb : colour * lit;
      painted = vec4(own, opacity);
    }`,
};
const COMMON = `#version 300 es
precision highp float;
uniform mat4 matrix; uniform vec2 window; uniform float size; uniform vec3 colour;
`;

function program(kind) {
  const made = gl.createProgram();
  for (const [type, text] of [
    [gl.VERTEX_SHADER, COMMON + VERTEX[kind]],
    [gl.FRAGMENT_SHADER, `${COMMON}out vec4 painted;\n${FRAGMENT[kind]}`],
  ]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS))
    throw new Error(gl.getProgramInfoLog(made));
  return made;
}

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;

function attribute(of, name, data, length, { every = 0, stride = 0, offset = 0 } = {}) {
  const place = gl.getAttribLocation(of, name);
  if (place < 0) return;
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(place);
  gl.vertexAttribPointer(place, length, gl.FLOAT, false, stride, offset);
  gl.vertexAttribDivisor(place, every);
}

const SQUARE = new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]);

function prepared(part, programs) {
  const using = (programs[part.kind] ??= program(part.kind));
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  const points = new Float32Array(bytes(part.points));
  const made = { ...part, using, array, middle: middle(points), corners: points };
  if (part.kind === "surface") {
    attribute(using, "a", points, 3);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(
      gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(bytes(part.triangles)), gl.STATIC_DRAW);
    if (part.texture) {
      attribute(using, "uv", lattice(...part.shape), 2);
      made.picture = picture(part.texture);
    }
  } else {
    const pair = part.kind === "lines" ? 24 : 12;
    attribute(using, "a", points, 3, { every: 1, stride: pair });
    attribute(using, "b", points, 3, { every: 1, stride: pair, offset: 12 });
    attribute(using, "corner", SQUARE, 2);
    made.instances = (points.length * 4) / pair;
  }
  return made;
}

function lattice(rows, columns) {
  const at = new Float32Array(2 * rows * columns);
  for (let r = 0, i = 0; r < rows; r++)
    for (let c = 0; c < columns; c++) {
      at[i++] = c / (columns - 1);
      at[i++] = r / (rows - 1);
    }
  return at;
}

function middle(points) {
  const sum = [0, 0, 0];
  points.forEach((x, i) => (sum[i % 3] += x));
  return scale(sum, 3 / points.length);
}

function picture(address) {
  const texture = gl.createTexture();
  const image = new Image();
  image.onload = () => {
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    redraw();
  };
  image.src = address;
  return texture;
}

// Drawing, at most once a frame

let parts = [];
let waiting = false;

function redraw() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; draw(); });
}

function seenFrom(from, aspect) {
  const distance = Math.hypot(...from);
  const far = distance + 2 * scene.radius;
  const near = Math.max(distance - 1.2 * scene.radius, far / 2000);
  return multiply(perspective(aspect, near, far), lookAtOrigin(from, axis));
}

// Steps back until the window shows every point, but not for ever: a scene may mean
// to have rays that lead out of it.
function stepBack() {
  const aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
  const outside = (m) => parts.some(({ corners }) => {
    for (let i = 0; i < corners.length; i += 3) {
      const [x, y, , w] = [0, 1, 2, 3].map((row) => m[12 + row] +
        m[row] * corners[i] + m[4 + row] * corners[i + 1] + m[8 + row] * corners[i + 2]);
      if (Math.abs(x) > 0.97 * w || Math.abs(y) > 0.97 * w) return true;
    }
    return false;
  });
  view.distance = home.distance;
  for (let tries = 0; tries < 12 && outside(seenFrom(eye(), aspect)); tries++)
    view.distance *= 1.05;
}

function draw() {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== width || canvas.height !== height)
    Object.assign(canvas, { width, height });
  gl.viewport(0, 0, width, height);
  gl.clearColor(1, 1, 1, 1);
  gl.depthMask(true);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  const from = eye();
  const matrix = seenFrom(from, width / height);
  const distance = (part) => Math.hypot(...sub(part.middle, from));
  const seen = parts.filter((part) => !part.hidden);
  const clear = seen.filter((part) => part.opacity < 1);
  clear.sort((p, q) => distance(q) - distance(p));
  for (const part of [...seen.filter((p) => !(p.opacity < 1)), ...clear])
    paint(part, matrix, from, [width, height], ratio);
}

function paint(part, matrix, from, size, ratio) {
  const at = (name) => gl.getUniformLocation(part.using, name);
  gl.useProgram(part.using);
  gl.bindVertexArray(part.array);
  gl.uniformMatrix4fv(at("matrix"), false, matrix);
  gl.uniform2fv(at("window"), size);
  gl.uniform1f(at("size"), (part.size || 1) * ratio);
  gl.uniform3fv(at("colour"), part.colour);
  if (part.kind !== "surface") {
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, part.instances);
    return;
  }
  gl.uniform3fv(at("eye"), from);
  gl.uniform1f(at("opacity"), part.opacity);
  gl.uniform1f(at("textured"), part.picture ? 1 : 0);
  if (part.picture) gl.bindTexture(gl.TEXTURE_2D, part.picture);
  // What lies behind a clear sheet stays visible, whichever is drawn first.
  gl.depthMask(part.opacity === 1);
  gl[part.opacity < 1 ? "enable" : "disable"](gl.BLEND);
  gl.enable(gl.POLYGON_OFFSET_FILL);
  gl.polygonOffset(1, 1);
  gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 0);
  gl.disable(gl.POLYGON_OFFSET_FILL);
}

// What a reader can do

function listen() {
  const fingers = new Map();
  const spread = () => {
    const [p, q] = [...fingers.values()];
    return Math.hypot(p[0] - q[0], p[1] - q[1]);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const before = fingers.size === 2 ? spread() : 0;
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (fingers.size === 2) approach(before / Math.max(spread(), 1));
    else turnBy((event.clientX - last[0]) / 150, (event.clientY - last[1]) / 150);
  });
  for (const end of ["pointerup", "pointercancel"])
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  // The wheel belongs to the page until the reader has taken the scene in hand.
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    approach(Math.exp(event.deltaY / 600));
  }, { passive: false });
  document.addEventListener("keydown", (event) => {
    const action = KEYS[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    ACTIONS[action]();
  });
  for (const button of document.querySelectorAll("[data-do]"))
    button.addEventListener("click", ACTIONS[button.dataset.do]);
  new ResizeObserver(() => {
    if (view.untouched) stepBack();
    // At once: a frame later the old picture would be seen stretched.
    draw();
  }).observe(canvas);
}

// One button a label: parts of one name come and go together.
function legend() {
  const row = document.getElementById("parts");
  for (const label of new Set(parts.map((part) => part.label).filter(Boolean))) {
    const mine = parts.filter((part) => part.label === label);
    const button = document.createElement("button");
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    swatch.style.background =
      `rgb(${mine[0].colour.map((c) => Math.round(255 * c)).join()})`;
    button.type = "button";
    button.setAttribute("aria-pressed", "true");
    button.append(swatch, label);
    button.addEventListener("click", () => {
      const hidden = !mine[0].hidden;
      for (const part of mine) part.hidden = hidden;
      button.setAttribute("aria-pressed", String(!hidden));
      redraw();
    });
    row.append(button);
  }
}

function begin() {
  const programs = {};
  parts = scene.parts.map((part) => prepared(part, programs));
  legend();
  listen();
  document.getElementById("controls").hidden = false;
}

// The report tells its theme: in the address at first, in a message when it changes.
function dress(theme) {
  document.documentElement.dataset.theme = theme === "dark" ? "dark" : "light";
}
dress(location.hash.slice(1));
window.addEventListener("message", (event) => {
  if (typeof event.data?.raxelTheme === "string") dress(event.data.raxelTheme);
});

if (gl) {
  begin();
} else {
  canvas.hidden = true;
  document.getElementById("without").hidden = false;
}
