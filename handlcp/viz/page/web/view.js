/* View: an orthographic camera that turns about the upright axis, drawn when something changes. */

class View {
  constructor(canvas, { axes, up }) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.scene = new THREE.Scene();
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);
    this.up = new THREE.Vector3(...up);
    this.first = this.anglesOf(new THREE.Vector3(...axes[2]));
    this.home = { target: new THREE.Vector3(), width: 1, height: 1, depth: 1 };
    this.onframe = () => {};
    this.light();
    this.reset();
    new ResizeObserver(() => this.draw()).observe(canvas);  // before the page is painted, not a frame later
    new Hands(this);
  }

  light() {
    this.sky = new THREE.HemisphereLight(0xffffff, 0xc4c2be, 0.68);
    this.lamp = new THREE.DirectionalLight(0xffffff, 0.4);
    this.scene.add(this.sky, this.lamp, this.lamp.target);
  }

  /** Two axes across the upright one. */
  level() {
    const other = Math.abs(this.up.x) < 0.8 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    const a = other.addScaledVector(this.up, -other.dot(this.up)).normalize();
    return [a, this.up.clone().cross(a)];
  }

  anglesOf(towards) {
    const [a, b] = this.level();
    return { yaw: Math.atan2(towards.dot(b), towards.dot(a)), pitch: Math.asin(Math.max(-1, Math.min(1, towards.dot(this.up)))) };
  }

  /** Screen right, screen up, towards the viewer. */
  axes() {
    const [a, b] = this.level(), c = Math.cos(this.pitch);
    const towards = a.multiplyScalar(c * Math.cos(this.yaw)).addScaledVector(b, c * Math.sin(this.yaw)).addScaledVector(this.up, Math.sin(this.pitch));
    const right = this.up.clone().cross(towards).normalize();
    return [right, towards.clone().cross(right), towards];
  }

  /** See all of these points from the first direction; `core` is what matters where the rest is far larger. */
  frame(core, rest) {
    Object.assign(this, this.first);
    const [right, up] = this.axes();
    const flat = (points) => points.map((p) => [p.dot(right), p.dot(up)]);
    let box = limits(flat(core));
    const middle = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2], radius = Math.max(box[2] - box[0], box[3] - box[1]) / 2;
    const others = flat(rest), far = Math.max(0, ...others.map((p) => Math.max(Math.abs(p[0] - middle[0]), Math.abs(p[1] - middle[1]))));
    const cut = 2.5 * radius, within = (x, m) => Math.max(m - cut, Math.min(m + cut, x));
    const seen = far > 3.8 * radius ? others.map((p) => [within(p[0], middle[0]), within(p[1], middle[1])]) : others;
    box = limits([...flat(core), ...seen]);
    const all = new THREE.Box3().setFromPoints([...core, ...rest]);
    this.home.target.copy(all.getCenter(new THREE.Vector3()));
    this.home.target.addScaledVector(right, (box[0] + box[2]) / 2 - this.home.target.dot(right));
    this.home.target.addScaledVector(up, (box[1] + box[3]) / 2 - this.home.target.dot(up));
    this.home.depth = 4 * all.getSize(new THREE.Vector3()).length();
    Object.assign(this.home, { width: box[2] - box[0], height: box[3] - box[1] });
    this.reset();
  }

  reset() {
    Object.assign(this, this.first, { scale: 1, target: this.home.target.clone() });
    this.dirty();
  }

  /** Half the height of what is seen [m]: whatever the window's shape, all of it at first. */
  get half() {
    const aspect = Math.max(this.canvas.clientWidth, 1) / Math.max(this.canvas.clientHeight, 1);
    return 0.57 * this.scale * Math.max(this.home.height, this.home.width / aspect, 1e-9);
  }

  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.max(-1.55, Math.min(1.55, this.pitch + pitch));
    this.dirty();
  }

  /** By pixels. */
  move(x, y) {
    const [right, up] = this.axes(), each = 2 * this.half / Math.max(this.canvas.clientHeight, 1);
    this.target.addScaledVector(right, -x * each).addScaledVector(up, y * each);
    this.dirty();
  }

  /** About a point of the canvas, in pixels from its middle. */
  zoom(factor, x = 0, y = 0) {
    const scale = Math.max(0.02, Math.min(20, this.scale * factor)), share = scale / this.scale;
    this.move(x * (share - 1), y * (share - 1));
    this.scale = scale;
    this.dirty();
  }

  dirty() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  draw() {
    const w = this.canvas.clientWidth, h = this.canvas.clientHeight;
    if (!w || !h) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(w, h, false);
    const [right, up, towards] = this.axes(), wide = this.half * w / h;
    Object.assign(this.camera, { left: -wide, right: wide, top: this.half, bottom: -this.half, near: 0, far: 2 * this.home.depth });
    this.camera.position.copy(this.target).addScaledVector(towards, this.home.depth);
    this.camera.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(right, up, towards));
    this.camera.updateProjectionMatrix();
    this.sky.position.copy(up).addScaledVector(towards, 1);
    this.lamp.target.position.copy(this.target);
    this.lamp.position.copy(this.target).addScaledVector(right, -0.45).addScaledVector(up, 0.65).addScaledVector(towards, 0.62);
    this.renderer.render(this.scene, this.camera);
    this.onframe((p) => [w / 2 + (p.clone().sub(this.target).dot(right)) * h / (2 * this.half),
      h / 2 - (p.clone().sub(this.target).dot(up)) * h / (2 * this.half)], w, h);
  }
}

/** Mouse, fingers and keys. */
class Hands {
  constructor(view) {
    const canvas = view.canvas, down = new Map();
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); down.set(e.pointerId, [e.clientX, e.clientY]); });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (e) => down.delete(e.pointerId));
    canvas.addEventListener("pointermove", (e) => {
      if (!down.has(e.pointerId)) return;
      const before = [...down.values()], [x, y] = down.get(e.pointerId), dx = e.clientX - x, dy = e.clientY - y;
      down.set(e.pointerId, [e.clientX, e.clientY]);
      const now = [...down.values()];
      if (now.length > 1) {
        view.zoom(spread(before) / spread(now));
        view.move(dx / 2, dy / 2);
      } else if (e.buttons & 6 || e.shiftKey) view.move(dx, dy);
      else view.turn(-0.008 * dx, 0.008 * dy);
    });
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      const box = canvas.getBoundingClientRect();
      view.zoom(Math.exp(0.0012 * Math.max(-300, Math.min(300, e.deltaY))), e.clientX - box.left - box.width / 2, e.clientY - box.top - box.height / 2);
    }, { passive: false });
    const keys = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    canvas.addEventListener("keydown", (e) => {
      if (keys[e.key]) view.turn(...keys[e.key]);
      else if (e.key === "+" || e.key === "-") view.zoom(e.key === "+" ? 0.9 : 1.1);
      else if (e.key === "0") view.reset();
      else return;
      e.preventDefault();
    });
  }
}

function spread([[ax, ay], [bx, by]]) {
  return Math.max(Math.hypot(ax - bx, ay - by), 1);
}

/** Of points on the screen: [x0, y0, x1, y1]. */
function limits(points) {
  const xs = points.map((p) => p[0]), ys = points.map((p) => p[1]);
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}
