/* Page of a sweep: reads its data, shows the hand of the design that is chosen, and looks whether anything came of it. */

async function open() {
  const data = JSON.parse(document.getElementById("data").textContent), hidden = new Set();
  const scene = { view: null, solids: null, marks: null, labels: null };
  const state = { at: 0, buffer: null, glass: false };
  const apply = () => {
    if (!scene.view) return;
    for (const [name, groups] of Object.entries(scene.solids.layers)) groups.forEach((g) => { g.visible = !hidden.has(name); });
    for (const [name, group] of Object.entries(scene.marks.layers)) group.visible = !hidden.has(name);
    scene.labels.visible = !hidden.has("labels");
    scene.view.dirty();
  };
  const choose = (k) => {
    state.at = k;
    const design = data.designs[k];
    tell(design);
    chart.mark(design.design);
    const legend = document.getElementById("legend");
    legend.replaceChildren();
    fillLegend(legend, design.legend, (layer, on) => {
      hidden[on ? "delete" : "add"](layer);
      apply();
    }, hidden);
    if (scene.view) place(scene, state, design, apply);
  };
  const at = (number) => data.designs.findIndex((d) => d.design === number);
  const chart = new Chart(document.getElementById("chart"), data, (number) => { location.hash = number; });
  const asked = at(Number(location.hash.slice(1)));  // page.html#12 begins with design 12
  chart.draw();
  choose(Math.max(asked, 0));
  state.buffer = await unpacked(data.packed);
  scene.labels = new Labels(document.getElementById("labels"), document.getElementById("leaders"));
  scene.view = new View(document.getElementById("canvas"), data.designs[state.at].view);
  scene.view.onframe = (project, w, h) => scene.labels.place(project, w, h);
  choose(state.at);
  fit(scene, scene.marks.root.children);  // once: the next hand is seen from the same side, to the same scale
  window.addEventListener("hashchange", () => { const k = at(Number(location.hash.slice(1))); if (k >= 0) choose(k); });
  for (const [id, step] of [["before", -1], ["after", 1]]) {
    document.getElementById(id).addEventListener("click", () => {
      location.hash = data.designs[(state.at + step + data.designs.length) % data.designs.length].design;
    });
  }
  document.getElementById("reset").addEventListener("click", () => scene.view.reset());
  const glassy = document.getElementById("glass");
  glassy.addEventListener("click", () => {
    state.glass = !state.glass;
    glassy.setAttribute("aria-pressed", state.glass);
    scene.solids.seeThrough(state.glass);
    scene.view.dirty();
  });
  scene.view.draw();
  examine(scene.view.renderer);
}

/** The hand, object and forces of a design in place of those before. */
function place(scene, state, design, apply) {
  if (scene.solids) {
    for (const root of [scene.solids.root, scene.marks.root]) scene.view.scene.remove(root);
    scene.solids.root.traverse((thing) => { thing.geometry?.dispose(); thing.material?.dispose(); });
  }
  const frame = design.frames[0], centre = new THREE.Vector3(...frame.load.at);
  scene.solids = new Solids(design.parts, state.buffer);
  scene.marks = new Marks(design);
  scene.solids.show(frame);
  scene.solids.seeThrough(state.glass);
  scene.marks.show(frame);
  scene.view.scene.add(scene.solids.root, scene.marks.root);
  scene.labels.show(frame.contacts.map((c, i) => ({
    at: new THREE.Vector3(...c.at), away: centre, name: design.contacts[i].name, says: c.says, colour: design.colours[c.state],
  })));
  apply();
}

/** Its numbers. */
function tell(design) {
  document.getElementById("number").textContent = design.design;
  const say = (value) => typeof value === "number" ? String(Number(value.toPrecision(4))) : String(value);
  const line = ([name, value], first) => {
    const row = element("tr", "", first ? "first" : "");
    row.append(element("td", name), element("td", say(value)));
    return row;
  };
  document.getElementById("numbers").replaceChildren(
    ...design.parameters.map((pair) => line(pair, false)), ...design.numbers.map((pair, k) => line(pair, k === 0)));
  const head = element("tr");
  head.append(...["object", "verdict", "times\nits loads", "payload\nkg"].map((text) => element("th", text)));
  document.getElementById("objects").replaceChildren(head, ...design.objects.map(([name, word, payload, factor, more]) => {
    const row = element("tr");
    row.append(named("td", name), element("td", word), ...[factor, payload].map((value) => element("td", value === null ? "any" : (more ? "≥ " : "") + say(value))));
    return row;
  }));
  fillContacts(document.getElementById("contacts"), design, design.frames[0]);
  for (const where of document.querySelectorAll("h2 .when")) where.textContent = `– ${design.object}, ${design.word}`;
}
