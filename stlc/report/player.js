// Playing, scrubbing, keys; `#t=3.5` in the address is the step to begin with.
const player = { playing: false, last: 0, speed: 1 };
const slider = document.getElementById("time"), button = document.getElementById("play");

function pace() { // steps a second: the whole run takes 12 s at speed 1, and no step less than 0.1 s
  return player.speed * Math.min(T / 12, 10);
}

function frame(now) {
  if (!player.playing) return;
  const passed = Math.min((now - player.last) / 1000, 0.1);
  player.last = now;
  seek(state.t + passed * pace());
  if (state.t >= T) play(false);
  else requestAnimationFrame(frame);
}

function play(on) {
  player.playing = on;
  button.textContent = on ? "⏸" : "▶";
  button.setAttribute("aria-label", on ? "Pause" : "Play");
  if (!on) return;
  if (state.t >= T) seek(0);
  player.last = performance.now();
  requestAnimationFrame(frame);
}

function setUp() {
  const speed = document.getElementById("speed");
  for (const v of [0.25, 0.5, 1, 2, 4]) make("option", { value: v, text: `${v}×` }, speed);
  speed.value = "1";
  speed.addEventListener("change", () => { player.speed = Number(speed.value); });
  button.addEventListener("click", () => play(!player.playing));
  slider.addEventListener("input", () => { play(false); seek(Number(slider.value)); });
  onTime((t) => {
    slider.value = String(t);
    document.getElementById("clock").textContent = `${seconds(t)}, step ${Math.floor(t + 1e-9)}`;
  });
  document.addEventListener("keydown", (event) => {
    if (["INPUT", "SELECT", "BUTTON"].includes(event.target.tagName)) return;
    const steps = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === " ") play(!player.playing);
    else if (steps) seek(Math.round(state.t) + steps);
    else return;
    event.preventDefault();
  });
}

function drawAll() {
  drawMap();
  drawNeeds();
  drawCharts();
}

let width = 0;
window.addEventListener("resize", () => {
  if (document.body.clientWidth === width) return; // the address bar of a phone comes and goes
  width = document.body.clientWidth;
  drawAll();
});
setUp();
mapKey();
joinText();
width = document.body.clientWidth;
drawAll();
seek(Number((/t=([\d.]+)/.exec(location.hash) || [0, 0])[1]));
