// Names beside what they name: none lies on another one or on a place that is named; what finds no room is left out.

const FONT = "11px system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif";
const HIGH = 14;
const FREE_PX = 5; // around a place that is named
const AWAY_PX = [15, 29, 43, 57, 75, 95];
const ASIDE_PX = [0, -18, 18, -40, 40, -64, 64];
const NS = "http://www.w3.org/2000/svg";
const pen = document.createElement("canvas").getContext("2d");

// anchors: [{x, y, name, up}], px; up: 1 where the name shall stand above, -1 below. Returns for each {x, y} of its middle, or null
export function placed(anchors, { width, height }) {
  pen.font = FONT;
  const taken = [];
  const found = anchors.map(() => null);
  const order = anchors.map((_, k) => k).sort((a, b) => (anchors[b].first ?? 0) - (anchors[a].first ?? 0) || anchors[a].x - anchors[b].x);
  for (const k of order) {
    const { x, y, name, up = 1 } = anchors[k];
    const half = pen.measureText(name).width / 2 + 3;
    for (const [dx, dy] of places(up)) {
      const box = { left: x + dx - half, right: x + dx + half, top: y + dy - HIGH / 2, bottom: y + dy + HIGH / 2 };
      if (box.left < 0 || box.right > width || box.top < 0 || box.bottom > height) continue;
      if (taken.some((other) => crosses(box, other)) || anchors.some((at) => holds(box, at))) continue;
      taken.push(box);
      found[k] = { x: x + dx, y: y + dy };
      break;
    }
  }
  return found;
}

function* places(up) {
  for (const away of AWAY_PX) for (const side of [-up, up]) for (const aside of ASIDE_PX) if (Math.abs(aside) <= away) yield [aside, side * away];
}

const crosses = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
const holds = (box, { x, y }) => x > box.left - FREE_PX && x < box.right + FREE_PX && y > box.top - FREE_PX && y < box.bottom + FREE_PX;

// names over a picture, each with a line to what it names; show(anchors) puts them anew
export function names(canvas) {
  const sheet = document.createElementNS(NS, "svg");
  sheet.setAttribute("class", "names");
  sheet.setAttribute("aria-hidden", "true");
  canvas.after(sheet);
  return (anchors) => {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    sheet.setAttribute("viewBox", `0 0 ${width} ${height}`);
    sheet.replaceChildren(...placed(anchors, { width, height }).flatMap((at, k) => (at ? [leader(anchors[k], at), word(anchors[k], at)] : [])));
  };
}

function leader(from, to) {
  const line = document.createElementNS(NS, "path");
  line.setAttribute("d", `M${from.x.toFixed(1)},${from.y.toFixed(1)}L${to.x.toFixed(1)},${(to.y + Math.sign(from.y - to.y) * (HIGH / 2 - 1)).toFixed(1)}`);
  return line;
}

function word({ name }, { x, y }) {
  const text = document.createElementNS(NS, "text");
  text.setAttribute("x", x.toFixed(1));
  text.setAttribute("y", (y + 4).toFixed(1));
  text.textContent = name;
  return text;
}

// the same on a flat picture that is painted
export function paintNames(pencil, anchors, room) {
  pencil.font = FONT;
  pencil.textAlign = "center";
  pencil.textBaseline = "middle";
  pencil.lineWidth = 0.8;
  placed(anchors, room).forEach((at, k) => {
    if (!at) return;
    pencil.beginPath();
    pencil.moveTo(anchors[k].x, anchors[k].y);
    pencil.lineTo(at.x, at.y + Math.sign(anchors[k].y - at.y) * (HIGH / 2 - 1));
    pencil.stroke();
    pencil.fillText(anchors[k].name, at.x, at.y);
  });
  pencil.textAlign = "start";
}
