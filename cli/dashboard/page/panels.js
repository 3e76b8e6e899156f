"use strict";
// What a frame shows, put into the page. Text is only ever set as text.

const element = (name) => document.getElementById(name);
const put = (name, text) => {
  const one = element(name);
  if (one.textContent !== text) one.textContent = text;
};
const millimetres = (metres) => (1000 * metres).toFixed(1);
const made = (name, parent, text = "") => {
  const one = document.createElement(name);
  one.textContent = text;
  parent.append(one);
  return one;
};

const HISTORY = 20; // seconds

class Panels {
  constructor(welcome) {
    this.welcome = welcome;
    this.scene = new Scene(element("scene"), welcome.length, welcome.gravity);
    this.history = [];
    put("rig", welcome.rig);
  }

  show(frame) {
    const { body } = document;
    body.dataset.mode = frame.mode ?? "";
    body.dataset.seq = frame.seq ?? "";
    body.dataset.tick = frame.tick ?? "";
    put("mode", frame.mode ?? "no controller");
    put("reason", frame.reason ?? "");
    const servos = frame.servo_fault ? `servos: ${frame.servo_fault}. ` : "";
    put("remedy", servos + (frame.remedy ? `To clear it: ${frame.remedy}` : ""));
    put("law", frame.law ? `${frame.law.replaceAll("_", " ")}, feedback ${frame.feedback}` : "");
    put("armed", frame.armed === false ? "disarmed, torque off" : "");
    put("tension-max", (frame.tension_max ?? 0).toFixed(0));
    this.tendons(frame);
    this.numbers(frame);
    this.histories(frame);
    this.scene.draw(frame.scene ? frame.scene.entities : [], frame.ghost, frame.target);
  }

  tendons({ tension = [], displacement = [], measured = [], tension_max }) {
    const body = element("tendon-rows");
    while (body.rows.length > tension.length) body.deleteRow(-1);
    tension.forEach((value, k) => {
      let row = body.rows[k];
      if (!row) {
        row = body.insertRow();
        for (let cell = 0; cell < 5; cell++) row.insertCell();
        made("i", made("div", row.cells[1])).parentElement.className = "bar";
        row.cells[0].textContent = k;
        row.cells[2].id = `tension-${k}`;
      }
      const part = value / tension_max, bar = row.cells[1].firstChild;
      bar.className = `bar ${part > 0.98 ? "bad" : part > 0.8 ? "warn" : ""}`;
      bar.firstChild.style.width = `${100 * Math.min(1, Math.max(0, part))}%`;
      row.cells[2].textContent = value.toFixed(2);
      const { displacement_min, displacement_max } = this.welcome;
      const limit = displacement[k] >= 0 ? displacement_max : -displacement_min;
      row.cells[3].textContent = millimetres(displacement[k]);
      row.cells[3].className = Math.abs(displacement[k]) > 0.98 * limit ? "bad" : "";
      row.cells[4].textContent = measured[k] === undefined ? "" : millimetres(measured[k]);
    });
  }

  numbers(frame) {
    const age = (one, what) => {
      if (one.age === null) return [what, "none yet", "warn"];
      const late = one.age > 0.5;
      return [what, `${one.rate.toFixed(1)} Hz, ${(1000 * one.age).toFixed(0)} ms old`, late ? "bad" : ""];
    };
    const pose = age(frame.pose, "pose");
    if (frame.pose.age !== null && !frame.pose.valid) pose.splice(1, 2, `${pose[1]}, hidden`, "warn");
    const place = (p) => (p ? p.map(millimetres).join("  ") + " mm" : "none yet");
    const rows = [
      ["tip", place(frame.tip), ""],
      ["target", place(frame.target), ""],
      pose,
      age(frame.command_stream, "command"),
      age(frame.tendons_stream, "servos"),
      ...(frame.rows ?? []),
    ];
    const body = element("rows");
    while (body.rows.length > rows.length) body.deleteRow(-1);
    rows.forEach(([label, value, style], k) => {
      const row = body.rows[k] ?? body.insertRow();
      while (row.cells.length < 2) row.insertCell();
      row.cells[0].textContent = label;
      row.cells[1].textContent = value;
      row.cells[1].className = style;
    });
  }

  // Distance over time, logarithmic from 0.1 mm; tensions over time, from zero to their limit.
  histories({ now, error, tension = [], tension_max = 1 }) {
    put("error", error === null ? "" : `${millimetres(error)} mm`);
    this.history = this.history.filter((one) => one.now <= now && one.now > now - HISTORY);
    this.history.push({ now, error, tension });
    const level = (metres) => (Math.log10(Math.max(metres, 1e-4)) + 4) / 4;
    this.chart("errors", [this.history.map((one) => (one.error === null ? null : level(one.error)))], [1e-3, 1e-2, 1e-1].map(level));
    const part = (k) => this.history.map((one) => (one.tension[k] ?? 0) / tension_max);
    this.chart("tensions", tension.map((_, k) => part(k)), [0.5, 1]);
  }

  // Curves and level lines, each value from 0 at the bottom to 1 at the top; null: a gap.
  chart(name, curves, lines) {
    const canvas = element(name), ratio = devicePixelRatio || 1, pen = canvas.getContext("2d");
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const times = this.history.map(({ now }) => now), last = times.at(-1);
    const at = (value) => 3 + (height - 6) * (1 - value), style = getComputedStyle(document.body);
    const draw = (values, color, thick) => {
      pen.strokeStyle = color;
      pen.lineWidth = thick;
      pen.beginPath();
      values.forEach((one, k) => {
        if (one === null) return;
        pen[k && values[k - 1] !== null ? "lineTo" : "moveTo"](width * (1 - (last - times[k]) / HISTORY), at(one));
      });
      pen.stroke();
    };
    pen.fillStyle = style.getPropertyValue("--line");
    for (const one of lines) pen.fillRect(0, at(one), width, 1);
    curves.forEach((values, k) => {
      pen.setLineDash(k % 2 ? [5, 3] : []);
      draw(values, style.getPropertyValue(k % 4 < 2 ? "--rod" : "--target"), 2);
    });
    pen.setLineDash([]);
  }

  // The tunable keys of the limits and of the law in use; what is being typed stays.
  tunable(keys, law, ask) {
    const own = Object.entries(keys).filter(([key]) => !key.startsWith("control.laws.") || key.startsWith(`control.laws.${law}.`));
    const body = element("tunable").tBodies[0], names = own.map(([key]) => key).join();
    if (body.dataset.names !== names) {
      body.dataset.names = names;
      body.replaceChildren();
      for (const [key] of own) {
        const row = body.insertRow();
        const name = row.insertCell();
        name.textContent = key.replace("control.laws.", "");
        made("small", name);
        const input = made("input", row.insertCell());
        input.setAttribute("aria-label", key);
        input.inputMode = "decimal";
        const button = made("button", row.insertCell(), "Set");
        button.type = "button";
        const set = () => input.value.trim() && ask({ do: "set", settings: [`${key}=${input.value.trim()}`] });
        button.addEventListener("click", set);
        input.addEventListener("keydown", (event) => event.key === "Enter" && set());
      }
    }
    own.forEach(([, one], k) => {
      const row = body.rows[k], number = (value) => Number(value.toPrecision(4)).toString();
      const moves = one.value === one.wanted ? "" : `, moves to ${number(one.wanted)}`;
      const text = `${number(one.value)}${moves}; configured ${number(one.configured)}; ${one.allowed}; changes ${one.changes}`;
      if (row.cells[0].lastChild.textContent === text) return;
      row.cells[0].lastChild.textContent = text;
      row.cells[1].firstChild.placeholder = number(one.value);
    });
  }
}
