/* Page of an envelope: reads its data, draws hand and surface, and looks whether anything came of it. */

SYMBOLS.wire = '<path d="M2 14 Q13 0 24 14 M2 8 Q13 18 24 8" fill="none" stroke="currentColor" stroke-width="1.2"/>';

async function open() {
  const data = JSON.parse(document.getElementById("data").textContent), { surface } = data, hidden = new Set();
  fillCauses(document.getElementById("causes"), surface);
  const scene = {};
  const apply = () => {
    if (!scene.view) return;
    for (const [name, groups] of Object.entries(scene.solids.layers)) groups.forEach((g) => { g.visible = !hidden.has(name); });
    for (const [name, mesh] of Object.entries(scene.ball.layers)) mesh.visible = !hidden.has(["axes", "spot"].includes(name) ? "labels" : name);
    scene.labels.visible = !hidden.has("labels");
    scene.view.dirty();
  };
  fillLegend(document.getElementById("legend"), data.legend, (layer, on) => {
    hidden[on ? "delete" : "add"](layer);
    apply();
  });
  scene.solids = new Solids(data.parts, await unpacked(data.packed));
  scene.solids.show(data.frame);
  scene.ball = new Ball(surface);
  scene.labels = new Labels(document.getElementById("labels"), document.getElementById("leaders"));
  scene.view = new View(document.getElementById("canvas"), data.view);
  scene.view.scene.add(scene.solids.root, scene.ball.root);
  scene.view.onframe = (project, w, h) => scene.labels.place(project, w, h);
  scene.labels.show(marks(surface));
  fit(scene, [...scene.ball.meshes, scene.ball.layers.axes]);
  new Reader(scene.view, scene.ball, surface);
  document.getElementById("reset").addEventListener("click", () => scene.view.reset());
  for (const [id, thing] of [["glass", scene.solids], ["clear", scene.ball]]) {
    const button = document.getElementById(id);
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", on);
      thing.seeThrough(on);
      scene.view.dirty();
    });
  }
  scene.view.draw();
  examine(scene.view.renderer);
}

/** Labels of the weakest direction and of the axes. */
function marks({ centre, weakest, reach }) {
  const middle = new THREE.Vector3(...centre), at = (p) => new THREE.Vector3(...p).add(middle);
  const axes = ["x", "y", "z"].flatMap((name, k) => ["+", "-"].map((sign) => {
    const end = [0, 0, 0];
    end[k] = (sign === "+" ? 1.2 : -1.2) * reach;
    return { at: at(end), away: middle, name: sign + name, says: "", colour: "#5f5f5f" };
  }));
  return [{ at: at(weakest.at), away: middle, name: "weakest", says: weakest.says, colour: "#c8102e" }, ...axes];
}

function fillCauses(table, { columns, rows, row_colours }) {
  const head = element("tr");
  head.append(...columns.map((title) => element("th", title)));
  table.replaceChildren(head, ...rows.map((cells, i) => {
    const row = element("tr");
    row.append(...cells.map((text, k) => k ? element("td", text) : named("td", text)));
    const dot = element("i");
    dot.style.background = row_colours[i];
    row.firstChild.prepend(dot);
    return row;
  }));
}
