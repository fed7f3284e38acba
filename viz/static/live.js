// The fabric of a report that can be turned, played and asked. Reads the arrays of viz/live.py from the page itself.
import { cursors, player } from "cursor";
import { turnable } from "fabric";
import { flatMap, rampColour, spread, u8 } from "flatmap";
import { asks, chance, fixed, historyChart, tell } from "history";

const data = JSON.parse(document.getElementById("live-data").textContent);
const section = document.getElementById("live");
const canvas = section.querySelector("canvas");
const el = (name) => section.querySelector(`[data-live="${name}"]`);

const steps = data.at.length;
for (const field of Object.values(data.fields)) field.values = u8(field.values);
const wireStrain = u8(data.wires.strain);
const solid = turnable(canvas, data.shape, data.ramp); // without WebGL the undeformed map is left
const state = { step: steps - 1, field: Object.keys(data.fields)[0], chosen: -1 };
if (solid || data.loops.length) start();

// loops of these states in this wire or net are shown
function shown(k) {
  const loop = data.loops[k];
  return el("filter").querySelector(`input[value="${loop.states[state.step]}"]`).checked && named(loop.wire);
}

function named(wire) {
  const word = el("search").value.trim().toLowerCase();
  if (!word) return true;
  const nets = Object.entries(data.wires.nets).filter(([, wires]) => wires.includes(wire)).map(([name]) => name.toLowerCase());
  const name = (data.wires.names[wire] ?? String(wire)).toLowerCase();
  return name === word || (Number.isNaN(Number(word)) && (name.includes(word) || nets.some((net) => net.includes(word))));
}

// share of the ramp that a cell of the fabric has
function cellLook(c) {
  const field = data.fields[state.field];
  return field ? field.values[(state.step * field.values.length) / steps + c] / 250 : 0;
}

// colour of a wire's segment, the same in both pictures
function wireLook(k) {
  const wire = data.wires.wire[k];
  if (!named(wire)) return "#e4e7ea";
  if (state.field === "probability") return rampColour(data.probability_ramp, data.wires.broken[wire] ?? 0);
  if (state.field === "wire_strain") return rampColour(data.ramp, wireStrain[(state.step * wireStrain.length) / steps + k] / 250);
  return data.wires.colour[data.wires.state[state.step][wire] ?? 0];
}

function loopLook(k) {
  if (!shown(k)) return null;
  const loop = data.loops[k];
  if (state.field === "probability") return { colour: rampColour(data.probability_ramp, loop.broken), marker: "o" };
  const look = data.states[loop.states[state.step]];
  return { colour: look.colour, marker: look.marker, edge: look.marker === "X" ? "#ffffff" : "#1a1a1a" };
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

function start() {
  section.hidden = false;
  for (const said of document.querySelectorAll(".ringed")) said.hidden = false; // without this program there is no ring
  const flat = flatMap(el("flat"), {
    low: data.flat.low,
    high: data.flat.high,
    lines: spread(data.flat, data.flat.segments),
    loops: data.loops.map((loop) => loop.flat),
    parts: data.shape.parts?.names.map((name, k) => ({ name, corners: data.shape.parts.flat[k] })),
  });
  const follow = cursors();
  const steer = player(el("slider"), el("play"), (step) => {
    state.step = step;
    update();
    return data.moment[step];
  });

  function update() {
    const s = state.step;
    const looks = { cell: cellLook, line: wireLook, mark: loopLook, chosen: state.chosen };
    solid?.show(s, looks);
    flat.draw({ ...looks, cell: null });
    el("moment").textContent = data.moment[s];
    const counts = data.states.map((look, i) => `${i > 3 ? look.label : look.name} ${data.loops.filter((loop) => loop.states[s] === i).length}`);
    el("counts").textContent = `Loops: ${counts.join(", ")}.`;
    legend();
    history();
    follow((unit) => data.follow[unit]?.[s]);
  }

  function choose(k) {
    state.chosen = k;
    el("pick").value = String(k);
    update();
  }

  function fit() {
    const width = canvas.parentElement.clientWidth;
    const height = Math.max(260, Math.min(470, width * 0.72));
    solid?.fit(width, height);
    const beside = el("flat").parentElement.clientWidth;
    const tall = ((beside - 28) * (data.flat.high[1] - data.flat.low[1])) / (data.flat.high[0] - data.flat.low[0] || 1) + 46;
    flat.fit(beside, solid && beside < 0.9 * width ? height : Math.max(150, Math.min(solid ? height : 470, tall)));
  }

  const worst = data.loops.map((_, k) => k).sort((a, b) => (data.loops[b].broken - data.loops[a].broken) || (data.loops[b].max_strain - data.loops[a].max_strain));
  for (const k of worst) {
    const loop = data.loops[k];
    el("pick").append(new Option(`wire ${loop.name}, loop ${loop.loop}: ${loop.state}, P ${chance(loop.broken)}`, String(k)));
  }
  if (solid) for (const [name, field] of Object.entries(data.fields)) el("field").append(new Option(field.label, name));
  else state.field = "none";
  if (data.wires.wire.length) el("field").append(new Option("Wire strain", "wire_strain"));
  if (data.loops.length) el("field").append(new Option("Probability", "probability"));
  el("field").append(new Option(solid ? "Cloth alone" : "State", "none"));
  el("field").value = state.field;
  el("slider").max = steps - 1;
  const first = data.first;
  el("first").hidden = !first;
  if (first) {
    el("first").textContent = first.breaks ? "First break" : "Likeliest to break";
    el("first").addEventListener("click", () => {
      if (first.step !== null) steer.go(first.step);
      choose(first.number);
    });
  }
  for (const view of ["reset", "top", "side"]) el(view).addEventListener("click", () => solid.look(view));
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
  for (const picture of solid ? [solid, flat] : [flat]) {
    asks(picture.canvas, { nearest: (event) => picture.nearest(event, shown), at: picture.at, tip: el("tip"), facts: (k) => facts(data.loops[k]), choose });
  }
  window.addEventListener("resize", () => { fit(); update(); });
  if (!data.loops.length) for (const name of ["flat-box", "filter", "search-box", "pick-box", "counts"]) el(name).hidden = true;
  canvas.parentElement.hidden = !solid;
  if (!solid) el("flat-box").append(el("legend"));
  el("legend").classList.toggle("still", !solid);
  el("pictures").classList.toggle("alone", !data.loops.length || !solid);
  state.chosen = first ? first.number : -1; // the page opens with the history of the loop that matters most
  el("pick").value = String(state.chosen);
  fit();
  steer.go(steps - 1);
  solid?.look("reset");
  section.dataset.ready = "true";
  window.etextile = { state, data, solid, flat, update };
}
