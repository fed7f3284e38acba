// The undeformed specimen on a plane: wires as lines, loops as marks, found again under a pointer.
import { paintNames } from "names";

const buffer = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
export const u8 = (text) => new Uint8Array(buffer(text));
export const u16 = (text) => new Uint16Array(buffer(text));
export const u32 = (text) => new Uint32Array(buffer(text));

// places on the specimen, mm: x y x y ... of arrays that viz/live.py packed
export const spread = ({ low, scale }, text) => Float32Array.from(u16(text), (value, i) => low[i % 2] + scale * value);

// shape: {low, high (mm), lines: Float32Array of x0 y0 x1 y1, loops: [[x, y], ...], cells: Float32Array of four corners}
export function flatMap(canvas, shape) {
  const pen = canvas.getContext("2d");
  let view = { scale: 1, left: 0, top: 0 };
  const seen = (x, y) => [view.left + view.scale * (x - shape.low[0]), view.top + view.scale * (shape.high[1] - y)];

  function fit(width, height) {
    const dense = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.round(width * dense);
    canvas.height = Math.round(height * dense);
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    const [wide, high] = [shape.high[0] - shape.low[0] || 1, shape.high[1] - shape.low[1] || 1];
    const scale = Math.min((width - 28) / wide, (height - 46) / high);
    view = { scale, left: (width - scale * wide) / 2, top: (height - 18 - scale * high) / 2, width, height, wide, high };
  }

  // line(k) -> colour; mark(k) -> {colour, marker, edge, faint} or null; chosen: number of the loop with a ring
  // rim: colour around the lines, for ramps that begin as light as the cloth; cell(k) -> colour
  function draw({ line, mark, chosen = -1, rim = null, cell = null }) {
    pen.clearRect(0, 0, view.width, view.height);
    pen.fillStyle = "#fbfaf7";
    pen.strokeStyle = "#6b7280";
    pen.lineWidth = 1;
    pen.beginPath();
    pen.rect(view.left - 4, view.top - 4, view.scale * view.wide + 8, view.scale * view.high + 8);
    pen.fill();
    pen.stroke();
    for (let k = 0; cell && k < shape.cells.length / 8; k += 1) {
      pen.fillStyle = pen.strokeStyle = cell(k); // the stroke closes the seams between cells
      pen.lineWidth = 0.6;
      pen.beginPath();
      for (let i = 0; i < 8; i += 2) pen.lineTo(...seen(shape.cells[8 * k + i], shape.cells[8 * k + i + 1]));
      pen.closePath();
      pen.fill();
      pen.stroke();
    }
    for (const [width, colour] of rim ? [[3.4, () => rim], [2, line]] : [[1.6, line]]) {
      pen.lineWidth = width;
      for (let k = 0; k < shape.lines.length / 4; k += 1) {
        pen.strokeStyle = colour(k);
        pen.beginPath();
        pen.moveTo(...seen(shape.lines[4 * k], shape.lines[4 * k + 1]));
        pen.lineTo(...seen(shape.lines[4 * k + 2], shape.lines[4 * k + 3]));
        pen.stroke();
      }
    }
    const size = Math.max(1.6, Math.min(4.5, (0.42 * Math.sqrt((view.scale ** 2 * view.wide * view.high) / Math.max(shape.loops.length, 1)))));
    shape.loops.forEach((at, k) => {
      const look = mark(k);
      if (look) stamp(pen, ...seen(...at), size, look);
    });
    if (chosen >= 0 && shape.loops[chosen]) {
      pen.strokeStyle = "#1f6fb2";
      pen.lineWidth = 2.5;
      pen.beginPath();
      pen.arc(...seen(...shape.loops[chosen]), size + 5, 0, 2 * Math.PI);
      pen.stroke();
    }
    parts();
    ruler();
  }

  function parts() {
    const known = shape.parts ?? [];
    if (!known.length) return;
    const heights = known.flatMap(({ corners }) => corners.map((at) => at[1]));
    const middle = (Math.min(...heights) + Math.max(...heights)) / 2;
    pen.strokeStyle = pen.fillStyle = "#1a1a1a";
    const anchors = known.map(({ name, corners }) => {
      pen.lineWidth = 1.2;
      pen.beginPath();
      for (const at of corners) pen.lineTo(...seen(...at));
      pen.closePath();
      pen.stroke();
      const own = corners.map((at) => at[1]);
      const above = own.reduce((a, b) => a + b) / own.length >= middle;
      const [x, y] = seen(corners.reduce((sum, at) => sum + at[0], 0) / corners.length, above ? Math.max(...own) : Math.min(...own));
      return { x, y, name, up: above ? 1 : -1 };
    });
    paintNames(pen, anchors, view);
  }

  function ruler() {
    const wanted = view.wide / 4;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const length = power * (wanted / power >= 5 ? 5 : wanted / power >= 2 ? 2 : 1);
    const [x, y] = [view.left, view.top + view.scale * view.high + 14];
    pen.strokeStyle = pen.fillStyle = "#1f2328";
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + view.scale * length, y);
    pen.stroke();
    pen.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    pen.textBaseline = "middle";
    pen.fillText(`${length} mm`, x + view.scale * length + 6, y);
  }

  function nearest(event, shown) {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let [best, near] = [-1, 14];
    shape.loops.forEach((at, k) => {
      if (!shown(k)) return;
      const [u, v] = seen(...at);
      const far = Math.hypot(u - x, v - y);
      if (far < near) { near = far; best = k; }
    });
    return best;
  }

  return { canvas, fit, draw, nearest, at: (k) => seen(...shape.loops[k]) };
}

// a mark as in the still maps: circle, square, triangle, cross; a diamond for what is undetermined
export function stamp(pen, x, y, r, { colour, marker = "o", edge = "#1a1a1a" }) {
  pen.fillStyle = colour;
  pen.strokeStyle = edge;
  pen.lineWidth = Math.max(0.7, 0.22 * r);
  pen.beginPath();
  if (marker === "o") pen.arc(x, y, r, 0, 2 * Math.PI);
  else if (marker === "s") pen.rect(x - 0.92 * r, y - 0.92 * r, 1.84 * r, 1.84 * r);
  else if (marker === "D") { pen.moveTo(x, y - 1.2 * r); pen.lineTo(x + 1.2 * r, y); pen.lineTo(x, y + 1.2 * r); pen.lineTo(x - 1.2 * r, y); pen.closePath(); }
  else if (marker === "^") { pen.moveTo(x, y - 1.25 * r); pen.lineTo(x + 1.3 * r, y + 1.05 * r); pen.lineTo(x - 1.3 * r, y + 1.05 * r); pen.closePath(); }
  else {
    const arm = [[-0.6, -1.2], [0, -0.6], [0.6, -1.2], [1.2, -0.6], [0.6, 0], [1.2, 0.6], [0.6, 1.2], [0, 0.6], [-0.6, 1.2], [-1.2, 0.6], [-0.6, 0], [-1.2, -0.6]];
    arm.forEach(([u, v], i) => (i ? pen.lineTo(x + r * u, y + r * v) : pen.moveTo(x + r * u, y + r * v)));
    pen.closePath();
  }
  pen.fill();
  pen.stroke();
}

export function rampColour(ramp, share) {
  const at = Math.min(Math.max(share, 0), 1) * (ramp.length - 1);
  const low = Math.min(Math.floor(at), ramp.length - 2);
  const part = (text, i) => parseInt(text.slice(1 + 2 * i, 3 + 2 * i), 16);
  const mix = [0, 1, 2].map((i) => Math.round(part(ramp[low], i) + (at - low) * (part(ramp[low + 1], i) - part(ramp[low], i))));
  return `rgb(${mix.join(",")})`;
}
