// The deformed fabric in three dimensions, with body, wires, loops and parts: turned by drag and arrow keys, zoomed, asked.
import * as THREE from "three";
import { OrbitControls } from "orbit";
import { stamp, u16, u32 } from "flatmap";
import { names } from "names";

const LEVELS = 250;
const QUAD = [0, 1, 2, 0, 2, 3];
const MOST_NAMES = 40; // parts that are named at once; of more the one that is pointed at
const FILLED = 0.82; // of the picture by the fabric
const NEAR_PX = 14; // a pointer means a loop that is not further away

// shape: arrays of viz/shape.py; ramp: colours of the fabric from none to most; null where the browser has no WebGL
export function turnable(canvas, shape, ramp) {
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  } catch (error) {
    return null; // the still pictures and the tables say the same
  }
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
  const palette = shades(ramp);

  const cells = u32(shape.cells);
  const corners = new Uint32Array((cells.length / 4) * 6);
  for (let c = 0; c < cells.length / 4; c += 1) QUAD.forEach((k, i) => { corners[6 * c + i] = cells[4 * c + k]; });
  const edges = edgesOf(cells);
  const segments = u32(shape.segments);
  const points = moving(shape, shape.points);
  const wirePoints = moving(shape, shape.wire_points);
  const loopPlaces = moving(shape, shape.loops);

  const fabric = geometry(corners.length, true);
  scene.add(new THREE.Mesh(fabric, new THREE.MeshLambertMaterial({
    vertexColors: true, side: THREE.DoubleSide, flatShading: true, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2,
  })));
  const grid = geometry(edges.length);
  scene.add(new THREE.LineSegments(grid, new THREE.LineBasicMaterial({ color: "#20242a", transparent: true, opacity: 0.22 })));
  const wires = geometry(segments.length, true);
  scene.add(new THREE.LineSegments(wires, nearer(new THREE.LineBasicMaterial({ vertexColors: true }), 0.0008)));
  const body = shape.body ? bodyOf(shape.body, scene) : null;
  const parts = shape.parts ? partsOf(shape, scene, canvas) : null;
  const marks = marksOf(loopPlaces.count, renderer.getPixelRatio(), scene);
  const ring = new THREE.Points(geometry(1), new THREE.PointsMaterial({
    size: 26 * renderer.getPixelRatio(), sizeAttenuation: false, map: circle(), alphaTest: 0.3, depthTest: false, transparent: true,
  }));
  ring.frustumCulled = false;
  scene.add(ring);

  const places = new Float32Array(3 * loopPlaces.count);
  const every = all(loopPlaces.count);
  const tint = new THREE.Color();

  // at: a step, or a place between two; cell(k): share of the ramp; line(k): colour; mark(k): look as on the flat map, or null
  function show(at, { cell, line, mark, chosen = -1 }) {
    points.write(at, corners, fabric.attributes.position.array);
    points.write(at, edges, grid.attributes.position.array);
    wirePoints.write(at, segments, wires.attributes.position.array);
    loopPlaces.write(at, every, places);
    for (let c = 0; c < corners.length / 6; c += 1) {
      const from = 3 * Math.round(LEVELS * Math.min(Math.max(cell(c), 0), 1));
      for (let i = 0; i < 18; i += 1) fabric.attributes.color.array[18 * c + i] = palette[from + (i % 3)];
    }
    for (let k = 0; k < segments.length / 2; k += 1) {
      tint.set(line(k));
      tint.toArray(wires.attributes.color.array, 6 * k);
      tint.toArray(wires.attributes.color.array, 6 * k + 3);
    }
    for (const item of [fabric, grid, wires]) changed(item);
    marks(places, mark);
    body?.(at);
    parts?.lay(at);
    ring.visible = chosen >= 0;
    if (ring.visible) {
      ring.geometry.attributes.position.array.set(places.subarray(3 * chosen, 3 * chosen + 3));
      ring.geometry.attributes.position.needsUpdate = true;
    }
    draw();
  }

  function draw() {
    renderer.render(scene, camera);
    parts?.name(camera);
  }

  // however often the view changes, it is drawn once in a frame
  let waiting = false;
  function soon() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
  }

  // the fabric as it is first and last fills the picture, with some room for what it lies on
  function look(view) {
    const seen = [...outline(0), ...outline(shape.steps - 1)];
    const box = new THREE.Box3().setFromPoints(seen);
    const centre = box.getCenter(new THREE.Vector3());
    const radius = box.getSize(new THREE.Vector3()).length() / 2;
    if (body && view !== "top") centre.z -= 0.1 * radius;
    const back = new THREE.Vector3(...{ reset: [0.5, -1.05, 0.75], top: [0, -0.0001, 1], side: [0, -1, 0.02] }[view]).normalize();
    const right = new THREE.Vector3().crossVectors(camera.up, back).normalize();
    const up = new THREE.Vector3().crossVectors(back, right);
    const high = FILLED * Math.tan((camera.fov * Math.PI) / 360);
    const away = seen.map((at) => at.clone().sub(centre)).map((at) => at.dot(back) + Math.max(Math.abs(at.dot(right)) / (high * camera.aspect), Math.abs(at.dot(up)) / high));
    camera.position.copy(centre).addScaledVector(back, Math.max(...away));
    camera.near = 0.15 * radius;
    camera.far = 12 * radius;
    camera.updateProjectionMatrix();
    controls.target.copy(centre);
    controls.update();
    soon();
  }

  // corners of a thousand cells at most
  function outline(step) {
    const some = cells.filter((_, k) => k % (4 * Math.ceil(cells.length / 4000)) < 4);
    const place = new Float32Array(3 * some.length);
    points.write(step, some, place);
    return Array.from(some, (_, k) => new THREE.Vector3().fromArray(place, 3 * k));
  }

  function fit(width, height) {
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
  }

  function onScreen(k) {
    const at = new THREE.Vector3().fromArray(places, 3 * k).project(camera);
    return [((at.x + 1) / 2) * canvas.clientWidth, ((1 - at.y) / 2) * canvas.clientHeight];
  }

  function nearest(event, shown) {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let [best, near] = [-1, NEAR_PX];
    for (let k = 0; k < loopPlaces.count; k += 1) {
      if (!shown(k)) continue;
      const [u, v] = onScreen(k);
      const far = Math.hypot(u - x, v - y);
      if (far < near) { near = far; best = k; }
    }
    return best;
  }

  // this fabric is seen from where the other one is seen
  function adopt(other) {
    camera.position.copy(other.camera.position);
    [camera.near, camera.far] = [other.camera.near, other.camera.far];
    camera.updateProjectionMatrix();
    controls.target.copy(other.controls.target);
    controls.update();
    soon();
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
    soon();
  });
  controls.addEventListener("change", soon);
  return { canvas, show, look, fit, nearest, adopt, at: onScreen, camera, controls };
}

// fabrics that are turned together
export function linked(solids) {
  let leading = null;
  for (const one of solids) {
    one.controls.addEventListener("change", () => {
      if (leading) return;
      leading = one;
      for (const other of solids) if (other !== one) other.adopt(one);
      leading = null;
    });
  }
}

// places (steps, count, 3): what is listed is written as it is at a step, or in a straight line between two; row: of a step
function moving({ low, scale, steps }, text, row = (step) => step) {
  const source = u16(text);
  const width = source.length / steps;
  function write(at, list, target) {
    const step = Math.floor(at);
    const share = at - step;
    const [from, to] = [width * row(step), width * row(share ? step + 1 : step)];
    for (let i = 0; i < list.length; i += 1) {
      for (let axis = 0; axis < 3; axis += 1) {
        const k = 3 * list[i] + axis;
        target[3 * i + axis] = low[axis] + scale * (source[from + k] + share * (source[to + k] - source[from + k]));
      }
    }
  }
  return { count: width / 3, write };
}

const all = (count) => Uint32Array.from({ length: count }, (_, k) => k);

function geometry(count, coloured = false) {
  const made = new THREE.BufferGeometry();
  for (const name of coloured ? ["position", "color"] : ["position"]) made.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * count), 3));
  return made;
}

function changed(item) {
  for (const attribute of Object.values(item.attributes)) attribute.needsUpdate = true;
  item.computeBoundingSphere();
}

function edgesOf(cells) {
  const seen = new Set();
  const edges = [];
  for (let c = 0; c < cells.length; c += 4) {
    for (let k = 0; k < 4; k += 1) {
      const [a, b] = [cells[c + k], cells[c + ((k + 1) % 4)]];
      const key = a < b ? a * 4294967 + b : b * 4294967 + a;
      if (!seen.has(key)) { seen.add(key); edges.push(a, b); }
    }
  }
  return Uint32Array.from(edges);
}

// the ramp in levels, red, green and blue of each behind each other
function shades(ramp) {
  const stops = ramp.map((text) => new THREE.Color(text));
  const found = new Float32Array(3 * (LEVELS + 1));
  const mixed = new THREE.Color();
  for (let level = 0; level <= LEVELS; level += 1) {
    const at = (level / LEVELS) * (stops.length - 1);
    const low = Math.min(Math.floor(at), stops.length - 2);
    mixed.copy(stops[low]).lerp(stops[low + 1], at - low).toArray(found, 3 * level);
  }
  return found;
}

// lines and marks lie on the fabric: they are drawn a little nearer than they are
function nearer(material, by) {
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace("#include <fog_vertex>", `#include <fog_vertex>\n  gl_Position.z -= ${by} * gl_Position.w;`);
  };
  return material;
}

// a body is hidden by what lies behind it by no more than some millimetres along the line of sight: flat cells cut into it
function farther(material, by) {
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace("#include <fog_vertex>", `#include <fog_vertex>
  vec4 behind = projectionMatrix * vec4(mvPosition.xyz + ${by.toFixed(4)} * normalize(mvPosition.xyz), 1.0);
  gl_Position.z = gl_Position.w * behind.z / behind.w;`);
  };
  return material;
}

// a body has a shift at every step when it is rigid, else a pose
function bodyOf(data, scene) {
  const points = moving({ ...data, steps: 1 + Math.max(...data.pose) }, data.points, (step) => data.pose[step]);
  const shape = geometry(points.count);
  shape.setIndex(new THREE.BufferAttribute(u32(data.faces), 1));
  const mesh = new THREE.Mesh(shape, farther(new THREE.MeshLambertMaterial({ color: data.colour, side: THREE.DoubleSide }), data.depth));
  scene.add(mesh);
  return (at) => {
    const place = shape.attributes.position.array;
    points.write(at, all(points.count), place);
    shape.computeVertexNormals();
    const normal = shape.attributes.normal.array;
    for (let i = 0; i < place.length; i += 1) place[i] -= data.shrink * normal[i]; // flat cells cut into a round body
    changed(shape);
    if (!data.shift) return;
    const step = Math.floor(at);
    const next = data.shift[Math.min(step + 1, data.shift.length - 1)];
    mesh.position.fromArray(data.shift[step].map((value, axis) => value + (at - step) * (next[axis] - value)));
  };
}

// parts: their lands as plates a little above the fabric, with their names on the side that is seen
function partsOf(shape, scene, canvas) {
  const { names: known, places } = shape.parts;
  const corners = moving(shape, places);
  const plates = geometry(corners.count);
  plates.setIndex(known.flatMap((_, k) => QUAD.map((i) => 4 * k + i)));
  const mesh = new THREE.Mesh(plates, nearer(new THREE.MeshBasicMaterial({ color: "#2f3a46", transparent: true, opacity: 0.55, side: THREE.DoubleSide }), 0.0006));
  mesh.frustumCulled = false;
  scene.add(mesh);
  const place = plates.attributes.position.array;
  const write = names(canvas);
  const corner = (k, i) => new THREE.Vector3().fromArray(place, 12 * k + 3 * i);
  let pointer = null;
  let seenFrom = null;

  function lay(at) {
    corners.write(at, all(corners.count), place);
    changed(plates);
  }

  function name(camera) {
    seenFrom = camera;
    const anchors = known.map((word, k) => {
      const middle = [1, 2, 3].reduce((sum, i) => sum.add(corner(k, i)), corner(k, 0)).divideScalar(4);
      const out = corner(k, 2).sub(corner(k, 0)).cross(corner(k, 3).sub(corner(k, 1)));
      const hidden = out.dot(camera.position.clone().sub(middle)) < 0;
      const { x, y } = middle.project(camera);
      return { name: word, hidden, x: ((x + 1) / 2) * canvas.clientWidth, y: ((1 - y) / 2) * canvas.clientHeight };
    }).filter((anchor) => !anchor.hidden);
    const near = pointer === null ? null : nearestOf(anchors, pointer);
    if (near) near.first = 1;
    write(known.length <= MOST_NAMES ? anchors : near ? [near] : []);
  }

  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect();
    pointer = [event.clientX - box.left, event.clientY - box.top];
    if (seenFrom) name(seenFrom);
  });
  canvas.addEventListener("pointerleave", () => { pointer = null; });
  return { lay, name };
}

function nearestOf(anchors, [x, y]) {
  const far = (at) => Math.hypot(at.x - x, at.y - y);
  const near = anchors.reduce((best, at) => (best === null || far(at) < far(best) ? at : best), null);
  return near && far(near) < NEAR_PX ? near : null;
}

// loops: circles of any colour in one cloud, a cloud for every other mark of the maps
function marksOf(count, dense, scene) {
  const clouds = new Map();
  const tint = new THREE.Color();
  function cloudOf(look) {
    const circles = (look.marker ?? "o") === "o";
    const key = circles ? "o" : `${look.marker} ${look.colour}`;
    if (!clouds.has(key)) {
      const shape = geometry(count, circles);
      const cloud = new THREE.Points(shape, nearer(new THREE.PointsMaterial({
        size: 13 * dense, sizeAttenuation: false, map: sheetOf(circles ? { colour: "#ffffff" } : look), alphaTest: 0.4, transparent: true, vertexColors: circles,
      }), 0.0018));
      cloud.frustumCulled = false;
      scene.add(cloud);
      clouds.set(key, { shape, circles, filled: 0 });
    }
    return clouds.get(key);
  }
  return (places, mark) => {
    for (const cloud of clouds.values()) cloud.filled = 0;
    for (let k = 0; k < count; k += 1) {
      const look = mark(k);
      if (!look) continue;
      const cloud = cloudOf(look);
      cloud.shape.attributes.position.array.set(places.subarray(3 * k, 3 * k + 3), 3 * cloud.filled);
      if (cloud.circles) tint.set(look.colour).toArray(cloud.shape.attributes.color.array, 3 * cloud.filled);
      cloud.filled += 1;
    }
    for (const { shape, filled } of clouds.values()) {
      shape.setDrawRange(0, filled);
      for (const attribute of Object.values(shape.attributes)) attribute.needsUpdate = true;
    }
  };
}

function sheetOf(look) {
  const sheet = document.createElement("canvas");
  sheet.width = sheet.height = 64;
  stamp(sheet.getContext("2d"), 32, 33, 22, look);
  return texture(sheet);
}

// the colours of a sheet are seen as they were painted
function texture(sheet) {
  return Object.assign(new THREE.CanvasTexture(sheet), { colorSpace: THREE.SRGBColorSpace });
}

function circle() {
  const sheet = document.createElement("canvas");
  sheet.width = sheet.height = 64;
  const pen = sheet.getContext("2d");
  pen.lineWidth = 6;
  pen.strokeStyle = "#1f6fb2";
  pen.arc(32, 32, 26, 0, 2 * Math.PI);
  pen.stroke();
  return texture(sheet);
}
