"use strict";
// The rod in space, as the log's and Foxglove's scene describes it (daemon/recording/scene.py), on a plain canvas.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a, k) => [a[0] * k, a[1] * k, a[2] * k];
const added = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const xyz = (p) => [p.x, p.y, p.z];

// Axes of a pose: the columns of its rotation matrix, from the quaternion.
function axesOf({ x, y, z, w }) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
}

class Scene {
  // canvas: to draw on. length: of the arm [m]. gravity: [m/s^2], which points down on the screen.
  constructor(canvas, length, gravity) {
    this.canvas = canvas;
    this.length = length;
    const size = Math.hypot(...gravity);
    this.up = size > 0 ? scaled(gravity, -1 / size) : [0, 0, 1];
    // Along the straight rod, as far as that is level; else, where it stands or hangs, along x.
    const along = Math.abs(this.up[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const level = added(along, scaled(this.up, -dot(along, this.up)));
    this.along = scaled(level, 1 / Math.hypot(...level));
    this.side = cross(this.along, this.up);
    this.turn = 0.35;
    this.tilt = 0.3;
    this.zoom = 1;
    this.drawn = null;
    this.listen();
  }

  listen() {
    const fingers = new Map();
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) return;
      const before = fingers.size === 2 ? spread() : 0;
      if (fingers.size === 1) {
        this.turn += (event.clientX - last.x) * 0.01;
        this.tilt = Math.min(1.5, Math.max(-1.5, this.tilt + (event.clientY - last.y) * 0.01));
      }
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (before > 0) this.zoom *= spread() / before;
      this.redraw();
    });
    for (const name of ["pointerup", "pointercancel"]) {
      this.canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
    }
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom *= Math.exp(-0.001 * event.deltaY);
      this.redraw();
    }, { passive: false });
    addEventListener("resize", () => this.redraw());
  }

  // A direction on the screen, in metres to the right and downwards.
  seen(p) {
    const a = dot(p, this.along), s = dot(p, this.side), u = dot(p, this.up);
    const [c, d] = [Math.cos(this.turn), Math.sin(this.turn)];
    return [a * c + s * d, -u * Math.cos(this.tilt) - (-a * d + s * c) * Math.sin(this.tilt)];
  }

  at(p) {
    const [x, y] = this.seen(added(p, scaled(this.centre, -1)));
    return [this.width / 2 + x * this.scale, this.height / 2 + y * this.scale];
  }

  draw(entities, ghost, target) {
    this.drawn = [entities, ghost, target];
    const ratio = devicePixelRatio || 1;
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    if (this.canvas.width !== Math.round(this.width * ratio) || this.canvas.height !== Math.round(this.height * ratio)) {
      this.canvas.width = Math.round(this.width * ratio);
      this.canvas.height = Math.round(this.height * ratio);
    }
    const pen = (this.pen = this.canvas.getContext("2d"));
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, this.width, this.height);
    pen.lineCap = pen.lineJoin = "round";
    this.scale = (this.zoom * Math.min(this.width / 1.6, this.height / 1.3)) / this.length;
    this.centre = added([0, 0, 0.35 * this.length], scaled(this.up, 0.25 * this.length));
    const style = getComputedStyle(document.body);
    this.axes(style.getPropertyValue("--dim"));
    const orange = style.getPropertyValue("--target");
    if (ghost) this.line(ghost, 5, orange, 0.4);
    for (const entity of entities) {
      for (const line of entity.lines) this.line(line.points.map(xyz), line.thickness * this.scale, line.color);
      for (const one of entity.cylinders) this.rodOf(one);
      for (const one of entity.spheres) this.ellipsoid(one);
      for (const one of entity.arrows) this.arrow(one);
    }
    if (target) this.cross(target, orange);
  }

  redraw() {
    if (this.drawn) this.draw(...this.drawn);
  }

  axes(color) {
    for (const [name, axis] of [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]]) {
      const end = scaled(axis, 0.12 * this.length);
      this.line([[0, 0, 0], end], 1, color);
      this.pen.fillStyle = color;
      this.pen.font = "12px system-ui, sans-serif";
      this.pen.fillText(name, ...this.at(scaled(end, 1.15)));
    }
    const step = this.length > 1.2 ? 0.5 : this.length > 0.25 ? 0.1 : 0.01;
    const [x, y] = [12, this.height - 12];
    this.pen.strokeStyle = color;
    this.pen.lineWidth = 2;
    this.pen.beginPath();
    this.pen.moveTo(x, y);
    this.pen.lineTo(x + step * this.scale, y);
    this.pen.stroke();
    this.pen.fillText(`${step * 1000} mm`, x, y - 6);
  }

  line(points, width, color, alpha = 1) {
    if (points.length < 2) return;
    this.pen.strokeStyle = this.css(color);
    this.pen.globalAlpha = alpha;
    this.pen.lineWidth = Math.max(1, width);
    this.pen.beginPath();
    points.forEach((p, k) => this.pen[k ? "lineTo" : "moveTo"](...this.at(p)));
    this.pen.stroke();
    this.pen.globalAlpha = 1;
  }

  // The outline of {c + M n, |n| = 1}, M the half axes as the screen sees them, is the ellipse of M M'.
  ellipsoid({ pose, size, color }) {
    const axes = axesOf(pose.orientation), halves = [size.x / 2, size.y / 2, size.z / 2];
    let [a, b, c] = [0, 0, 0];
    axes.forEach((axis, k) => {
      const [x, y] = this.seen(scaled(axis, halves[k]));
      a += x * x;
      b += x * y;
      c += y * y;
    });
    const mean = (a + c) / 2, root = Math.hypot((a - c) / 2, b);
    const radii = [Math.sqrt(mean + root), Math.sqrt(Math.max(0, mean - root))].map((r) => Math.max(2, r * this.scale));
    this.pen.fillStyle = this.css(color);
    this.pen.beginPath();
    this.pen.ellipse(...this.at(xyz(pose.position)), ...radii, 0.5 * Math.atan2(2 * b, a - c), 0, 2 * Math.PI);
    this.pen.fill();
  }

  arrow({ pose, shaft_length, shaft_diameter, head_length, head_diameter, color }) {
    const from = xyz(pose.position), [axis] = axesOf(pose.orientation);
    const neck = added(from, scaled(axis, shaft_length)), end = added(neck, scaled(axis, head_length));
    this.line([from, neck], Math.max(2, shaft_diameter * this.scale), color);
    const [nx, ny] = this.at(neck), [ex, ey] = this.at(end);
    const length = Math.hypot(ex - nx, ey - ny) || 1, half = Math.max(4, (head_diameter * this.scale) / 2);
    const [px, py] = [(-(ey - ny) / length) * half, ((ex - nx) / length) * half];
    this.pen.fillStyle = this.css(color);
    this.pen.beginPath();
    this.pen.moveTo(ex, ey);
    this.pen.lineTo(nx + px, ny + py);
    this.pen.lineTo(nx - px, ny - py);
    this.pen.fill();
  }

  rodOf({ pose, size, color }) {
    const [, , axis] = axesOf(pose.orientation), half = scaled(axis, size.z / 2), centre = xyz(pose.position);
    this.line([added(centre, scaled(half, -1)), added(centre, half)], size.x * this.scale, color);
  }

  cross(p, color) {
    const [x, y] = this.at(p);
    this.pen.strokeStyle = color;
    this.pen.lineWidth = 2;
    this.pen.beginPath();
    this.pen.moveTo(x - 9, y);
    this.pen.lineTo(x + 9, y);
    this.pen.moveTo(x, y - 9);
    this.pen.lineTo(x, y + 9);
    this.pen.stroke();
  }

  css(color) {
    if (typeof color === "string") return color;
    const [r, g, b] = [color.r, color.g, color.b].map((part) => Math.round(255 * part));
    return `rgba(${r}, ${g}, ${b}, ${color.a})`;
  }
}
