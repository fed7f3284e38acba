// The fabric of a report that can be turned, played and asked. Reads the arrays of viz/live.py from the page itself.
import * as THREE from "three";
import { OrbitControls } from "orbit";
import { cursors } from "cursor";
import { flatMap, rampColour, stamp } from "flatmap";
import { chance, fixed, historyChart, tell } from "history";

const data = JSON.parse(document.getElementById("live-data").textContent);
const section = document.getElementById("live");
const canvas = section.querySelector("canvas");
const el = (name) => section.querySelector(`[data-live="${name}"]`);

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const u16 = (text) => new Uint16Array(bytes(text));
const u32 = (text) => new Uint32Array(bytes(text));
const u8 = (text) => new Uint8Array(bytes(text));
const rgb = (text) => new THREE.Color(text);

const steps = data.at.length;
const points = u16(data.points);
const cells = u32(data.cells);
const perStep = points.length / steps;
for (const field of Object.values(data.fields)) field.values = u8(field.values);
const wirePoints = u16(data.wires.points);
const segments = u32(data.wires.segments);
const wireStrain = u8(data.wires.strain);
for (const loop of data.loops) loop.place = u16(loop.place);
const ramp = data.ramp.map(rgb);
const chances = data.probability_ramp.map(rgb);

function colourOf(share, out, stops = ramp) {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  return out.copy(stops[low]).lerp(stops[low + 1], at - low);
}

function spot(source, offset, low, scale, target, at) {
  for (let axis = 0; axis < 3; axis += 1) target[at + axis] = low[axis] + scale * source[offset + axis];
}

let renderer;
try {
  renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
} catch (error) {
  renderer = null; // no WebGL: the still pictures and the tables say the same
}
if (renderer) start();

function start() {
  section.hidden = false;
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  const scene = new THREE.Scene();
  scene.background = new THREE.Color("#ffffff");
  const camera = new THREE.PerspectiveCamera(32, 1.5, 1, 5000);
  camera.up.set(0, 0, 1);
  scene.add(new THREE.HemisphereLight("#ffffff", "#b9c0c8", 2.2));
  const sun = new THREE.DirectionalLight("#ffffff", 1.4);
  sun.position.set(0.5, -1, 2);
  scene.add(sun);
  const controls = new OrbitControls(camera, canvas);

  // fabric: six corners a cell, one colour a cell, and the edges of the cells as thin lines
  const order = [0, 1, 2, 0, 2, 3];
  const corners = new Uint32Array((cells.length / 4) * 6);
  for (let c = 0; c < cells.length / 4; c += 1) order.forEach((k, i) => { corners[6 * c + i] = cells[4 * c + k]; });
  const fabricPlace = new Float32Array(corners.length * 3);
  const fabricColour = new Float32Array(corners.length * 3);
  const fabricShape = new THREE.BufferGeometry();
  fabricShape.setAttribute("position", new THREE.BufferAttribute(fabricPlace, 3));
  fabricShape.setAttribute("color", new THREE.BufferAttribute(fabricColour, 3));
  const fabric = new THREE.Mesh(fabricShape, new THREE.MeshLambertMaterial({
    vertexColors: true, side: THREE.DoubleSide, flatShading: true, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2,
  }));
  scene.add(fabric);
  const seen = new Set();
  const edges = [];
  for (let c = 0; c < cells.length; c += 4) {
    for (let k = 0; k < 4; k += 1) {
      const [a, b] = [cells[c + k], cells[c + ((k + 1) % 4)]];
      const key = a < b ? a * 4294967 + b : b * 4294967 + a;
      if (!seen.has(key)) { seen.add(key); edges.push(a, b); }
    }
  }
  const edgePlace = new Float32Array(edges.length * 3);
  const edgeShape = new THREE.BufferGeometry();
  edgeShape.setAttribute("position", new THREE.BufferAttribute(edgePlace, 3));
  scene.add(new THREE.LineSegments(edgeShape, new THREE.LineBasicMaterial({ color: "#20242a", transparent: true, opacity: 0.22 })));

  // lines and marks lie on the fabric: they are drawn a little nearer than they are
  function nearer(material, by) {
    material.onBeforeCompile = (shader) => {
      shader.vertexShader = shader.vertexShader.replace("#include <fog_vertex>", `#include <fog_vertex>\n  gl_Position.z -= ${by} * gl_Position.w;`);
    };
    return material;
  }

  // wires
  const wirePlace = new Float32Array(segments.length * 3);
  const wireColour = new Float32Array(segments.length * 3);
  const wireShape = new THREE.BufferGeometry();
  wireShape.setAttribute("position", new THREE.BufferAttribute(wirePlace, 3));
  wireShape.setAttribute("color", new THREE.BufferAttribute(wireColour, 3));
  scene.add(new THREE.LineSegments(wireShape, nearer(new THREE.LineBasicMaterial({ vertexColors: true }), 0.0008)));

  // body
  let body = null;
  let bodyPoints = null;
  if (data.body) {
    bodyPoints = u16(data.body.points);
    const shape = new THREE.BufferGeometry();
    const count = bodyPoints.length / (1 + Math.max(...data.body.pose));
    shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(count), 3));
    shape.setIndex(new THREE.BufferAttribute(u32(data.body.faces), 1));
    body = new THREE.Mesh(shape, new THREE.MeshLambertMaterial({ color: data.body_colour, side: THREE.DoubleSide }));
    scene.add(body);
  }

  // loops: one cloud of sprites per state, with the markers of the maps
  const clouds = data.states.map((look) => {
    const shape = new THREE.BufferGeometry();
    shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(data.loops.length * 3), 3));
    const cloud = new THREE.Points(shape, nearer(new THREE.PointsMaterial({
      size: 13 * renderer.getPixelRatio(), sizeAttenuation: false, map: marker(look), alphaTest: 0.4, transparent: true,
    }), 0.0018));
    cloud.frustumCulled = false;
    scene.add(cloud);
    return cloud;
  });
  // loops by probability: circles of their own colours
  const doubtColour = new Float32Array(data.loops.length * 3);
  const doubts = new THREE.Points(
    new THREE.BufferGeometry()
      .setAttribute("position", new THREE.BufferAttribute(new Float32Array(data.loops.length * 3), 3))
      .setAttribute("color", new THREE.BufferAttribute(doubtColour, 3)),
    nearer(new THREE.PointsMaterial({ size: 13 * renderer.getPixelRatio(), sizeAttenuation: false, map: marker({ marker: "o", colour: "#ffffff" }), alphaTest: 0.4, transparent: true, vertexColors: true }), 0.0018),
  );
  doubts.frustumCulled = false;
  scene.add(doubts);
  // parts: their lands as plates a little above the fabric, with their names while they are few
  const parts = data.parts ? { places: u16(data.parts.places), count: data.parts.names.length, labels: [] } : null;
  if (parts) {
    parts.shape = new THREE.BufferGeometry();
    parts.shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(parts.count * 12), 3));
    parts.shape.setIndex([...Array(parts.count).keys()].flatMap((k) => order.map((i) => 4 * k + i)));
    const plate = new THREE.MeshBasicMaterial({ color: "#2f3a46", transparent: true, opacity: 0.55, side: THREE.DoubleSide });
    parts.mesh = new THREE.Mesh(parts.shape, nearer(plate, 0.0006));
    parts.mesh.frustumCulled = false;
    scene.add(parts.mesh);
    if (parts.count <= 40) parts.labels = data.parts.names.map((name) => label(name, scene));
  }
  const ring = new THREE.Points(
    new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(new Float32Array(3), 3)),
    new THREE.PointsMaterial({ size: 26 * renderer.getPixelRatio(), sizeAttenuation: false, map: circle(), alphaTest: 0.3, depthTest: false, transparent: true }),
  );
  ring.visible = false;
  ring.frustumCulled = false;
  scene.add(ring);

  const state = { step: steps - 1, field: Object.keys(data.fields)[0], chosen: -1, playing: null, view: "reset" };
  const places = new Float32Array(data.loops.length * 3);
  const flatPlaces = u16(data.flat.segments);
  const flat = flatMap(el("flat"), {
    low: data.flat.low,
    high: data.flat.high,
    lines: Float32Array.from(flatPlaces, (value, i) => data.flat.low[i % 2] + data.flat.scale * value),
    loops: data.loops.map((loop) => loop.flat),
    parts: data.parts?.names.map((name, k) => ({ name, corners: data.parts.flat[k] })),
  });
  const follow = cursors();
  const tint = new THREE.Color();

  function shown(k) {
    const loop = data.loops[k];
    const wanted = el("filter").querySelector(`input[value="${loop.states[state.step]}"]`);
    return wanted.checked && named(loop.wire);
  }

  function named(wire) {
    const word = el("search").value.trim().toLowerCase();
    if (!word) return true;
    const nets = Object.entries(data.wires.nets).filter(([, wires]) => wires.includes(wire)).map(([name]) => name.toLowerCase());
    const name = (data.wires.names[wire] ?? String(wire)).toLowerCase();
    return name === word || (Number.isNaN(Number(word)) && (name.includes(word) || nets.some((net) => net.includes(word))));
  }

  function update() {
    const s = state.step;
    for (let i = 0; i < corners.length; i += 1) spot(points, s * perStep + 3 * corners[i], data.low, data.scale, fabricPlace, 3 * i);
    for (let i = 0; i < edges.length; i += 1) spot(points, s * perStep + 3 * edges[i], data.low, data.scale, edgePlace, 3 * i);
    const field = data.fields[state.field];
    const count = cells.length / 4;
    const bare = state.field === "none";
    for (let c = 0; c < count; c += 1) {
      colourOf(bare || !field ? 0 : field.values[s * count + c] / 250, tint);
      for (let i = 0; i < 6; i += 1) tint.toArray(fabricColour, 18 * c + 3 * i);
    }
    const many = wirePoints.length / steps;
    for (let i = 0; i < segments.length; i += 1) spot(wirePoints, s * many + 3 * segments[i], data.low, data.scale, wirePlace, 3 * i);
    for (let k = 0; k < segments.length / 2; k += 1) {
      const wire = data.wires.wire[k];
      if (state.field === "probability") colourOf(data.wires.broken[wire] ?? 0, tint, chances);
      else if (state.field === "wire_strain") colourOf(wireStrain[(s * segments.length) / 2 + k] / 250, tint);
      else tint.set(data.wires.colour[data.wires.state[s][wire] ?? 0]);
      if (!named(wire)) tint.set("#e4e7ea");
      tint.toArray(wireColour, 6 * k);
      tint.toArray(wireColour, 6 * k + 3);
    }
    const filled = clouds.map(() => 0);
    let doubtful = 0;
    const byChance = state.field === "probability";
    data.loops.forEach((loop, k) => {
      spot(loop.place, 3 * s, data.low, data.scale, places, 3 * k);
      if (!shown(k)) return;
      if (byChance) {
        doubts.geometry.attributes.position.array.set(places.subarray(3 * k, 3 * k + 3), 3 * doubtful);
        colourOf(loop.broken, tint, chances).toArray(doubtColour, 3 * doubtful);
        doubtful += 1;
        return;
      }
      const to = loop.states[s];
      clouds[to].geometry.attributes.position.array.set(places.subarray(3 * k, 3 * k + 3), 3 * filled[to]);
      filled[to] += 1;
    });
    clouds.forEach((cloud, i) => {
      cloud.geometry.setDrawRange(0, filled[i]);
      cloud.geometry.attributes.position.needsUpdate = true;
    });
    doubts.geometry.setDrawRange(0, doubtful);
    for (const item of Object.values(doubts.geometry.attributes)) item.needsUpdate = true;
    for (const shape of [fabricShape, edgeShape, wireShape]) {
      for (const item of Object.values(shape.attributes)) item.needsUpdate = true;
      shape.computeBoundingSphere();
    }
    if (body) moveBody(s);
    if (parts) moveParts(s);
    ring.visible = state.chosen >= 0;
    if (ring.visible) {
      ring.geometry.attributes.position.array.set(places.subarray(3 * state.chosen, 3 * state.chosen + 3));
      ring.geometry.attributes.position.needsUpdate = true;
    }
    el("slider").value = s;
    el("slider").setAttribute("aria-valuetext", data.moment[s]);
    el("moment").textContent = data.moment[s];
    el("counts").textContent = data.states.map((look, i) => `${i > 3 ? look.label : look.name} ${data.loops.filter((loop) => loop.states[s] === i).length}`).join(", ");
    legend();
    history();
    draw();
    drawFlat();
    follow(data.at[s]);
  }

  // colour of a wire's segment as text, the same in both pictures
  function wireLook(k) {
    const [s, wire] = [state.step, data.wires.wire[k]];
    if (!named(wire)) return "#e4e7ea";
    if (state.field === "probability") return rampColour(data.probability_ramp, data.wires.broken[wire] ?? 0);
    if (state.field === "wire_strain") return rampColour(data.ramp, wireStrain[(s * segments.length) / 2 + k] / 250);
    return data.wires.colour[data.wires.state[s][wire] ?? 0];
  }

  function loopLook(k) {
    if (!shown(k)) return null;
    const loop = data.loops[k];
    if (state.field === "probability") return { colour: rampColour(data.probability_ramp, loop.broken), marker: "o" };
    const look = data.states[loop.states[state.step]];
    return { colour: look.colour, marker: look.marker, edge: look.marker === "X" ? "#ffffff" : "#1a1a1a" };
  }

  function drawFlat() { flat.draw({ line: wireLook, mark: loopLook, chosen: state.chosen }); }

  function moveParts(s) {
    const place = parts.shape.attributes.position;
    for (let i = 0; i < place.array.length; i += 3) spot(parts.places, s * place.array.length + i, data.low, data.scale, place.array, i);
    place.needsUpdate = true;
    parts.labels.forEach((sprite, k) => {
      const corner = [0, 1, 2].map((axis) => [0, 3, 6, 9].map((i) => place.array[12 * k + i + axis]));
      sprite.position.set(...corner.map((values) => values.reduce((a, b) => a + b) / 4));
    });
  }

  function moveBody(s) {
    const place = body.geometry.attributes.position;
    const count = place.array.length;
    const from = data.body.pose[s] * count;
    for (let i = 0; i < count; i += 3) spot(bodyPoints, from + i, data.body.low, data.body.scale, place.array, i);
    place.needsUpdate = true;
    body.geometry.computeVertexNormals();
    const normal = body.geometry.attributes.normal.array;
    for (let i = 0; i < count; i += 1) place.array[i] -= data.body.shrink * normal[i]; // flat cells cut into a round body
    body.geometry.computeBoundingSphere();
    if (data.body.shift) body.position.fromArray(data.body.shift[s]);
  }

  function draw() { renderer.render(scene, camera); }

  function look(view) {
    state.view = view;
    fabricShape.computeBoundingBox();
    const box = fabricShape.boundingBox;
    const centre = box.getCenter(new THREE.Vector3());
    const radius = box.getSize(new THREE.Vector3()).length() / 2;
    const towards = { reset: [0.5, -1.05, 0.75], top: [0, -0.0001, 1], side: [0, -1, 0.02] }[view];
    const narrow = Math.min(1, camera.aspect / 1.25);
    if (view !== "top") centre.z -= 0.1 * radius;
    camera.position.copy(centre).add(new THREE.Vector3(...towards).normalize().multiplyScalar((0.86 * radius) / Math.sin((camera.fov * Math.PI) / 360) / narrow));
    camera.near = 0.15 * radius;
    camera.far = 12 * radius;
    camera.updateProjectionMatrix();
    controls.target.copy(centre);
    controls.update();
    draw();
  }

  function fit() {
    const width = canvas.parentElement.clientWidth;
    const height = Math.max(260, Math.min(470, width * 0.72));
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
    const beside = el("flat").parentElement.clientWidth;
    const tall = ((beside - 28) * (data.flat.high[1] - data.flat.low[1])) / (data.flat.high[0] - data.flat.low[0] || 1) + 46;
    flat.fit(beside, beside < 0.9 * width ? height : Math.max(150, Math.min(height, tall)));
    drawFlat();
  }

  function onScreen(k) {
    const at = new THREE.Vector3().fromArray(places, 3 * k).project(camera);
    return { x: ((at.x + 1) / 2) * canvas.clientWidth, y: ((1 - at.y) / 2) * canvas.clientHeight, depth: at.z };
  }

  function nearest(event) {
    if (event.currentTarget === el("flat")) return flat.nearest(event, shown);
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let [best, near] = [-1, 14];
    data.loops.forEach((_, k) => {
      if (!shown(k)) return;
      const at = onScreen(k);
      const far = Math.hypot(at.x - x, at.y - y);
      if (far < near) { near = far; best = k; }
    });
    return best;
  }

  function facts(loop) {
    const s = state.step;
    const unit = data.axis.unit;
    const before = s > 0 ? `, ${fixed(loop.strain[s - 1], 4)} at ${fixed(data.at[s - 1], 1)} ${unit} before` : "";
    const late = data.at.findIndex((at) => loop.fails_at !== null && loop.fails_at !== undefined && at >= loop.fails_at);
    const around = [late - 1, late].filter((step) => step >= 0).map((step) => `${fixed(loop.strain[step], 4)} at ${fixed(data.at[step], 1)} ${unit}`);
    return [
      ["Wire", loop.name], ["Loop", String(loop.loop)],
      ["Position", `warp ${fixed(loop.warp_mm, 1)}, weft ${fixed(loop.weft_mm, 1)} mm`],
      [`Strain${loop.kind ? ` of the ${loop.kind}` : ""} here`, `${fixed(loop.strain[s], 4)}${before}`],
      ["Greatest strain", fixed(loop.max_strain, 3)],
      ["State at the end", data.states[loop.states.at(-1)].name === "folded" ? `${loop.state}, but in a fold: undetermined` : loop.state],
      ["First filament breaks at", loop.fails_at === null || loop.fails_at === undefined ? "-" : `${fixed(loop.fails_at, 1)} ${unit}`],
      ...(late < 0 ? [] : [["Strain about the break", around.join(", ")]]),
      ["P, a filament breaks", chance(loop.broken)], ["P, interrupted", chance(loop.open)],
    ];
  }

  function hover(event) {
    const k = nearest(event);
    const tip = el("tip");
    const over = event.currentTarget;
    over.style.cursor = k >= 0 ? "pointer" : over === canvas ? "grab" : "default";
    tip.hidden = k < 0;
    if (k < 0) return;
    over.parentElement.append(tip);
    tell(tip, facts(data.loops[k]));
    const [x, y] = over === canvas ? [onScreen(k).x, onScreen(k).y] : flat.at(k);
    tip.style.left = `${Math.max(4, Math.min(x + 14, over.clientWidth - 290))}px`;
    tip.style.top = `${Math.max(0, Math.min(y + 12, over.clientHeight - 225))}px`;
  }

  function choose(k) {
    state.chosen = k;
    el("pick").value = String(k);
    update();
  }

  function history() {
    const panel = el("history");
    panel.hidden = state.chosen < 0;
    if (panel.hidden) return;
    const loop = data.loops[state.chosen];
    tell(el("facts"), facts(loop));
    el("chart").replaceChildren(historyChart({
      lines: [{ x: data.at, y: loop.strain }],
      now: data.at[state.step],
      onset: data.onset ? { at: data.onset, label: `onset ${data.onset.toFixed(3)}` } : null,
      most: Math.max(0.001, data.onset ?? 0, ...loop.strain),
      label: `Strain of wire ${loop.name}, loop ${loop.loop}, over ${data.axis.name}`,
      axis: `${data.axis.name}, ${data.axis.unit}`,
    }));
  }

  function legend() {
    const other = {
      wire_strain: { label: "Wire strain", most: data.wires.most, unit: "%" },
      probability: { label: "Probability that a filament breaks, whole motion", most: 1, unit: "" },
    };
    const field = other[state.field] ?? data.fields[state.field];
    el("legend").hidden = !field;
    if (!field) return;
    const stops = state.field === "probability" ? data.probability_ramp : data.ramp;
    el("ramp").style.background = `linear-gradient(to right, ${stops.join(",")})`;
    el("label").textContent = field.unit ? `${field.label}, ${field.unit}` : field.label;
    el("most").textContent = `${field.most}`;
  }

  function stop() {
    clearInterval(state.playing);
    state.playing = null;
    el("play").textContent = "Play";
    el("play").setAttribute("aria-pressed", "false");
  }

  function play() {
    if (state.playing) { stop(); return; }
    if (state.step === steps - 1) state.step = 0;
    el("play").textContent = "Pause";
    el("play").setAttribute("aria-pressed", "true");
    state.playing = setInterval(() => {
      if (state.step >= steps - 1) { stop(); return; }
      state.step += 1;
      update();
    }, Math.max(80, 3000 / steps));
    update();
  }

  const worst = data.loops.map((_, k) => k).sort((a, b) => (data.loops[b].broken - data.loops[a].broken) || (data.loops[b].max_strain - data.loops[a].max_strain));
  for (const k of worst) {
    const loop = data.loops[k];
    el("pick").append(new Option(`wire ${loop.name}, loop ${loop.loop}: ${loop.state}, P ${chance(loop.broken)}`, String(k)));
  }
  for (const [name, field] of Object.entries(data.fields)) el("field").append(new Option(field.label, name));
  if (segments.length) el("field").append(new Option("Wire strain", "wire_strain"));
  if (data.loops.length) el("field").append(new Option("Probability", "probability"));
  el("field").append(new Option("Cloth alone", "none"));
  el("slider").max = steps - 1;
  el("slider").addEventListener("input", (event) => { state.step = Number(event.target.value); update(); });
  el("play").addEventListener("click", play);
  const first = data.first;
  el("first").hidden = !first;
  if (first) {
    el("first").textContent = first.breaks ? "First break" : "Likeliest to break";
    el("first").addEventListener("click", () => {
      if (first.step !== null) state.step = first.step;
      choose(first.number);
    });
  }
  for (const view of ["reset", "top", "side"]) el(view).addEventListener("click", () => look(view));
  el("field").addEventListener("change", (event) => { state.field = event.target.value; update(); });
  data.states.slice(4).forEach((look, k) => { // loops in folds, where there are any
    const box = Object.assign(document.createElement("input"), { type: "checkbox", value: String(4 + k), checked: true });
    const item = document.createElement("label");
    item.append(box, ` ◇ ${look.label}`);
    el("filter").append(item);
  });
  el("filter").addEventListener("change", update);
  el("search").addEventListener("input", update);
  el("pick").addEventListener("change", (event) => choose(Number(event.target.value)));
  let pressed = null;
  for (const picture of [canvas, el("flat")]) {
    picture.addEventListener("pointermove", hover);
    picture.addEventListener("pointerleave", () => { el("tip").hidden = true; });
    picture.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
    picture.addEventListener("pointerup", (event) => {
      if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 5) {
        const k = nearest(event);
        if (k >= 0) choose(k);
      }
    });
  }
  canvas.addEventListener("keydown", (event) => {
    const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }[event.key];
    const zoom = { "+": 0.9, "-": 1.1 }[event.key];
    if (!turn && !zoom) return;
    event.preventDefault();
    const away = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target).applyAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2));
    if (turn) { away.theta += turn[0]; away.phi = Math.min(Math.max(away.phi + turn[1], 0.02), 3.1); }
    if (zoom) away.radius *= zoom;
    camera.position.copy(new THREE.Vector3().setFromSpherical(away).applyAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2).add(controls.target));
    controls.update();
    draw();
  });
  controls.addEventListener("change", draw);
  window.addEventListener("resize", fit);
  if (!data.loops.length) for (const name of ["flat-box", "filter", "search-box", "pick-box", "counts"]) el(name).hidden = true;
  state.chosen = first ? first.number : -1; // the page opens with the history of the loop that matters most
  el("pick").value = String(state.chosen);
  el("flat-box").parentElement.classList.toggle("alone", !data.loops.length);
  fit();
  update();
  look("reset");
  section.dataset.ready = "true";
  window.etextile = { state, data, onScreen, draw, update };
}

function marker(look) {
  const sheet = document.createElement("canvas");
  sheet.width = sheet.height = 64;
  stamp(sheet.getContext("2d"), 32, 33, 22, { ...look, edge: look.marker === "X" ? "#ffffff" : "#1a1a1a" });
  return new THREE.CanvasTexture(sheet);
}

// a name that faces the reader and keeps its size on the screen
function label(name, scene) {
  const sheet = document.createElement("canvas");
  const pen = sheet.getContext("2d");
  const font = "26px system-ui, 'DejaVu Sans', sans-serif";
  pen.font = font;
  [sheet.width, sheet.height] = [Math.ceil(pen.measureText(name).width) + 8, 34];
  pen.font = font;
  pen.lineWidth = 5;
  pen.strokeStyle = "#ffffff";
  pen.strokeText(name, 4, 26);
  pen.fillStyle = "#1a1a1a";
  pen.fillText(name, 4, 26);
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: new THREE.CanvasTexture(sheet), sizeAttenuation: false, depthTest: false }));
  sprite.scale.set((0.021 * sheet.width) / sheet.height, 0.021, 1);
  sprite.center.set(0.5, -0.5);
  scene.add(sprite);
  return sprite;
}

function circle() {
  const sheet = document.createElement("canvas");
  sheet.width = sheet.height = 64;
  const pen = sheet.getContext("2d");
  pen.lineWidth = 6;
  pen.strokeStyle = "#1f6fb2";
  pen.arc(32, 32, 26, 0, 2 * Math.PI);
  pen.stroke();
  return new THREE.CanvasTexture(sheet);
}
