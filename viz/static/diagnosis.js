// The slider of a diagnosis: a cursor on every chart, the fields of both runs; and why each candidate is not the answer.
import { cursors, player, short } from "cursor";
import { flatMap, rampColour, spread, u8 } from "flatmap";
import { asks, chance, fixed, tell } from "history";

const steer = document.getElementById("steer");
const slider = steer?.querySelector("input");
const unit = steer?.dataset.unit;
const follow = cursors();
const redraw = [];

function show(at) {
  steer.querySelector("output").textContent = `${short(at)} ${unit}`;
  follow(() => at);
  redraw.forEach((draw) => draw(at));
  return `${short(at)} ${unit}`;
}

// candidates: what speaks against one stands below as long as it is pointed at, touched or in focus
function candidates(box) {
  const rows = [...box.querySelectorAll("button")];
  const said = box.querySelector("dl");
  const tellOf = (row) => {
    rows.forEach((item) => item.setAttribute("aria-pressed", String(item === row)));
    tell(said, JSON.parse(row.dataset.facts));
  };
  for (const row of rows) for (const event of ["pointerenter", "focus", "click"]) row.addEventListener(event, () => tellOf(row));
  box.hidden = false;
  if (rows.length) tellOf(rows[0]);
}

function fields(box) {
  const data = JSON.parse(document.getElementById("fields-data").textContent);
  const kind = box.querySelector("select");
  for (const run of data.runs) for (const field of Object.values(run.fields)) field.values = u8(field.values);
  for (const [name, field] of Object.entries(data.runs[0].fields)) kind.append(new Option(field.label, name));
  const most = (name) => Math.max(...data.runs.map((run) => run.fields[name].most));
  const maps = data.runs.map((run, number) => {
    const stage = box.querySelector(`[data-run="${number}"]`);
    const canvas = stage.querySelector("canvas");
    const flat = flatMap(canvas, {
      low: run.flat.low, high: run.flat.high, lines: spread(run.flat, run.flat.segments), cells: spread(run.flat, run.cells), loops: run.loops.map((loop) => loop.flat),
    });
    return { run, stage, canvas, flat, step: run.at.length - 1 };
  });

  function draw(at) {
    const name = kind.value;
    for (const item of maps) {
      const { run, flat } = item;
      item.step = run.at.reduce((best, place, k) => (Math.abs(place - at) < Math.abs(run.at[best] - at) ? k : best), 0);
      const field = run.fields[name];
      const count = field.values.length / run.at.length;
      const share = field.most / most(name) / 250;
      flat.draw({
        cell: (k) => rampColour(data.ramp, field.values[item.step * count + k] * share),
        line: (k) => data.wire_colour[run.wire_states[item.step][run.wire[k]] ?? 0],
        mark: (k) => {
          const look = data.states[run.loops[k].states[item.step]];
          return { colour: look.colour, marker: look.marker, edge: look.marker === "X" ? "#ffffff" : "#1a1a1a" };
        },
      });
      const end = at > run.at.at(-1) * 1.0001 ? `; the run ends at ${short(run.at.at(-1))} ${unit}` : "";
      item.stage.querySelector(".design").textContent = `${run.name}, ${short(run.at[item.step])} ${unit}${end}`;
    }
    box.querySelector("[data-live=label]").textContent = `${data.runs[0].fields[name].label}, ${data.runs[0].fields[name].unit}`;
    box.querySelector("[data-live=most]").textContent = String(most(name));
  }

  function known(item, loop) {
    return [
      ["Wire, loop", `${loop.name}, ${loop.loop}`], ["Position", `warp ${fixed(loop.warp_mm, 1)}, weft ${fixed(loop.weft_mm, 1)} mm`],
      ["Strain here", fixed(loop.strain[item.step], 4)], ["State here", data.states[loop.states[item.step]].name], ["State at the end", loop.state],
      ["First filament breaks", loop.fails_at === null ? "-" : `${fixed(loop.fails_at, 1)} ${unit}`], ["P, a filament breaks", chance(loop.broken)],
    ];
  }

  function fit() {
    for (const { stage, flat, run } of maps) {
      const wide = stage.clientWidth;
      const ratio = (run.flat.high[1] - run.flat.low[1]) / (run.flat.high[0] - run.flat.low[0] || 1);
      flat.fit(wide, Math.max(150, Math.min(520, (wide - 28) * ratio + 46)));
    }
    draw(Number(slider.value));
  }

  for (const item of maps) {
    asks(item.canvas, { nearest: (event) => item.flat.nearest(event, () => true), at: item.flat.at, tip: item.stage.querySelector(".tip"), facts: (k) => known(item, item.run.loops[k]) });
  }
  box.querySelector("[data-live=ramp]").style.background = `linear-gradient(to right, ${data.ramp.join(",")})`;
  kind.addEventListener("change", () => draw(Number(slider.value)));
  window.addEventListener("resize", fit);
  box.hidden = false;
  redraw.push(draw);
  fit();
  window.etextile = { maps };
}

const [evidence, moving] = ["evidence", "fields"].map((name) => document.getElementById(name));
if (evidence) candidates(evidence);
if (steer) {
  const run = player(slider, steer.querySelector("button"), show);
  steer.hidden = false;
  if (moving) fields(moving);
  run.go(slider.value);
}
document.body.dataset.ready = "true";
