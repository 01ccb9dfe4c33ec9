/* Solids: shapes out of their packed form, shaded smoothly but for sharp edges, and moved by joints. */

const GRID = 65534, CREASE = Math.cos(Math.PI * 35 / 180);

/** The bytes behind base64 and gzip. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** A shape in its box: each corner has the mean normal of the triangles around it that turn little from its own. */
function shaped(part, buffer) {
  const { low, size } = part;
  const points = new Uint16Array(buffer, part.points[0], 3 * part.points[1]);
  const corners = new (part.wide ? Uint32Array : Uint16Array)(buffer, part.corners[0], 3 * part.corners[1]);
  const place = Float32Array.from(points, (p, i) => low[i % 3] + size[i % 3] * p / GRID);
  const a = new THREE.Vector3(), b = new THREE.Vector3(), c = new THREE.Vector3();
  const faces = new Float32Array(corners.length), units = new Float32Array(corners.length);
  const around = Array.from({ length: points.length / 3 }, () => []);
  for (let t = 0; t < corners.length; t += 3) {
    a.fromArray(place, 3 * corners[t]);
    b.fromArray(place, 3 * corners[t + 1]).sub(a);
    c.fromArray(place, 3 * corners[t + 2]).sub(a);
    b.cross(c).toArray(faces, t);
    b.normalize().toArray(units, t);
    for (let k = 0; k < 3; k++) around[corners[t + k]].push(t);
  }
  const position = new Float32Array(3 * corners.length), normal = new Float32Array(3 * corners.length);
  for (let i = 0; i < corners.length; i++) {
    const own = 3 * Math.floor(i / 3);
    a.set(0, 0, 0);
    b.fromArray(units, own);
    for (const t of around[corners[i]]) {
      if (c.fromArray(units, t).dot(b) > CREASE) a.add(c.fromArray(faces, t));
    }
    (a.lengthSq() > 0 ? a.normalize() : a.copy(b)).toArray(normal, 3 * i);
    for (let k = 0; k < 3; k++) position[3 * i + k] = place[3 * corners[i] + k];
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
  return geometry;
}

/** Move a group to (x, y, z, quaternion). */
function setPose(group, pose) {
  group.position.fromArray(pose);
  group.quaternion.fromArray(pose, 3);
}

/** All solids in groups: of each joint, of the object, of what stands still. */
class Solids {
  constructor(parts, buffer) {
    this.root = new THREE.Group();
    this.object = new THREE.Group();
    this.joints = new Map();
    this.layers = { hand: [], inside: [], tips: [], object: [], environment: [] };
    this.root.add(this.object);
    for (const part of parts) this.add(part, shaped(part, buffer));
  }

  add(part, geometry) {
    const colour = new THREE.Color(...part.colour);
    const meshes = part.layer === "object" || part.layer === "tips" ? glass(geometry, colour) : opaque(geometry, colour);
    const group = new THREE.Group();
    group.add(...meshes);
    this.layers[part.layer].push(group);
    this.mover(part).add(group);
  }

  /** The group that moves a part. */
  mover({ layer, joint }) {
    if (layer === "object") return this.object;
    if (joint < 0) return this.root;
    if (!this.joints.has(joint)) {
      this.joints.set(joint, new THREE.Group());
      this.root.add(this.joints.get(joint));
    }
    return this.joints.get(joint);
  }

  /** The hand as glass, or solid again. */
  seeThrough(on) {
    for (const group of [...this.layers.hand, ...this.layers.inside]) {
      const { material } = group.children[0];
      Object.assign(material, { transparent: on, opacity: on ? 0.22 : 1, depthWrite: !on, needsUpdate: true });
    }
  }

  /** Where everything is in a frame. */
  show(frame) {
    setPose(this.object, frame.object);
    for (const [joint, group] of this.joints) if (frame.joints) setPose(group, frame.joints[joint]);
  }
}

/** A body with thin lines along its sharp edges. */
function opaque(geometry, colour) {
  const paint = new THREE.MeshPhongMaterial({ color: colour, specular: 0x222222, shininess: 18, side: THREE.DoubleSide,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  const ink = new THREE.LineBasicMaterial({ color: colour.clone().multiplyScalar(0.5), transparent: true, opacity: 0.55 });
  return [new THREE.Mesh(geometry, paint), new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 40), ink)];
}

/** A translucent body: its far side, its near side, its sharp edges. */
function glass(geometry, colour) {
  const style = { color: colour, transparent: true, opacity: 0.3, depthWrite: false, specular: 0x111111, shininess: 10 };
  const sides = [THREE.BackSide, THREE.FrontSide].map((side, k) => {
    const mesh = new THREE.Mesh(geometry, new THREE.MeshPhongMaterial({ ...style, side }));
    mesh.renderOrder = 1 + k;
    return mesh;
  });
  const ink = new THREE.LineBasicMaterial({ color: colour.clone().multiplyScalar(0.45) });
  return [...sides, new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 28), ink)];
}
