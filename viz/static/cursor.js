// Charts of a page follow its slider: a cursor where it stands, and under the chart what the curves say there.

export function cursors(root = document) {
  const charts = [...root.querySelectorAll("[data-track]")].map(prepare);
  return (at) => charts.forEach((chart) => move(chart, at));
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
  chart.line.hidden = share < -0.001 || share > 1.001;
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
