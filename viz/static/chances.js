// The probabilities of one or two ensembles over the motion: one slider, a map each, a loop's own curve with its band.
import { cursors, player, short } from "cursor";
import { flatMap, rampColour, spread, u8 } from "flatmap";
import { asks, chance, fixed, historyChart, tell } from "history";

const data = JSON.parse(document.getElementById("live-data").textContent);
const section = document.getElementById("live");
const el = (name) => section.querySelector(`[data-live="${name}"]`);
const every = (name) => [...section.querySelectorAll(`[data-live="${name}"]`)];
const follow = cursors();

const longest = data.designs.reduce((a, b) => (b.at.length > a.at.length ? b : a));
const state = { step: longest.at.length - 1, shown: "value", fabric: "none" };
const charts = every("chart");
const facts = every("facts");
const moved = "shape" in data.designs[0] ? await import("fabric") : null; // the drawing library, where a fabric moves

section.hidden = false;
const maps = data.designs.map((design, number) => {
  const stage = section.querySelector(`[data-design="${number}"]`);
  const flat = flatMap(stage.querySelector("canvas"), {
    low: design.flat.low, high: design.flat.high, lines: spread(design.flat, design.flat.segments), loops: design.drawn.map((spot) => spot.at),
  });
  const room = section.querySelector(`[data-solid="${number}"]`);
  const solid = moved && moved.turnable(room.querySelector("canvas"), design.shape, data.strain_ramp);
  for (const field of Object.values(design.fields ?? {})) field.values = u8(field.values);
  if (room) room.hidden = !solid;
  const item = { design, stage, room, flat, solid, chosen: -1 };
  for (const [picture, place] of solid ? [[solid, room], [flat, stage]] : [[flat, stage]]) {
    asks(picture.canvas, {
      nearest: (event) => picture.nearest(event, () => true),
      at: picture.at,
      tip: place.querySelector(".tip"),
      facts: (k) => known(design, design.loops[design.drawn[k].of]),
      choose: (k) => choose(number, k),
    });
  }
  for (const button of room?.querySelectorAll("[data-view]") ?? []) button.addEventListener("click", () => view(button.dataset.view));
  return item;
});
const solids = maps.map((item) => item.solid).filter(Boolean);
moved?.linked(solids);

// all fabrics are seen from the same side; the first one says how far away
function view(name) {
  solids[0].look(name);
  solids.slice(1).forEach((solid) => solid.adopt(solids[0]));
}

// the step of a design that is nearest to where the slider stands
function stepOf(design) {
  const wanted = longest.at[state.step];
  return design.at.reduce((best, at, k) => (Math.abs(at - wanted) < Math.abs(design.at[best] - wanted) ? k : best), 0);
}

function shown(curve, step) {
  return state.shown === "width" ? curve.high[step] - curve.low[step] : curve[state.shown][step];
}

const between = (p, low, high) => `${chance(p)} (${chance(low)} to ${chance(high)})`;
const along = (curve, step) => between(curve.value[step], curve.low[step], curve.high[step]);

function known(design, loop) {
  const step = stepOf(design);
  const end = design.at.length - 1;
  const half = loop.value.findIndex((p) => p >= 0.5);
  return [
    ["Wire, loop", `${loop.name}, ${loop.loop}`],
    ["Position", `warp ${fixed(loop.warp_mm, 1)}, weft ${fixed(loop.weft_mm, 1)} mm`],
    [`Broken at ${short(design.moved[step])} ${data.unit}`, along(loop, step)],
    ["Broken at the end", along(loop, end)],
    ["Interrupted at the end", between(...loop.open)],
    ["Half have broken", half < 0 ? "not reached" : `by ${short(design.moved[half])} ${data.unit}`],
    ["Greatest strain", `${fixed(loop.strain[0], 3)} mean, ${fixed(loop.strain[1], 3)} std`],
    ["Its wire at the end", along(design.wires[loop.wire], end)],
  ];
}

// the same loop in every map: the nearest one
function choose(number, k) {
  const [x, y] = maps[number].design.drawn[k].at;
  maps.forEach((item, other) => {
    const far = item.design.drawn.map((spot) => Math.hypot(spot.at[0] - x, spot.at[1] - y));
    item.chosen = other === number ? k : far.indexOf(Math.min(...far));
  });
  el("pick").value = String(maps[0].design.drawn[maps[0].chosen]?.of ?? -1);
  update();
}

// the largest value of a field in any of the designs: one ramp for all
const most = (name) => Math.max(...data.designs.map((design) => design.fields[name].most));

// share of the ramp of the cells at the nearest step of a fabric
function strainOf(design, place) {
  const field = design.fields[state.fabric];
  if (!field) return () => 0;
  const from = Math.round(place) * (field.values.length / design.shape.steps);
  const share = field.most / most(state.fabric) / 250;
  return (c) => field.values[from + c] * share;
}

function update() {
  const at = longest.at[state.step];
  maps.forEach((item, number) => {
    const { design, chosen } = item;
    const step = stepOf(design);
    const look = (curve) => rampColour(data.ramp, shown(curve, step));
    const lines = (wires) => (k) => look(design.wires[wires[k]]);
    const mark = (k) => ({ colour: look(design.loops[design.drawn[k].of]), marker: "o" });
    item.flat.draw({ line: lines(design.wire), mark, chosen, rim: "#8d949d" });
    item.solid?.show(design.places[step], { cell: strainOf(design, design.places[step]), line: lines(design.shape_wire), mark, chosen });
    if (chosen < 0) return;
    const loop = design.loops[design.drawn[chosen].of];
    tell(facts[number], [...(design.name ? [["Design", design.name]] : []), ...known(design, loop)]);
    charts[number].replaceChildren(historyChart({
      lines: [{ x: design.at, y: loop.value, low: loop.low, high: loop.high }],
      now: at,
      most: 1,
      digits: 1,
      span: [Math.min(0, longest.at[0]), longest.at.at(-1)],
      label: `Probability that wire ${loop.name}, loop ${loop.loop} has lost a filament, over the motion`,
      axis: `${design.name ? `${design.name}: ` : ""}P over the motion, ${data.unit}`,
    }));
  });
  const words = maps.map(({ design }) => {
    const step = stepOf(design);
    return `${design.name ? `${design.name}: ` : ""}some wire has lost a filament with probability ${along(design.some, step)}`;
  });
  const text = `At ${short(longest.moved[state.step])} ${data.unit}, ${words.join("; ")}`;
  el("moment").textContent = text;
  const label = { value: "Probability that a filament is broken", low: "Lower end of its 95 % interval", high: "Upper end of its 95 % interval", width: "Width of its 95 % interval" };
  el("label").textContent = label[state.shown];
  const field = solids.length ? data.designs[0].fields[state.fabric] : null;
  if (moved) el("fabric-legend").hidden = !field;
  if (field) {
    el("fabric-label").textContent = `${field.label}, ${field.unit}`;
    el("fabric-most").textContent = String(most(state.fabric));
  }
  follow(() => at);
  return text;
}

function fit() {
  for (const { stage, room, flat, solid, design } of maps) {
    const wide = stage.clientWidth;
    const tall = room ? Math.max(260, Math.min(430, 0.72 * room.clientWidth)) : 520;
    solid?.fit(room.clientWidth, tall);
    if (solid && maps.length === 1 && wide < 0.9 * room.clientWidth) { flat.fit(wide, tall); continue; }
    const ratio = (design.flat.high[1] - design.flat.low[1]) / (design.flat.high[0] - design.flat.low[0] || 1);
    flat.fit(wide, Math.max(150, Math.min(520, (wide - 28) * ratio + 46)));
  }
  update();
}

const steer = player(el("slider"), el("play"), (step) => {
  state.step = step;
  return update();
});
const first = maps[0].design;
const likeliest = first.loops.map((_, k) => k).sort((a, b) => first.loops[b].value.at(-1) - first.loops[a].value.at(-1) || (first.loops[b].strain[0] ?? 0) - (first.loops[a].strain[0] ?? 0));
for (const k of likeliest) el("pick").append(new Option(`wire ${first.loops[k].name}, loop ${first.loops[k].loop}: P ${chance(first.loops[k].value.at(-1))}`, String(k)));
el("pick").addEventListener("change", (event) => choose(0, first.drawn.findIndex((spot) => spot.of === Number(event.target.value))));
el("ramp").style.background = `linear-gradient(to right, ${data.ramp.join(",")})`;
el("slider").max = longest.at.length - 1;
el("shown").addEventListener("change", (event) => { state.shown = event.target.value; update(); });
if (moved) {
  el("pictures").classList.toggle("alone", !solids.length && maps.length === 1);
  el("fabric-box").hidden = !solids.length;
  el("fabric").append(new Option("cloth alone", "none"));
  for (const [name, field] of Object.entries(first.fields)) el("fabric").append(new Option(field.label, name));
  el("fabric-ramp").style.background = `linear-gradient(to right, ${data.strain_ramp.join(",")})`;
  el("fabric").addEventListener("change", (event) => { state.fabric = event.target.value; update(); });
}
window.addEventListener("resize", fit);
fit();
steer.go(state.step);
if (likeliest.length) choose(0, first.drawn.findIndex((spot) => spot.of === likeliest[0]));
else for (const name of ["pick", "history"]) el(name).hidden = true;
if (solids.length) view("reset");
section.dataset.ready = "true";
window.etextile = { state, data, maps, choose, steer };
