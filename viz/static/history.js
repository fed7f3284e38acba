// One quantity of one loop over the motion: curves with bands, a level that matters, and where the slider stands.

const NS = "http://www.w3.org/2000/svg";
const [WIDE, HIGH, LEFT, LOW] = [360, 190, 46, 30];

// lines: [{x, y, low, high, name}]; onset: {at, label}; most: top of the axis; digits: of its labels
export function historyChart({ lines, now, onset = null, most, digits = 3, label, axis, span = null }) {
  const every = lines.flatMap((line) => line.x);
  const [from, to] = span ?? [Math.min(0, ...every), Math.max(...every)];
  const top = 1.08 * most;
  const x = (value) => LEFT + ((WIDE - LEFT - 10) * (value - from)) / (to - from || 1);
  const y = (value) => HIGH - LOW - ((HIGH - LOW - 10) * value) / top;
  const path = (xs, ys) => ys.map((value, i) => `${i ? "L" : "M"}${x(xs[i]).toFixed(1)},${y(value).toFixed(1)}`).join("");
  const svg = document.createElementNS(NS, "svg");
  svg.setAttribute("viewBox", `0 0 ${WIDE} ${HIGH}`);
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", label);
  const add = (name, attributes, text) => {
    const item = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) item.setAttribute(key, value);
    if (text !== undefined) item.textContent = text;
    svg.append(item);
  };
  for (const { x: xs, low, high } of lines) {
    if (low) add("path", { d: `${path(xs, high)}${path([...xs].reverse(), [...low].reverse()).replace("M", "L")}Z`, class: "band" });
  }
  add("path", { d: `M${LEFT},10V${HIGH - LOW}H${WIDE - 10}`, class: "axis" });
  for (const part of [0, 0.5, 1]) {
    const along = from + part * (to - from);
    add("text", { x: LEFT - 5, y: y(part * most) + 4, "text-anchor": "end" }, (part * most).toFixed(digits));
    add("text", { x: x(along), y: HIGH - LOW + 14, "text-anchor": part === 1 ? "end" : "middle" }, String(Math.round(along * 10) / 10));
  }
  add("text", { x: (LEFT + WIDE) / 2, y: HIGH - 3, "text-anchor": "middle" }, axis);
  if (onset) {
    add("path", { d: `M${LEFT},${y(onset.at)}H${WIDE - 10}`, class: "onset" });
    add("text", { x: LEFT + 6, y: y(onset.at) - 4 }, onset.label);
  }
  add("path", { d: `M${x(now)},10V${HIGH - LOW}`, class: "now" });
  lines.forEach((line, i) => {
    add("path", { d: path(line.x, line.y), class: i ? "curve other" : "curve" });
    const step = line.x.reduce((best, at, k) => (Math.abs(at - now) < Math.abs(line.x[best] - now) ? k : best), 0);
    add("circle", { cx: x(line.x[step]), cy: y(line.y[step]), r: 4, class: "point" });
    if (line.name) add("text", { x: x(line.x.at(-1)) - 4, y: Math.max(y(line.y.at(-1)) - 5, 10), "text-anchor": "end" }, line.name);
  });
  return svg;
}

// what is known of a loop as a list of names and values; what is asked of other people's files stays text
export function tell(target, facts) {
  target.replaceChildren(...facts.flatMap(([name, value]) => {
    const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
    dt.textContent = name;
    dd.textContent = value;
    return [dt, dd];
  }));
}

// a loop that is pointed at says its numbers beside it; one that is clicked or touched is chosen
export function asks(canvas, { nearest, at, tip, facts, choose = () => {} }) {
  let pressed = null;
  canvas.addEventListener("pointermove", hover);
  canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; hover(event); });
  canvas.addEventListener("pointerleave", () => { tip.hidden = true; });
  canvas.addEventListener("pointerup", (event) => {
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 6) return;
    const k = nearest(event);
    if (k >= 0) choose(k);
  });
  function hover(event) {
    const k = nearest(event);
    canvas.style.cursor = k >= 0 ? "pointer" : canvas.tabIndex >= 0 ? "grab" : "default";
    tip.hidden = k < 0;
    if (k < 0) return;
    canvas.parentElement.append(tip);
    tell(tip, facts(k));
    const [x, y] = at(k);
    tip.style.left = `${Math.max(4, Math.min(x + 14, canvas.clientWidth - tip.offsetWidth - 6))}px`;
    tip.style.top = `${Math.max(4, Math.min(y + 12, canvas.clientHeight - tip.offsetHeight - 6))}px`;
  }
}

export const fixed = (value, digits) => (value === null || value === undefined ? "-" : value.toFixed(digits));

// a probability as in tables: no certainty is claimed
export const chance = (p) => (p === null || p === undefined ? "-" : p < 0.0005 ? "<0.001" : p > 0.9995 ? ">0.999" : p.toFixed(3));
