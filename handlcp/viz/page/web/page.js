/* Page: reads its data, draws the first frame, and looks whether anything came of it. */

async function open() {
  const data = JSON.parse(document.getElementById("data").textContent);
  const torques = new Torques(document.getElementById("torques"), document.getElementById("motors"), data);
  const scene = { view: null, solids: null, marks: new Marks(data), labels: null };
  const hidden = new Set();
  const apply = () => {
    if (!scene.view) return;
    for (const [name, groups] of Object.entries(scene.solids.layers)) groups.forEach((g) => { g.visible = !hidden.has(name); });
    for (const [name, group] of Object.entries(scene.marks.layers)) group.visible = !hidden.has(name);
    scene.labels.visible = !hidden.has("labels");
    scene.view.dirty();
  };
  const player = new Player(data, (k) => {
    const frame = data.frames[k];
    fillContacts(document.getElementById("contacts"), data, frame);
    torques.show(frame);
    for (const place of document.querySelectorAll("h2 .when")) place.textContent = data.path ? `– ${frame.label}` : "";
    document.getElementById("when").textContent = data.path ? frame.label : "";
    if (scene.view) show(scene, data, frame, apply);
  });
  fillLegend(document.getElementById("legend"), data.legend, (layer, on) => {
    hidden[on ? "delete" : "add"](layer);
    apply();
  });
  const asked = Number(location.hash.slice(1)), last = data.frames.length - 1;  // page.html#12 begins at frame 12
  const first = asked >= 1 && asked <= last ? Math.floor(asked) : data.first;
  player.go(first);
  scene.solids = new Solids(data.parts, await unpacked(data.packed));
  scene.labels = new Labels(document.getElementById("labels"), document.getElementById("leaders"));
  scene.view = new View(document.getElementById("canvas"), data.view);
  scene.view.scene.add(scene.solids.root, scene.marks.root);
  scene.view.onframe = (project, w, h) => scene.labels.place(project, w, h);
  player.go(first);
  fit(scene, scene.marks.root.children);
  document.getElementById("reset").addEventListener("click", () => scene.view.reset());
  const glassy = document.getElementById("glass");
  glassy.addEventListener("click", () => {
    const on = glassy.getAttribute("aria-pressed") !== "true";
    glassy.setAttribute("aria-pressed", on);
    scene.solids.seeThrough(on);
    scene.view.dirty();
  });
  if (data.escape) flight(scene, data, () => player.go(0));
  scene.view.draw();
  examine(scene.view.renderer);
}

/** One frame: solids, marks, labels. */
function show(scene, data, frame, apply) {
  scene.solids.show(frame);
  scene.marks.show(frame);
  const centre = new THREE.Vector3(...frame.load.at);
  const items = frame.contacts.map((c, i) => ({
    at: new THREE.Vector3(...c.at), away: centre, name: data.contacts[i].name, says: c.says, colour: data.colours[c.state],
  }));
  if (frame.load.says) {
    const tip = centre.clone().addScaledVector(new THREE.Vector3(...frame.load.force), data.perNewton);
    items.push({ at: tip, away: centre, name: "load", says: frame.load.says, colour: data.colours.load });
  }
  scene.labels.show(items);
  apply();
}

/** The button that moves the object the way it escapes, and back. */
function flight({ solids, view }, { escape }, start) {
  const button = document.getElementById("flee"), about = new THREE.Vector3(...escape.at);
  const move = new THREE.Vector3(...escape.move), turn = new THREE.Vector3(...escape.turn), angle = turn.length();
  button.hidden = false;
  button.addEventListener("click", () => {
    start();
    const began = performance.now();
    const step = (now) => {
      const share = Math.min((now - began) / 1600, 1), way = share < 1 ? share * share * (3 - 2 * share) : 0;
      const rotation = new THREE.Quaternion().setFromAxisAngle(turn.clone().normalize(), way * angle);
      solids.object.quaternion.copy(rotation);
      solids.object.position.copy(about).addScaledVector(move, way).sub(about.clone().applyQuaternion(rotation));
      view.dirty();
      if (share < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  });
}
