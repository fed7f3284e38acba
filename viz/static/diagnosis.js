// The slider of a diagnosis: a cursor on every chart and what the curves say there.
import { cursors, short } from "cursor";

const steer = document.getElementById("steer");
const slider = steer.querySelector("input");
const follow = cursors();

function show() {
  const at = Number(slider.value);
  slider.setAttribute("aria-valuetext", `${short(at)} mm`);
  steer.querySelector("output").textContent = `${short(at)} mm`;
  follow(at);
}

slider.addEventListener("input", show);
steer.hidden = false;
show();
steer.dataset.ready = "true";
