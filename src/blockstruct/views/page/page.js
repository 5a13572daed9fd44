const data = JSON.parse(document.getElementById("data").textContent);
const at = id => document.getElementById(id);

// ---------------------------------------------------------------- arrays
async function bytes(text) {
  const packed = new Blob([Uint8Array.from(atob(text), c => c.charCodeAt(0))]);
  return new Response(packed.stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}
const halves = Float32Array.from({length: 65536}, (_, h) => {
  const sign = h & 0x8000 ? -1 : 1, exponent = (h >> 10) & 31, fraction = h & 1023;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return exponent ? sign * 2 ** (exponent - 15) * (1 + fraction / 1024) : sign * 2 ** -14 * (fraction / 1024);
});
const float32 = async text => new Float32Array(await bytes(text));
const int32 = async text => new Int32Array(await bytes(text));
const uint16 = async text => new Uint16Array(await bytes(text));
const float16 = async text => Float32Array.from(await uint16(text), h => halves[h]);
/** Put numbers in the place of their texts. */
const unpack = (object, kinds, numbers) => Promise.all(kinds.map(async kind => { object[kind] = await numbers(object[kind]); }));
const column = (values, c, width = 3) => values.filter((_, i) => i % width === c);

const blocks = data.blocks, interfaces = data.interfaces, ties = data.ties;
await Promise.all([
  unpack(blocks, ["centroids", "vertices"], float32),
  unpack(blocks, ["of_vertex", "triangles", "edges"], int32),
  unpack(interfaces, ["centroids", "vertices", "frames"], float32),
  unpack(interfaces, ["of_vertex", "triangles", "of_triangle"], int32),
  unpack(ties, ["vertices"], float32), unpack(ties, ["of_vertex"], int32),
  ...data.cases.flatMap(c => [
    unpack(c, ["force", "eccentricity"], float32), unpack(c, ["velocity", "sliding", "crushing"], float16),
    unpack(c, ["state"], uint16), ...c.arrows.map(a => unpack(a, ["point", "vector"], float32)), ...(c.motion ? [unpack(c.motion, ["places"], float32)] : []),
  ]),
]);
blocks.of_triangle = blocks.triangles.filter((_, t) => t % 3 === 0).map(v => blocks.of_vertex[v]);
// An interface goes with its minus block.
interfaces.block_of_vertex = interfaces.of_vertex.map(i => interfaces.minus[i]);
const B = blocks.name.length, I = interfaces.name.length;

// ---------------------------------------------------------------- what is shown
const shown = {case: data.first, iteration: 0, amplitude: data.look.amplitude, colour: "state", picked: null, step: null};
const current = () => data.cases[shown.case];
/** The largest translation as it is drawn, m: less than the slider says where corners move much farther. */
const largest = () => shown.amplitude * blocks.size * current().share[shown.iteration];

/** Coordinates of points where the blocks are in the state of the motion: turned about the centroid, and moved. */
function placed(points, blockOf) {
  const m = current().motion.places, start = shown.step * B * 12, moved = points.slice();
  for (let v = 0; v < blockOf.length; v++) {
    const b = blockOf[v], k = start + 12 * b, p = 3 * v;
    const [x, y, z] = [0, 1, 2].map(a => points[p + a] - blocks.centroids[3 * b + a]);
    for (let a = 0; a < 3; a++) moved[p + a] = m[k + 3 * a] * x + m[k + 3 * a + 1] * y + m[k + 3 * a + 2] * z + m[k + 9 + a];
  }
  return moved;
}
/** Coordinates of points after the mechanism of the iteration, to first order; or in the state of the motion. */
function displaced(points, blockOf) {
  if (shown.step !== null) return placed(points, blockOf);
  const scale = largest(), start = shown.iteration * B * 6, moved = points.slice();
  if (!scale) return moved;
  // Without a mechanism the blocks stay where they are.
  const u = current().velocity.subarray(start, start + 6 * B).map(c => Number.isNaN(c) ? 0 : c);
  for (let v = 0; v < blockOf.length; v++) {
    const b = blockOf[v], k = 6 * b, p = 3 * v;
    const x = points[p] - blocks.centroids[3 * b], y = points[p + 1] - blocks.centroids[3 * b + 1], z = points[p + 2] - blocks.centroids[3 * b + 2];
    moved[p] += scale * (u[k] + u[k + 4] * z - u[k + 5] * y);
    moved[p + 1] += scale * (u[k + 1] + u[k + 5] * x - u[k + 3] * z);
    moved[p + 2] += scale * (u[k + 2] + u[k + 3] * y - u[k + 4] * x);
  }
  return moved;
}
const xyz = points => ({x: column(points, 0), y: column(points, 1), z: column(points, 2)});

/** Lines and joints lie on the faces of blocks: they are drawn this far off them, m. */
const OFF = 0.0015 * blocks.size;
/** Points moved away from the centres of what they belong to. */
function outward(points, centres, of, distance) {
  const moved = points.slice();
  for (let v = 0; v < of.length; v++) {
    const p = 3 * v, c = 3 * of[v], away = [0, 1, 2].map(a => points[p + a] - centres[c + a]);
    const length = Math.hypot(...away) || 1;
    for (let a = 0; a < 3; a++) moved[p + a] += distance * away[a] / length;
  }
  return moved;
}
/** Where joints are filled: off the face of their minus block, which they go with, so that neither hides the other. */
interfaces.fill = interfaces.vertices.map((value, k) => value + OFF * interfaces.frames[9 * interfaces.of_vertex[Math.floor(k / 3)] + k % 3]);
const outer = {
  blocks: outward(blocks.vertices, blocks.centroids, blocks.of_vertex, OFF),
  interfaces: outward(interfaces.vertices, interfaces.centroids, interfaces.of_vertex, 2 * OFF),
};
/** Ends of the edges of the polygons of joints. */
interfaces.edges = (() => {
  const pairs = [], of = interfaces.of_vertex;
  for (let v = 0, first = 0; v < of.length; v++) {
    if (of[v] !== of[first]) first = v;
    pairs.push(v, of[v + 1] === of[v] ? v + 1 : first);
  }
  return Int32Array.from(pairs);
})();

/** Points of line segments, parted by gaps. */
function segments(points, pairs) {
  const line = new Float32Array(4.5 * pairs.length).fill(NaN);
  for (let e = 0; e < pairs.length / 2; e++)
    for (let end = 0; end < 2; end++)
      for (let c = 0; c < 3; c++) line[9 * e + 3 * end + c] = points[3 * pairs[2 * e + end] + c];
  return line;
}

/** Force on the plus block at an interface: local components in N, global vector, and where it acts. */
function resultant(i) {
  const c = current(), row = shown.iteration * I + i, frame = interfaces.frames;
  const local = Array.from(c.force.slice(3 * row, 3 * row + 3)), e = Array.from(c.eccentricity.slice(2 * row, 2 * row + 2));
  const axis = (k, a) => frame[9 * i + 3 * k + a];
  return {
    local, e,
    vector: [0, 1, 2].map(a => local[0] * axis(0, a) + local[1] * axis(1, a) + local[2] * axis(2, a)),
    point: [0, 1, 2].map(a => interfaces.centroids[3 * i + a] + e[0] * axis(1, a) + e[1] * axis(2, a)),
  };
}
/** Shafts of the resultants as lines, and their heads as triangles in two planes, as long as they are large. */
function forceArrows() {
  const scale = 0.15 * blocks.size / current().largest[shown.iteration], line = [], heads = [], corners = [];
  for (let i = 0; i < I; i++) {
    const {vector, point} = resultant(i);
    if (point.some(Number.isNaN)) continue;
    const tip = point.map((p, a) => p + scale * vector[a]), length = scale * Math.hypot(...vector);
    line.push(...point, ...tip, NaN, NaN, NaN);
    if (length < 0.01 * blocks.size) continue;
    const along = vector.map(c => scale * c / length), head = Math.min(0.022 * blocks.size, 0.5 * length);
    const least = along.map(Math.abs).indexOf(Math.min(...along.map(Math.abs)));
    const first = cross(along, [0, 1, 2].map(a => a === least ? 1 : 0)), unit = first.map(c => c / Math.hypot(...first));
    for (const side of [unit, cross(along, unit)]) {
      const k = heads.length / 3;
      heads.push(...tip, ...[1, -1].flatMap(s => tip.map((t, a) => t - head * along[a] + s * 0.4 * head * side[a])));
      corners.push(k, k + 1, k + 2);
    }
  }
  return {line: Float32Array.from(line), heads: Float32Array.from(heads), corners};
}
/** Lines of arrows that end where the loads act, on blocks that have moved; the longest as in the figure of the loads. */
function loadArrows({block, point, vector}) {
  const line = [], tips = displaced(point, block), scale = 0.18 * blocks.size;
  for (let i = 0; i < block.length; i++) {
    const tip = Array.from(tips.slice(3 * i, 3 * i + 3)), shaft = Array.from(vector.slice(3 * i, 3 * i + 3), c => scale * c);
    const length = Math.hypot(...shaft), along = shaft.map(c => c / length), head = Math.min(0.022 * blocks.size, 0.5 * length);
    const side = cross(along, Math.abs(along[2]) > 0.9 ? [0, 1, 0] : [0, 0, 1]), width = 0.4 * head / Math.hypot(...side);
    const barb = s => tip.map((t, a) => t - head * along[a] + s * width * side[a]);
    line.push(...tip.map((t, a) => t - shaft[a]), ...tip, ...barb(1), NaN, NaN, NaN, ...tip, ...barb(-1), NaN, NaN, NaN);
  }
  return Float32Array.from(line);
}
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const stateOf = i => current().state[shown.iteration * I + i];
const utilisation = (kind, i) => current()[kind][shown.iteration * I + i];

/** Value and colour scale of joints; a joint at rest has no value among the states. */
function jointColours() {
  if (shown.colour !== "state") {
    const full = data.look.full, steps = data.look.utilisation.map((colour, k) => [full * k / 2, colour]);
    return {
      value: i => Math.min(1, utilisation(shown.colour, i)), cmin: 0, cmax: 1, showscale: true,
      colorscale: [...steps, [full, data.look.force], [1, data.look.force]],
    };
  }
  const names = Object.keys(data.look.states), n = names.length;
  const scale = names.flatMap((name, k) => [[k / n, data.look.states[name]], [(k + 1) / n, data.look.states[name]]]);
  const rank = current().gravest.map(name => name === "sticking" ? NaN : names.indexOf(name) + 0.5);
  return {value: i => rank[stateOf(i)], cmin: 0, cmax: n, showscale: false, colorscale: scale};
}
/** Joints as faces, where they open, and as lines, where they meet the surface of the blocks. */
function joints() {
  const {value, ...scale} = jointColours();
  const moved = displaced(outer.interfaces, interfaces.block_of_vertex), pairs = interfaces.edges;
  const drawn = pairs.filter((_, e) => !Number.isNaN(value(interfaces.of_vertex[pairs[e - e % 2]])));
  const colour = Array.from({length: 1.5 * drawn.length}, (_, k) => value(interfaces.of_vertex[drawn[2 * Math.floor(k / 3)]]));
  const line = {width: 5, color: colour, cmin: scale.cmin, cmax: scale.cmax, colorscale: scale.colorscale};
  const fill = Array.from(interfaces.of_triangle, value);
  return [{...xyz(displaced(interfaces.fill, interfaces.block_of_vertex)), intensity: fill, ...scale}, {...xyz(segments(moved, drawn)), line}];
}

/** State and force of every tie in the iteration; in the state of the motion its elongation, too. */
function tieRows() {
  const {tie, motion} = current();
  return (shown.step === null ? tie[shown.iteration] : motion.tie && motion.tie[shown.step]) || [];
}
/** Ties as lines that go with their blocks, coloured by their state; those that have broken are gone. */
function tieLines() {
  const names = Object.keys(data.look.ties), n = names.length;
  const there = [...tieRows().entries()].filter(([, [state]]) => state !== "broken");
  const pairs = Int32Array.from(there.flatMap(([k]) => [2 * k, 2 * k + 1]));
  const rank = there.map(([, [state]]) => names.indexOf(state) + 0.5);
  const color = rank.flatMap(r => [r, r, r]);
  const colorscale = names.flatMap((name, k) => [[k / n, data.look.ties[name]], [(k + 1) / n, data.look.ties[name]]]);
  return {...xyz(segments(displaced(ties.vertices, ties.of_vertex), pairs)), line: {width: 7, color, cmin: 0, cmax: n, colorscale}};
}

// ---------------------------------------------------------------- the scene
const GHOST = 0, BLOCKS = 1, EDGES = 2, INTERFACES = 3, JOINTS = 4, FORCES = 5, HEADS = 6, PICKED = 7, TIES = 8, DEAD = 9, VARIABLE = 10;
const lighting = {ambient: 0.75, diffuse: 0.45, specular: 0.05, roughness: 0.9};
const mesh = (bodies, more) => ({
  type: "mesh3d", ...xyz(bodies.vertices), i: column(bodies.triangles, 0), j: column(bodies.triangles, 1),
  k: column(bodies.triangles, 2), flatshading: true, lighting, ...more,
});
const lines = (points, color, width, more) => ({
  type: "scatter3d", mode: "lines", ...xyz(points), line: {color, width}, hoverinfo: "skip", showlegend: false, ...more,
});
const outline = segments(blocks.vertices, blocks.edges);
/** Colours of the triangles of blocks: stone, or in the last iteration those of the bodies that move. */
function stones() {
  const coloured = at("show-bodies").checked && shown.iteration === current().stage.length - 1, {bodies} = data.look;
  return Array.from(blocks.of_triangle, b => {
    const body = coloured ? current().body[b] : -1;
    return body >= 0 ? bodies[body % bodies.length] : blocks.support[b] ? data.look.support : data.look.stone;
  });
}
const traces = [
  lines(outline, data.look.ghost, 1, {visible: false}),
  mesh(blocks, {facecolor: stones(), hoverinfo: "text", text: Array.from(blocks.of_triangle, b => blocks.name[b]), name: "blocks"}),
  lines(outline, data.look.edge, 1.5),
  mesh(interfaces, {
    intensitymode: "cell", intensity: Array.from(interfaces.of_triangle, () => 0), hoverinfo: "text", name: "interfaces",
    text: Array.from(interfaces.of_triangle, i => interfaces.name[i]),
    colorbar: {title: {text: "utilisation [-]", side: "top"}, thickness: 12, len: 0.5, x: 0},
  }),
  lines([NaN, NaN, NaN], data.look.force, 5),
  lines([NaN, NaN, NaN], data.look.force, 4, {visible: false}),
  {type: "mesh3d", x: [0], y: [0], z: [0], i: [0], j: [0], k: [0], color: data.look.force, hoverinfo: "skip", lighting: {ambient: 1, diffuse: 0}, visible: false},
  lines([NaN, NaN, NaN], "#d4007a", 7),
  lines([NaN, NaN, NaN], "#00664d", 7, {visible: false, mode: "lines+markers", marker: {size: 4, symbol: "square", color: "#00664d"}}),
  lines([NaN, NaN, NaN], data.look.dead, 4, {visible: false}),
  lines([NaN, NaN, NaN], data.look.force, 4, {visible: false}),
];
// Coordinates are drawn from the origin: WebGL has no room for those of a survey.
const from = origin => origin ? ` ${origin < 0 ? "+" : "−"} ${Number(Math.abs(origin).toPrecision(12))}` : "";
const extents = ["x", "y", "z"].map((_, c) => { const v = column(blocks.vertices, c); return v.reduce((a, b) => Math.max(a, b)) - v.reduce((a, b) => Math.min(a, b)); });
// A short axis has room for few numbers.
const axis = (name, c) => ({nticks: 1 + Math.round(8 * extents[c] / Math.max(...extents)), title: {text: `${name}${from(data.origin[c])} [m]`}, showbackground: false, gridcolor: "#eee9e1", zerolinecolor: "#eee9e1", showspikes: false});
// The longest extent fills the picture: its height, or its width where that is much less.
const fills = 1.35 * Math.min(1, 1.25 * at("view").clientWidth / at("view").clientHeight);
const [x, y, z] = extents.map(e => fills * e / Math.max(...extents));
const layout = {
  margin: {l: 0, r: 0, t: 0, b: 0}, showlegend: false, uirevision: "kept",
  scene: {aspectmode: "manual", aspectratio: {x, y, z}, xaxis: axis("x", 0), yaxis: axis("y", 1), zaxis: axis("z", 2), dragmode: "orbit",
          camera: {projection: {type: "orthographic"}, eye: Object.fromEntries(["x", "y", "z"].map((c, k) => [c, 2.2 * data.look.eye[k]]))}},
};
// No button but these: plotly has others, which would send what is drawn to a server.
const config = {
  displaylogo: false, responsive: true, plotlyServerURL: "", showSendToCloud: false,
  modeBarButtons: [["toImage"], ["zoom3d", "pan3d", "orbitRotation", "tableRotation"], ["resetCameraDefault3d"]],
  toImageButtonOptions: {filename: data.name, scale: 2},
};

// ---------------------------------------------------------------- drawing
/** Draw everything, or of a large model, while a slider moves, only the blocks. */
async function draw(sketch) {
  const moved = displaced(blocks.vertices, blocks.of_vertex);
  // Joints and forces are those of the collapse state.
  const pushed = shown.step !== null, ofCollapse = ["show-interfaces", "show-forces"];
  const change = traces.map(() => ({visible: false})), ticked = id => at(id).checked && !(pushed && ofCollapse.includes(id));
  change[BLOCKS] = {...xyz(moved), visible: sketch || ticked("show-blocks"), opacity: !sketch && ticked("show-forces") ? 0.35 : 1};
  if (!sketch) {
    change[BLOCKS].facecolor = stones();
    change[GHOST] = {visible: shown.amplitude > 0 && !ticked("show-blocks")};
    change[EDGES] = {...xyz(segments(displaced(outer.blocks, blocks.of_vertex), blocks.edges)), visible: true};
    if (ticked("show-interfaces")) {
      const [faces, edges] = joints();
      // Through blocks that are not opaque, faces would hide the forces.
      change[INTERFACES] = {...faces, visible: !(ticked("show-blocks") && ticked("show-forces"))};
      change[JOINTS] = {...edges, visible: true};
    }
    if (ticked("show-forces")) {
      const {line, heads, corners} = forceArrows();
      change[FORCES] = {...xyz(line), visible: true};
      change[HEADS] = {...xyz(heads), i: column(corners, 0), j: column(corners, 1), k: column(corners, 2), visible: corners.length > 0};
    }
    if (ties.name.length) change[TIES] = {...tieLines(), visible: ticked("show-ties")};
    if (ticked("show-loads"))
      for (const arrows of current().arrows) change[arrows.grows ? VARIABLE : DEAD] = {...xyz(loadArrows(arrows)), visible: true};
    if (shown.picked) change[PICKED] = {...xyz(pickedOutline()), visible: true};
  }
  change.forEach((values, t) => Object.assign(traces[t], values));
  // Plotly sees a change where an object is a new one.
  await Plotly.react("view", traces.map(t => ({...t})), layout, config);
}

const LARGE = 400, REST = 250;
const wanted = {sketch: false, full: false};
let busy = false, rest = null;
/** Draw soon: what is asked for while a picture is made becomes one more. */
async function redraw() { wanted.full = true; return work(); }
/** Draw while a slider moves, in full when it rests for some milliseconds. */
function follow() {
  if (B < LARGE) return redraw();
  document.body.dataset.ready = "no";
  clearTimeout(rest);
  rest = setTimeout(redraw, REST);
  wanted.sketch = true;
  return work();
}
async function work() {
  if (busy) return;
  busy = true;
  document.body.dataset.ready = "no";
  while (wanted.sketch || wanted.full) {
    const sketch = wanted.sketch;
    wanted[sketch ? "sketch" : "full"] = false;
    await new Promise(requestAnimationFrame);
    await draw(sketch);
    if (!sketch) document.body.dataset.ready = "yes";
  }
  busy = false;
}

function pickedOutline() {
  const p = shown.picked;
  if (p.kind === "block") return segments(displaced(outer.blocks, blocks.of_vertex), blocks.edges.filter((_, e) => blocks.of_vertex[blocks.edges[e]] === p.index));
  const corners = displaced(outer.interfaces, interfaces.block_of_vertex), ring = [];
  interfaces.of_vertex.forEach((i, v) => { if (i === p.index) ring.push(...corners.slice(3 * v, 3 * v + 3)); });
  return Float32Array.from([...ring, ...ring.slice(0, 3)]);
}

// ---------------------------------------------------------------- the panel
function readable(value, unit) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value), [factor, prefix] = size >= 1e6 ? [1e-6, "M"] : size >= 1e3 ? [1e-3, "k"] : [1, ""];
  return `${Number((value * factor).toPrecision(3))} ${prefix}${unit}`;
}
const metres = v => v.every(Number.isFinite) ? v.map(c => Number(c.toPrecision(3))).join(", ") + " m" : "–";
/** Place from local coordinates, to about a thousandth of the model's size. */
const decimals = Math.min(20, Math.max(0, 4 - Math.ceil(Math.log10(blocks.size))));
const place = v => v.map((c, k) => Number((data.origin[k] + c).toFixed(decimals))).join(", ") + " m";
const share = v => Number.isFinite(v) ? Number(v.toPrecision(3)).toString() : "–";

function describe() {
  const p = shown.picked, panel = at("picked");
  panel.replaceChildren();
  if (!p) { panel.textContent = "Click a block or an interface. Hide the blocks to reach interfaces inside."; return; }
  const rows = [], i = p.index, moved = shown.step !== null;
  if (p.kind === "block") {
    const rest = Array.from(blocks.centroids.slice(3 * i, 3 * i + 3)), scale = largest();
    const u = moved ? rest.map((c, a) => current().motion.places[(shown.step * B + i) * 12 + 9 + a] - c)
      : Array.from(current().velocity.slice((shown.iteration * B + i) * 6, (shown.iteration * B + i) * 6 + 3), c => c * scale);
    rows.push(["block", blocks.name[i] + (blocks.support[i] ? ` (${blocks.support[i]})` : "")], ["material", blocks.material[i]],
      ["weight", readable(blocks.weight[i], "N")], ["volume", `${Number(blocks.volume[i].toPrecision(3))} m³`],
      ["centroid", place(rest)], ["translation", metres(u)]);
    if (!moved) rows.push(["macro-block", (current().bodies[current().body[i]] || {name: "at rest"}).name]);
  } else {
    const {local, e} = resultant(i);
    rows.push(["interface", interfaces.name[i]], ["joint", interfaces.joint[i]],
      ["area", `${Number(interfaces.area[i].toPrecision(3))} m²`]);
    // Forces are those of an iteration.
    if (!moved) rows.push(["state", current().states[stateOf(i)]], ["N", readable(local[0], "N")],
      ["V", readable(Math.hypot(local[1], local[2]), "N")], ["eccentricity", metres(e)],
      ["sliding", share(utilisation("sliding", i))], ["crushing", share(utilisation("crushing", i))]);
  }
  const table = document.createElement("table");
  for (const [name, value] of rows) {
    const row = table.insertRow();
    row.insertCell().textContent = name;
    row.insertCell().textContent = value;
  }
  panel.append(table);
}

function entry(colour, name) {
  const item = document.createElement("span"), box = document.createElement("i");
  box.style.background = colour;
  item.append(box, name);
  return item;
}
function legend() {
  const named = at("show-bodies").checked ? current().bodies.slice(0, data.look.bodies.length) : [];
  at("bodies").replaceChildren(...named.map((body, k) => entry(data.look.bodies[k], `${body.name}, ${readable(body.weight, "N")}${body.carried ? `, ${readable(body.carried, "N")} of it carried` : ""}`)));
  at("legend").replaceChildren();
  if (shown.colour !== "state") return;
  // A joint has the colour of the gravest of its states; the legend names all that it stands for.
  const present = {};
  for (let i = 0; i < I; i++) (present[current().gravest[stateOf(i)]] ??= new Set()).add(current().states[stateOf(i)]);
  for (const [name, colour] of Object.entries(data.look.states)) {
    if (present[name] && name !== "sticking") at("legend").append(entry(colour, [...present[name]].sort().join(", ")));
  }
}

function tieTable() {
  at("ties").replaceChildren();
  for (const [k, [state, force, longer]] of tieRows().entries()) {
    const row = at("ties").insertRow(), box = document.createElement("i");
    box.style.background = data.look.ties[state];
    row.insertCell().append(box, ties.name[k]);
    row.insertCell().textContent = state;
    row.insertCell().textContent = force === null ? "–" : readable(force, "N");
    if (Number.isFinite(longer)) row.insertCell().textContent = `${Number((1e3 * longer).toPrecision(3))} mm longer`;
  }
}

/** Logarithmic axis over whole powers of ten, so that at least two of them have numbers. */
function decades(values) {
  const powers = values.filter(v => v > 0).map(Math.log10);
  if (!powers.length) return {type: "log"};
  const low = Math.floor(Math.min(...powers)), high = Math.max(low + 1, Math.ceil(Math.max(...powers)));
  return {type: "log", exponentformat: "power", range: [low - 0.1, high + 0.1], tick0: low, dtick: Math.ceil((high - low) / 4)};
}
function convergence() {
  const c = current(), n = c.stage.length, numbers = [...Array(n).keys()];
  const line = (y, name, more) => ({x: numbers, y, name, mode: "lines+markers", marker: {size: 5}, line: {width: 1.2}, ...more});
  const gap = c.measures["flow-rule gap"], found = c.answers.filter(v => v !== null);
  // Answers that hardly differ are drawn as level.
  const low = Math.min(...found), high = Math.max(...found), margin = Math.max(0.05 * (high - low), 0.005 * Math.abs(high) - (high - low) / 2);
  Plotly.react("convergence", [
    line(c.answers, c.answer.name, {text: c.stage, line: {color: "#0072b2", width: 1.2}}),
    line(gap, "flow-rule gap", {yaxis: "y2", line: {color: "#2b2925", width: 1.2}}),
  ], {
    margin: {l: 48, r: 8, t: 22, b: 38}, showlegend: false, font: {size: 11},
    annotations: [[`${c.answer.symbol} [${c.answer.unit}]`, 1], ["flow-rule gap [-]", 0.46]].map(([text, y]) => ({text, x: 0, y, xref: "paper", yref: "paper", xanchor: "left", yanchor: "bottom", showarrow: false})),
    xaxis: {title: {text: "numerical iteration [-]"}, anchor: "y2", range: [-0.5, n - 0.5], tick0: 0, dtick: Math.ceil(n / 8)},
    yaxis: {domain: [0.6, 1], range: found.length ? [low - margin, high + margin] : [0, 1]},
    yaxis2: {domain: [0, 0.46], ...decades(gap)},
    shapes: [{type: "line", x0: shown.iteration, x1: shown.iteration, y0: 0, y1: 1, yref: "paper", line: {color: "#d55e00", width: 1.5}}],
  }, {...config, displayModeBar: false});
}

/** Number of a state to four digits; where the curve ends at zero it is none. */
function valueAt(p, k) {
  const value = p.values[k];
  return Math.abs(value) < 1e-4 * Math.abs(p.values[0]) ? 0 : Number(value.toPrecision(4));
}

function capacityCurve() {
  const p = current().motion;
  for (const id of ["pushover", "capacity-title", "capacity"]) at(id).hidden = !p;
  if (!p) return;
  const n = p.along.length, k = shown.step;
  at("capacity-title").textContent = p.title;
  at("step").max = n - 1;
  at("step").value = k ?? 0;
  at("step-value").textContent = k === null ? `of ${n - 1}` : `${k} of ${n - 1}, ${Number(p.along[k].toPrecision(4))} ${p.x_unit}, ${p.y} = ${valueAt(p, k)}${p.y_unit === "mm" ? " mm" : ""}`;
  Plotly.react("capacity", [
    {x: p.along, y: p.values, mode: "lines+markers", marker: {size: 4}, line: {color: "#0072b2", width: 1.2}},
  ], {
    margin: {l: 48, r: 8, t: 8, b: 38}, showlegend: false, font: {size: 11},
    xaxis: {title: {text: `${p.x} [${p.x_unit}]`}, rangemode: "tozero"},
    yaxis: {title: {text: `${p.y} [${p.y_unit}]`}, rangemode: "tozero"},
    shapes: k === null ? [] : [{type: "line", x0: p.along[k], x1: p.along[k], y0: 0, y1: 1, yref: "paper", line: {color: "#d55e00", width: 1.5}}],
  }, {...config, displayModeBar: false});
}

function iterationText() {
  const c = current(), i = shown.iteration, value = c.answers[i];
  at("iteration").value = i;
  at("iteration-value").textContent = `${i} of ${c.stage.length - 1}, ${c.stage[i]}, ${c.answer.symbol} = ${value === null ? "–" : Number(value.toPrecision(5))}`;
  at("amplitude-value").textContent = `${Number(largest().toPrecision(3))} m`;
}

function update(drawing = redraw) { iterationText(); legend(); tieTable(); describe(); convergence(); capacityCurve(); return drawing(); }
/** Show a state of the motion, or none of them. */
function chooseStep(step, drawing = redraw) { shown.step = step; capacityCurve(); tieTable(); describe(); return drawing(); }

function chooseCase(index) {
  shown.case = index;
  const c = current(), isRecord = Boolean(c.motion) && c.motion.x === "time";
  // A record has no collapse mechanism: its last state is shown.
  shown.step = isRecord ? c.motion.along.length - 1 : null;
  for (const part of document.querySelectorAll(".of-iterations")) part.hidden = isRecord;
  shown.iteration = c.stage.length - 1;
  at("iteration").max = shown.iteration;
  at("loads").textContent = c.loads;
  at("show-loads").disabled = !c.arrows.length;
  at("answer").textContent = `${c.answer.name[0].toUpperCase()}${c.answer.name.slice(1)} ${c.answer.symbol}`;
  at("load-factor").textContent = c.head.number;
  at("below").replaceChildren(...c.head.below.map(text => Object.assign(document.createElement("p"), {textContent: text})));
  at("status").textContent = c.status;
  at("certificate").textContent = c.certificate;
  return update();
}
function pick(kind, index) {
  shown.picked = {kind, index};
  at("find").value = (kind === "block" ? blocks : interfaces).name[index];
  describe();
  return redraw();
}
function find(name) {
  for (const [kind, bodies] of [["block", blocks], ["interface", interfaces]]) {
    const index = bodies.name.indexOf(name);
    if (index >= 0) return pick(kind, index);
  }
  shown.picked = null;
  describe();
  return redraw();
}

/** Move the mechanism to and fro between rest and its amplitude, until it is asked to stop. */
const PERIOD = 4000;
let playing = false;
async function play() {
  playing = !playing;
  at("play").textContent = playing ? "■ stop" : "▶ play";
  if (!playing) return;
  const amplitude = shown.amplitude || data.look.amplitude, begun = performance.now();
  while (playing) {
    const now = await new Promise(requestAnimationFrame);
    setAmplitude(amplitude * (1 - Math.cos(2 * Math.PI * (now - begun) / PERIOD)) / 2);
    await follow();
  }
  setAmplitude(amplitude);
  await redraw();
}
/** Go through the states of the motion once, until it is asked to stop; those of a record in their time. */
async function playPushover() {
  playing = !playing;
  if (!playing) return;
  at("play-pushover").textContent = "■ stop";
  const {along, x} = current().motion, n = along.length, begun = performance.now();
  const lasts = x === "time" ? 1e3 * (along[n - 1] - along[0]) : PERIOD;
  for (let step = 0; playing && step < n - 1;) {
    const now = await new Promise(requestAnimationFrame);
    step = Math.min(n - 1, Math.floor(n * (now - begun) / lasts));
    await chooseStep(step, follow);
  }
  playing = false;
  at("play-pushover").textContent = "▶ play";
  await redraw();
}
function setAmplitude(value) {
  shown.step = null;
  shown.amplitude = value;
  at("amplitude").value = value;
  iterationText();
  tieTable();
}

async function start() {
  at("name").textContent = data.name;
  data.cases.forEach((c, k) => at("case").append(new Option(c.name, k)));
  for (const why of data.omitted) at("case").append(Object.assign(new Option(why), {disabled: true}));
  for (const [value, text] of [["state", "state"], ["sliding", "utilisation of sliding"], ["crushing", "utilisation of crushing"]])
    at("colour").append(new Option(text, value));
  await Plotly.newPlot("view", traces, layout, config);
  at("case").value = data.first;
  at("amplitude").value = shown.amplitude;
  await chooseCase(data.first);
  at("play").addEventListener("click", play);
  at("play-pushover").addEventListener("click", playPushover);
  at("step").addEventListener("input", event => chooseStep(Number(event.target.value), follow));
  at("case").addEventListener("input", event => chooseCase(Number(event.target.value)));
  at("colour").addEventListener("input", event => { shown.colour = event.target.value; update(); });
  at("iteration").addEventListener("input", event => { shown.step = null; shown.iteration = Number(event.target.value); update(follow); });
  at("amplitude").addEventListener("input", event => { shown.amplitude = Number(event.target.value); shown.step = null; iterationText(); tieTable(); describe(); capacityCurve(); follow(); });
  at("find").addEventListener("change", event => find(event.target.value));
  at("show-bodies").addEventListener("change", () => update());
  for (const part of document.querySelectorAll(".of-ties")) part.hidden = !ties.name.length;
  for (const id of ["show-blocks", "show-interfaces", "show-forces", "show-loads", "show-ties"]) at(id).addEventListener("change", redraw);
  at("convergence").on("plotly_click", event => { shown.iteration = event.points[0].pointNumber; update(); });
  at("view").on("plotly_click", event => {
    // Where every triangle has a colour of its own, a point of a mesh is a triangle.
    const {curveNumber, pointNumber} = event.points[0];
    if (curveNumber === BLOCKS) pick("block", blocks.of_triangle[pointNumber]);
    if (curveNumber === INTERFACES) pick("interface", interfaces.of_triangle[pointNumber]);
  });
}
await start();
