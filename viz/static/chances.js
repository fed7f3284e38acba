// The probabilities of one or two ensembles over the motion: one slider, a map each, a loop's own curve with its band.
import { cursors, short } from "cursor";
import { flatMap, rampColour } from "flatmap";
import { chance, fixed, historyChart, tell } from "history";

const data = JSON.parse(document.getElementById("live-data").textContent);
const section = document.getElementById("live");
const el = (name) => section.querySelector(`[data-live="${name}"]`);
const every = (name) => [...section.querySelectorAll(`[data-live="${name}"]`)];
const follow = cursors();

const longest = data.designs.reduce((a, b) => (b.at.length > a.at.length ? b : a));
const state = { step: longest.at.length - 1, shown: "value", playing: null };
const charts = every("chart");
const facts = every("facts");

const u16 = (text) => new Uint16Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
const maps = data.designs.map((design, number) => {
  const stage = section.querySelector(`[data-design="${number}"]`);
  const canvas = stage.querySelector("canvas");
  const lines = Float32Array.from(u16(design.flat.segments), (value, i) => design.flat.low[i % 2] + design.flat.scale * value);
  const flat = flatMap(canvas, { low: design.flat.low, high: design.flat.high, lines, loops: design.drawn.map((spot) => spot.at) });
  const item = { design, stage, canvas, flat, chosen: -1 };
  let pressed = null;
  canvas.addEventListener("pointermove", (event) => hover(item, event));
  canvas.addEventListener("pointerleave", () => { stage.querySelector(".tip").hidden = true; });
  canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
  canvas.addEventListener("pointerup", (event) => {
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 6) return;
    const k = flat.nearest(event, () => true);
    if (k >= 0) choose(number, k);
  });
  return item;
});

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

function hover(item, event) {
  const k = item.flat.nearest(event, () => true);
  const tip = item.stage.querySelector(".tip");
  tip.hidden = k < 0;
  item.canvas.style.cursor = k < 0 ? "default" : "pointer";
  if (k < 0) return;
  tell(tip, known(item.design, item.design.loops[item.design.drawn[k].of]));
  const [x, y] = item.flat.at(k);
  tip.style.left = `${Math.max(4, Math.min(x + 14, item.canvas.clientWidth - 290))}px`;
  tip.style.top = `${Math.max(0, Math.min(y + 12, item.canvas.clientHeight - 165))}px`;
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

function update() {
  const at = longest.at[state.step];
  maps.forEach((item, number) => {
    const { design, chosen } = item;
    const step = stepOf(design);
    const look = (curve) => rampColour(data.ramp, shown(curve, step));
    item.flat.draw({
      line: (k) => look(design.wires[design.wire[k]]),
      mark: (k) => ({ colour: look(design.loops[design.drawn[k].of]), marker: "o" }),
      chosen,
      rim: "#8d949d",
    });
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
  el("slider").value = state.step;
  el("slider").setAttribute("aria-valuetext", text);
  const label = { value: "Probability that a filament is broken", low: "Lower end of its 95 % interval", high: "Upper end of its 95 % interval", width: "Width of its 95 % interval" };
  el("label").textContent = label[state.shown];
  follow(at);
}

function fit() {
  for (const { stage, flat, design } of maps) {
    const wide = stage.clientWidth;
    const ratio = (design.flat.high[1] - design.flat.low[1]) / (design.flat.high[0] - design.flat.low[0] || 1);
    flat.fit(wide, Math.max(150, Math.min(520, (wide - 28) * ratio + 46)));
  }
  update();
}

function stop() {
  clearInterval(state.playing);
  state.playing = null;
  el("play").textContent = "Play";
  el("play").setAttribute("aria-pressed", "false");
}

function play() {
  if (state.playing) { stop(); return; }
  if (state.step === longest.at.length - 1) state.step = 0;
  el("play").textContent = "Pause";
  el("play").setAttribute("aria-pressed", "true");
  state.playing = setInterval(() => {
    if (state.step >= longest.at.length - 1) { stop(); return; }
    state.step += 1;
    update();
  }, Math.max(80, 3000 / longest.at.length));
  update();
}

section.hidden = false;
const first = maps[0].design;
const likeliest = first.loops.map((_, k) => k).sort((a, b) => first.loops[b].value.at(-1) - first.loops[a].value.at(-1) || (first.loops[b].strain[0] ?? 0) - (first.loops[a].strain[0] ?? 0));
for (const k of likeliest) el("pick").append(new Option(`wire ${first.loops[k].name}, loop ${first.loops[k].loop}: P ${chance(first.loops[k].value.at(-1))}`, String(k)));
el("pick").addEventListener("change", (event) => choose(0, first.drawn.findIndex((spot) => spot.of === Number(event.target.value))));
el("ramp").style.background = `linear-gradient(to right, ${data.ramp.join(",")})`;
el("slider").max = longest.at.length - 1;
el("slider").addEventListener("input", (event) => { state.step = Number(event.target.value); update(); });
el("shown").addEventListener("change", (event) => { state.shown = event.target.value; update(); });
el("play").addEventListener("click", play);
window.addEventListener("resize", fit);
fit();
if (likeliest.length) choose(0, first.drawn.findIndex((spot) => spot.of === likeliest[0]));
else for (const name of ["pick", "history"]) el(name).hidden = true;
section.dataset.ready = "true";
window.etextile = { state, data, maps, choose };
