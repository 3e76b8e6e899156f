"use strict";
// The connection, and what is asked for. A page that hears nothing says so at once, and shows nothing as live.

const LOST_MS = 1000; // 20 frames
const BEHIND_S = 1;
const STOP_AGAIN_MS = 300; // without a reply the stop goes by HTTP as well
const STOP_FOR_MS = 10000;
const HAND_MS = 50;
const CONFIRM_MS = 15000;

const page = {
  panels: null, socket: null, frame: null, heard: -Infinity, fastest: Infinity, behind: 0, refused: "",
  waiting: new Map(), number: 0, hand: null, stopping: null,
  token: new URLSearchParams(location.hash.slice(1)).get("token") ?? "",
};

function connect() {
  const socket = (page.socket = new WebSocket(`ws://${location.host}/live`));
  page.fastest = Infinity;
  socket.onopen = () => socket.send(JSON.stringify({ token: page.token }));
  socket.onmessage = ({ data }) => take(socket, JSON.parse(data));
  socket.onclose = ({ code, reason }) => {
    if (page.socket !== socket) return;
    page.refused = code === 4401 ? `${reason}: open the address that tendond dashboard printed` : "";
    for (const done of page.waiting.values()) done(false, "not known whether it was done: the connection was lost");
    page.waiting.clear();
    watch();
    setTimeout(connect, 1000);
  };
}

function take(socket, message) {
  if (message.welcome) {
    welcome(message.welcome);
  } else if ("reply" in message) {
    page.waiting.get(message.reply)?.(message.done, message.message);
    page.waiting.delete(message.reply);
  } else {
    show(message);
    socket.send(JSON.stringify({ seen: message.now }));
  }
}

function welcome(rig) {
  if (page.panels) {
    page.panels.welcome = rig;
    return;
  }
  page.panels = new Panels(rig);
  const fill = (name, values) => values.forEach((value) => made("option", element(name), value));
  fill("laws", rig.laws);
  fill("kind", rig.kinds.filter((kind) => kind !== "samples" && kind !== "path"));
  fill("target-key", ["across", ...rig.targets.filter((key) => key !== "across")]);
  const { kind, ...keys } = rig.reference;
  if (kind) element("kind").value = kind;
  const target = rig.targets.find((key) => key in keys);
  if (target) {
    element("target-key").value = target;
    element("target-value").value = JSON.stringify(keys[target]);
  }
  element("more").value = Object.entries(keys).filter(([key]) => key !== target)
    .map(([key, value]) => `${key}=${JSON.stringify(value)}`).join("; ");
  speed();
}

function show(frame) {
  const now = performance.now();
  page.frame = frame;
  page.heard = now;
  // Of two clocks only the smallest difference is known: what is above it is delay.
  page.fastest = Math.min(page.fastest, now / 1000 - frame.now);
  page.behind = now / 1000 - frame.now - page.fastest;
  page.panels.show(frame);
  if (frame.tunable) page.panels.tunable(frame.tunable, frame.law, ask);
  watch();
}

// Says what is wrong in large letters, and what the buttons can do now.
function watch() {
  const silence = page.still ? 0 : performance.now() - page.heard, { frame } = page;
  const ago = ` What is shown is ${(silence / 1000 + page.behind).toFixed(0)} s old.`;
  let what = "", why = "";
  if (page.refused) [what, why] = ["NO ACCESS", page.refused];
  else if (!frame) [what, why] = ["CONNECTING", "Nothing has come from tendond dashboard yet."];
  else if (silence > LOST_MS || page.behind > BEHIND_S || page.socket?.readyState !== WebSocket.OPEN && !page.still) {
    [what, why] = ["CONNECTION LOST", `The controller goes on by itself; stop it there.${ago}`];
  } else if (frame.silent) {
    const { rig, endpoint } = page.panels.welcome;
    [what, why] = ["NO CONTROLLER", `Nothing is heard of rig '${rig}' at ${endpoint}. What is shown is old.`];
  }
  document.body.dataset.live = what ? "no" : "yes";
  put("alarm-what", what);
  put("alarm-why", why);
  if (what) put("mode", what.toLowerCase());
  document.title = `${what || frame.mode.toUpperCase()} - tendond`;
  const mode = what ? "" : frame.mode;
  const allow = (name, allowed) => (element(name).disabled = !allowed);
  allow("arm", mode === "idle");
  allow("reset", mode === "fault");
  for (const name of ["set-law", "set-reference"]) allow(name, mode === "idle");
  for (const name of ["back", "on"]) allow(name, mode === "tracking");
  if (mode !== "idle") element("confirm").hidden = true;
  if (mode !== "tracking") release();
}

function say(text, bad = false) {
  put("said", text);
  element("said").className = bad ? "bad" : "";
}

function ask(wanted, replied = (done, message) => say(message, !done)) {
  if (page.socket?.readyState !== WebSocket.OPEN) {
    replied(false, "not sent: no connection");
    return;
  }
  const id = ++page.number;
  page.waiting.set(id, replied);
  page.socket.send(JSON.stringify({ ...wanted, id, now: page.frame?.now }));
  if (wanted.do !== "jog" && wanted.do !== "stop") say(`${wanted.do} ...`);
}

// By the WebSocket, which is open; without a reply by HTTP too, again until one comes.
function stop() {
  release();
  element("confirm").hidden = true;
  if (page.stopping) return;
  const stopping = (page.stopping = { until: performance.now() + STOP_FOR_MS, ended: false });
  element("stop").classList.add("asked");
  say("stopping ...");
  const end = (done, message) => {
    if (stopping.ended || !done && performance.now() < stopping.until) return;
    stopping.ended = true;
    page.stopping = null;
    element("stop").classList.remove("asked");
    say(done ? message : `STOP NOT CONFIRMED: ${message}`, !done);
  };
  const byHttp = async () => {
    if (stopping.ended) return;
    say("STOP NOT CONFIRMED YET", true);
    try {
      const headers = { Authorization: `Bearer ${page.token}` };
      const reply = await fetch("/stop", { method: "POST", headers, keepalive: true, signal: AbortSignal.timeout(3000) });
      const { done, message } = reply.ok ? await reply.json() : { done: false, message: await reply.text() };
      end(done, message);
    } catch (error) {
      end(false, "no connection");
    }
    if (!stopping.ended) setTimeout(byHttp, STOP_AGAIN_MS);
  };
  if (page.socket?.readyState === WebSocket.OPEN) ask({ do: "stop" }, end);
  setTimeout(byHttp, page.socket?.readyState === WebSocket.OPEN ? STOP_AGAIN_MS : 0);
}

function speed() {
  const part = element("part").value / 100;
  if (!page.panels) return 0;
  put("speed", `${(1000 * part * page.panels.welcome.speed_max).toFixed(0)} mm/s`);
  return part;
}

// The deadman switch is the held button: without the page, or the network, the controller's own timeout holds the place.
function hold(sign) {
  if (page.hand || element("on").disabled) return;
  const move = () => ask({ do: "jog", part: sign * speed() }, (done, message) => done || (release(), say(message, true)));
  page.hand = { timer: setInterval(move, HAND_MS), name: sign > 0 ? "on" : "back" };
  element(page.hand.name).classList.add("held");
  move();
}

function release() {
  if (!page.hand) return;
  clearInterval(page.hand.timer);
  element(page.hand.name).classList.remove("held");
  page.hand = null;
  if (page.socket?.readyState === WebSocket.OPEN) ask({ do: "jog", part: 0 }, () => {});
}

// Settings divided at semicolons, line ends, and commas outside of brackets.
function settings() {
  const more = element("more").value.split(/[;\n]|,(?![^[]*\])/).map((one) => one.trim()).filter(Boolean);
  const value = element("target-value").value.trim();
  return [`kind=${element("kind").value}`, ...(value ? [`${element("target-key").value}=${value}`] : []), ...more];
}

function listen() {
  const on = (name, kind, act) => element(name).addEventListener(kind, act);
  on("stop", "pointerdown", stop);
  on("stop", "click", (event) => event.detail === 0 && stop()); // by Enter, or an assistive device
  // Wherever the cursor is: in a field, too. No setting needs a space.
  const space = (event) => {
    if (event.code !== "Space") return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.type === "keydown" && !event.repeat) stop();
  };
  addEventListener("keydown", space, true);
  addEventListener("keyup", space, true);
  let asked = 0;
  on("arm", "click", () => {
    element("confirm").hidden = false;
    clearTimeout(asked);
    asked = setTimeout(() => (element("confirm").hidden = true), CONFIRM_MS);
  });
  on("arm-not", "click", () => (element("confirm").hidden = true));
  on("arm-now", "click", () => {
    element("confirm").hidden = true;
    ask({ do: "arm" });
  });
  on("reset", "click", () => ask({ do: "reset" }));
  on("set-law", "click", () => ask({ do: "law", law: element("laws").value }));
  on("set-reference", "click", () => ask({ do: "reference", settings: settings() }));
  on("part", "input", speed);
  for (const [name, sign] of [["back", -1], ["on", 1]]) {
    on(name, "pointerdown", (event) => {
      element(name).setPointerCapture(event.pointerId);
      hold(sign);
    });
    for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) on(name, kind, release);
    on(name, "contextmenu", (event) => event.preventDefault());
  }
  const isField = ({ target }) => /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName ?? "");
  addEventListener("keydown", (event) => {
    if (isField(event) || event.repeat) return;
    if (event.key === "ArrowRight") hold(1);
    if (event.key === "ArrowLeft") hold(-1);
  });
  addEventListener("keyup", (event) => event.key.startsWith("Arrow") && release());
  addEventListener("blur", release);
  document.addEventListener("visibilitychange", () => document.hidden && release());
  setInterval(watch, 100);
}

listen();
if (location.protocol === "file:") page.still = true; // a picture for the documents: its frame is put in
else connect();
watch();
