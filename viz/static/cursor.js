// The slider of a page with its play button, and the charts that follow it: a cursor where it stands, and under the chart
// what the curves say there.

const WHOLE_S = 3; // seconds that playing from end to end takes
const SHORTEST_MS = 80;

// show(value) draws what the slider stands at and returns it in words
export function player(slider, button, show) {
  let timer = null;
  const last = () => Number(slider.max);
  const stride = () => Number(slider.step) * Math.max(1, Math.round(((last() - Number(slider.min)) / Number(slider.step)) * (SHORTEST_MS / 1000 / WHOLE_S)));

  function go(value) {
    slider.value = value;
    slider.setAttribute("aria-valuetext", show(Number(slider.value)));
  }

  function turn(on) {
    clearInterval(timer);
    timer = null;
    button.textContent = on ? "Pause" : "Play";
    button.setAttribute("aria-pressed", String(on));
    if (!on) return;
    if (Number(slider.value) >= last()) go(slider.min);
    const steps = (last() - Number(slider.min)) / stride();
    timer = setInterval(() => {
      go(Math.min(Number(slider.value) + stride(), last()));
      if (Number(slider.value) >= last()) turn(false);
    }, Math.max(SHORTEST_MS, (1000 * WHOLE_S) / steps));
  }

  slider.addEventListener("input", () => go(slider.value));
  button.addEventListener("click", () => turn(timer === null));
  return { go, stop: () => turn(false), get value() { return Number(slider.value); } };
}

// the charts follow at(unit): where the slider stands in the unit of a chart
export function cursors(root = document) {
  const charts = [...root.querySelectorAll("[data-track]")].map(prepare);
  return (at) => charts.forEach((chart) => move(chart, at(chart.track.unit)));
}

function prepare(plot) {
  const track = JSON.parse(plot.dataset.track);
  const line = document.createElement("i");
  line.className = "cursor";
  plot.append(line);
  const said = document.createElement("p");
  said.className = "said";
  plot.after(said);
  return { track, line, said };
}

function move(chart, at) {
  const { frame: [left, top, wide, high], span: [from, to], unit, lines } = chart.track;
  const share = (at - from) / (to - from || 1);
  chart.line.hidden = !(share > -0.001 && share < 1.001);
  chart.said.textContent = "";
  if (chart.line.hidden) return;
  chart.line.style.cssText = `left:${100 * (left + share * wide)}%;top:${100 * top}%;height:${100 * high}%`;
  const read = lines.map((line) => [line.label, valueAt(line, at)]).filter(([, value]) => value !== null);
  chart.said.textContent = read.length ? `At ${short(at)} ${unit}: ${read.map(([label, value]) => `${label} ${short(value)}`).join(", ")}` : "";
}

export function short(value) {
  return String(Number(value.toPrecision(3)));
}

// a curve at a place, in straight lines between its points; null beyond its ends and in gaps
export function valueAt({ x, y }, at) {
  for (let i = 1; i < x.length; i += 1) {
    const [a, b] = [x[i - 1], x[i]];
    if ((at - a) * (at - b) > 0 || y[i - 1] === null || y[i] === null) continue;
    return a === b ? y[i] : y[i - 1] + ((y[i] - y[i - 1]) * (at - a)) / (b - a);
  }
  return x.length && Math.abs(at - x[0]) < 1e-9 ? y[0] : null;
}
