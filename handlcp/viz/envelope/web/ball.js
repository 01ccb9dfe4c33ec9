/* Ball: the surface around the object, in one mesh for each colour, with the bound's lines and the axes. */

const SOLID = 0.9, CLEAR = 0.35;

class Ball {
  constructor({ centre, points, cells, key, colours, wires, borders, reach, weakest }) {
    this.root = new THREE.Group();
    this.root.position.fromArray(centre);
    this.layers = {};
    this.meshes = colours.map((colour, k) => this.mesh(`key${k}`, colour, points, cells.filter((_, i) => key[i] === k)));
    if (borders.length) this.lines("borders", borders, 0xffffff, 0.9);
    if (wires.length) this.lines("bound", wires, 0x222222, 0.75);
    this.lines("axes", [0, 1, 2].flatMap((k) => [1, -1].map((sign) => {
      const end = [0, 0, 0];
      end[k] = 1.18 * sign * reach;
      return [0, 0, 0, ...end];
    })), 0x5f5f5f, 0.8);
    this.spot(weakest.at, 0.025 * reach);
  }

  /** The weakest direction: a ball with a white rim, which also shows faintly through what is before it. */
  spot(at, radius) {
    this.layers.spot = new THREE.Group();
    for (const [color, size, depthTest, opacity] of [[0xffffff, 1.4, true, 1], [0xc8102e, 1, true, 1], [0xc8102e, 1, false, 0.35]]) {
      const paint = new THREE.MeshBasicMaterial({ color, transparent: true, opacity, depthTest, depthWrite: false });
      const ball = new THREE.Mesh(new THREE.SphereGeometry(size * radius, 20, 14), paint);
      ball.position.fromArray(at);
      ball.renderOrder = color === 0xffffff ? 6 : 7;
      this.layers.spot.add(ball);
    }
    this.root.add(this.layers.spot);
  }

  mesh(layer, colour, points, cells) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(cells.flatMap((c) => c.flatMap((i) => points[i])), 3));
    geometry.computeVertexNormals();
    const paint = new THREE.MeshPhongMaterial({ color: colour, specular: 0x111111, shininess: 8, side: THREE.DoubleSide,
      transparent: true, opacity: SOLID, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const mesh = new THREE.Mesh(geometry, paint);
    mesh.renderOrder = 3;
    this.layers[layer] = mesh;
    this.root.add(mesh);
    return mesh;
  }

  lines(layer, pairs, colour, opacity) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(pairs.flat(), 3));
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity }));
    lines.renderOrder = 4;
    this.layers[layer] = lines;
    this.root.add(lines);
  }

  /** As glass, or nearly solid again. */
  seeThrough(on) {
    for (const { material } of this.meshes) Object.assign(material, { opacity: on ? CLEAR : SOLID, depthWrite: !on });
  }
}

/** What is held in the direction under the pointer. */
class Reader {
  constructor(view, ball, surface) {
    Object.assign(this, { view, ball, surface, box: document.getElementById("says"), caster: new THREE.Raycaster() });
    view.canvas.addEventListener("pointermove", (e) => e.buttons ? this.hide() : this.read(e));
    view.canvas.addEventListener("pointerleave", () => this.hide());
  }

  hide() { this.box.hidden = true; }

  read({ clientX, clientY }) {
    const { left, top, width, height } = this.view.canvas.getBoundingClientRect(), x = clientX - left, y = clientY - top;
    this.caster.setFromCamera({ x: 2 * x / width - 1, y: 1 - 2 * y / height }, this.view.camera);
    const hit = this.caster.intersectObjects(this.ball.meshes.filter((mesh) => mesh.visible))[0];
    if (!hit) return this.hide();
    const k = this.nearest(hit.point.sub(this.ball.root.position).normalize());
    const { directions, held, bound, cause, causes } = this.surface, place = directions[k].map((c) => Number(c.toFixed(2)) || 0);
    this.box.replaceChildren(element("b", held[k]), element("span", `along (${place.join(", ")}): ${causes[cause[k]]}`));
    if (bound[k] !== held[k]) this.box.append(element("br"), element("span", `without compliance: ${bound[k]}`));
    this.box.hidden = false;
    this.box.style.left = `${Math.min(x + 14, width - this.box.offsetWidth - 6)}px`;
    this.box.style.top = `${Math.min(y + 14, height - this.box.offsetHeight - 6)}px`;
  }

  nearest(way) {
    let best = 0, most = -2;
    this.surface.directions.forEach(([a, b, c], k) => {
      const along = a * way.x + b * way.y + c * way.z;
      if (along > most) [best, most] = [k, along];
    });
    return best;
  }
}
