/* Marks: arrows, friction cones, contact points, moments. What is behind a solid still shows, faintly. */

const UNIT = {};  // geometries of size one, along z, made once

function unit(name) {
  if (!UNIT[name]) UNIT[name] = SHAPES[name]();
  return UNIT[name];
}

const SHAPES = {
  shaft: () => new THREE.CylinderGeometry(1, 1, 1, 20).rotateX(Math.PI / 2).translate(0, 0, 0.5),
  head: () => new THREE.ConeGeometry(1, 1, 24).rotateX(Math.PI / 2).translate(0, 0, 0.5),
  ball: () => new THREE.SphereGeometry(1, 20, 14),
  ring: () => new THREE.TorusGeometry(1, 0.05, 10, 64, 1.5 * Math.PI),
  cone: () => surface(73, (a) => [Math.cos(a), Math.sin(a), 1]),
  wedge: () => surface(2, (a) => [Math.cos(a / 2), 0, 1]),
  rim: () => outline(73, (a) => [Math.cos(a), Math.sin(a), 1]),
  vee: () => new THREE.BufferGeometry().setFromPoints([[1, 0, 1], [0, 0, 0], [-1, 0, 1]].map((p) => new THREE.Vector3(...p))),
};

/** Triangles from the origin to the points of a rim. */
function surface(count, rim) {
  const corners = [], turn = 2 * Math.PI / (count - 1);
  for (let k = 0; k + 1 < count; k++) corners.push(0, 0, 0, ...rim(k * turn), ...rim((k + 1) * turn));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  return geometry;
}

function outline(count, rim) {
  const points = Array.from({ length: count }, (_, k) => new THREE.Vector3(...rim(2 * Math.PI * k / (count - 1))));
  return new THREE.BufferGeometry().setFromPoints(points);
}

class Marks {
  constructor(data) {
    this.data = data;
    this.size = data.size;
    this.root = new THREE.Group();
    this.layers = {};
    this.inks = new Map();
  }

  /** Everything of a frame, in place of what was there. */
  show(frame) {
    this.root.clear();
    this.layers = {};
    for (const name of ["cones", "forces", "load", "slips", "escape"]) {
      this.layers[name] = new THREE.Group();
      this.root.add(this.layers[name]);
    }
    frame.contacts.forEach((c, i) => this.contact(c, this.data.contacts[i]));
    const { load, colours } = { load: frame.load, colours: this.data.colours };
    const at = new THREE.Vector3(...load.at);
    this.arrow("load", at, new THREE.Vector3(...load.force).multiplyScalar(this.data.perNewton), colours.load, 1.15);
    this.turn("load", at, new THREE.Vector3(...load.moment), 0.36 * this.size, colours.load);
    if (this.data.escape && frame === this.data.frames[0]) this.escape(this.data.escape);
  }

  contact(c, { mu }) {
    const colours = this.data.colours, colour = colours[c.state], at = new THREE.Vector3(...c.at);
    const [x, y, n] = c.axes.map((axis) => new THREE.Vector3(...axis));
    const height = c.state === "" ? 0.5 * this.size : c.normal * this.data.perNewton;
    if (mu[0] > 0 && height > 0.02 * this.size) this.cone(at, x, y, n, mu, height, colour);
    this.arrow("forces", at, new THREE.Vector3(...c.force).multiplyScalar(this.data.perNewton), colour, 1);
    this.turn("forces", at, n.clone().multiplyScalar(c.moment), 0.2 * this.size, colour);
    this.ball(at, colour);
    if (c.state === "sliding") {
      const slip = new THREE.Vector3(...c.slip).multiplyScalar(this.data.slipFactor);
      this.arrow("slips", at, slip, colours.slip, 0.85);
    }
  }

  cone(at, x, y, n, mu, height, colour) {
    const matrix = new THREE.Matrix4().makeBasis(
      x.clone().multiplyScalar(mu[0] * height), y.clone().multiplyScalar(mu[1] * height || 1e-9), n.clone().multiplyScalar(height),
    ).setPosition(at);
    const [body, edge] = this.data.planar ? ["wedge", "vee"] : ["cone", "rim"];
    const paint = this.ink("cone" + colour, () => new THREE.MeshBasicMaterial({
      color: colour, transparent: true, opacity: 0.2, depthWrite: false, side: THREE.DoubleSide }));
    const line = this.ink("line" + colour, () => new THREE.LineBasicMaterial({
      color: colour, transparent: true, opacity: 0.8, depthTest: false }));
    this.place("cones", new THREE.Mesh(unit(body), paint), matrix, 4);
    this.place("cones", new THREE.Line(unit(edge), line), matrix, 4);
  }

  /** From a point, along a vector [m]. */
  arrow(layer, start, vector, colour, width, dashed = false) {
    const length = vector.length(), size = this.size * width;
    if (length < 0.015 * this.size) return;
    const head = Math.min(0.17 * size, 0.6 * length), thick = Math.min(0.025 * size, 0.3 * head);
    const along = basis(vector), neck = length - head;
    const pieces = dashed ? dashes(neck, 0.09 * size) : [[0, neck]];
    for (const [from, to] of pieces) this.solid(layer, "shaft", frameOf(along, start, from, thick, to - from), colour);
    this.solid(layer, "head", frameOf(along, start, neck, 2.7 * thick, head), colour);
  }

  /** A moment: about the axis by the right hand's rule. */
  turn(layer, at, moment, radius, colour) {
    if (moment.length() === 0) return;
    const along = basis(moment);
    this.solid(layer, "ring", frameOf(along, at, 0, radius, radius), colour);
    const [x, y] = along, end = at.clone().addScaledVector(y, -radius);
    this.solid(layer, "head", frameOf(basis(x), end, 0, 0.15 * radius, 0.36 * radius), colour);
  }

  ball(at, colour) {
    const r = 0.036 * this.size;
    this.solid("forces", "ball", new THREE.Matrix4().makeScale(r, r, r).setPosition(at), colour);
  }

  escape({ at, move, turn }) {
    const start = new THREE.Vector3(...at), colour = this.data.colours.escape;
    const way = new THREE.Vector3(...move).multiplyScalar(1.2), about = new THREE.Vector3(...turn);
    this.arrow("escape", start, way, colour, 1.5, true);
    if (about.length() > 0.3) this.turn("escape", start, about, 0.5 * this.size, colour);
  }

  /** Twice: as a solid, and faintly through whatever is before it. */
  solid(layer, shape, matrix, colour) {
    const ink = this.ink("solid" + colour, () => new THREE.MeshLambertMaterial({ color: colour, emissive: colour, emissiveIntensity: 0.35 }));
    const ghost = this.ink("ghost" + colour, () => new THREE.MeshBasicMaterial({
      color: colour, transparent: true, opacity: 0.4, depthTest: false, depthWrite: false }));
    this.place(layer, new THREE.Mesh(unit(shape), ink), matrix, 0);
    this.place(layer, new THREE.Mesh(unit(shape), ghost), matrix, 5);
  }

  place(layer, mesh, matrix, order) {
    mesh.matrixAutoUpdate = false;
    mesh.matrix.copy(matrix);
    mesh.renderOrder = order;
    this.layers[layer].add(mesh);
  }

  ink(key, make) {
    if (!this.inks.has(key)) this.inks.set(key, make());
    return this.inks.get(key);
  }
}

/** Right-handed unit axes, the third along a vector. */
function basis(vector) {
  const z = vector.clone().normalize();
  const other = Math.abs(z.x) < 0.8 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
  const x = other.cross(z).normalize();
  return [x, z.clone().cross(x), z];
}

/** A unit shape along z: put at a distance along the axis, so wide and so long. */
function frameOf([x, y, z], start, from, wide, long) {
  return new THREE.Matrix4().makeBasis(
    x.clone().multiplyScalar(wide), y.clone().multiplyScalar(wide), z.clone().multiplyScalar(long),
  ).setPosition(start.clone().addScaledVector(z, from));
}

function dashes(length, period) {
  const count = Math.max(1, Math.round(length / period));
  return Array.from({ length: count }, (_, k) => [k * length / count, (k + 0.6) * length / count]);
}
