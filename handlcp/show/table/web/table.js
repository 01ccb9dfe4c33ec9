"use strict";
(() => {
  const { keys, rows } = JSON.parse(document.getElementById("data").textContent);
  const at = Object.fromEntries(keys.map((key, k) => [key, k]));
  const find = (id) => document.getElementById(id);
  const digits = (x, n = 3) => x === null || x === undefined ? "" : Number(x.toPrecision(n)).toString();
  const open = (r, x) => digits(x) + (r[at.left_out] && digits(x) ? " ?" : ""); // an end that was not all looked for
  const hint = (r, said) => [said, r[at.left_out] ? `no time for: ${r[at.left_out]}` : ""].filter((x) => x).join("; ");
  const short = (text) => text.length > 110 ? `${text.slice(0, 108)}…` : text;
  const percent = (x) => x === null || x === undefined ? "" : `${Math.round(100 * x)} %`;
  const word = (r) => (r[at.mujoco] || "").split(/:| at /)[0]; // when it was lost, or why not asked: when pointed at
  const classes = { "HELD": "good", "OVER LIMIT": "doubt", "UNDECIDED": "doubt", "NOT HELD": "bad" };

  // Columns: head, what is sorted by, what is shown, whether it is words, what is told when it is pointed at
  const columns = [
    ["hand", "hand", (r) => r[at.hand], true],
    ["object", "object", (r) => r[at.object].replace(/^\d+(-a)?_/, "").replaceAll("_", " "), true, (r) => r[at.object]],
    ["grasp", "kind", (r) => r[at.kind], true],
    ["verdict", "verdict", (r) => r[at.verdict], true],
    ["payload\nkg", "payload_kg", (r) => digits(r[at.payload_kg]), false],
    ["from\nkg", "payload_low_kg", (r) => open(r, r[at.payload_low_kg]), false, (r) => hint(r, r[at.low_with])],
    ["to\nkg", "payload_high_kg", (r) => open(r, r[at.payload_high_kg]), false, (r) => hint(r, r[at.high_with])],
    ["motors", "motors_used", (r) => percent(r[at.motors_used]), false],
    ["grip\nN", "grip_N", (r) => digits(r[at.grip_N]), false],
    ["chance", "chance", (r) => percent(r[at.chance]), false],
    ["MuJoCo", "mujoco", word, true, (r) => r[at.mujoco] === word(r) ? "" : r[at.mujoco]],
    ["s", "seconds", (r) => digits(r[at.seconds], 2), false],
    ["gives out first, or why there is none", "gives_out", (r) => short(r[at.gives_out] || r[at.reason] || ""), true,
      (r) => hint(r, r[at.gives_out] || r[at.reason] || "")],
  ];
  let by = "payload_kg", down = true;

  const choices = (id, values) => {
    const select = find(id);
    select.append(new Option("all", ""), ...values.map((value) => new Option(value, value)));
    select.addEventListener("change", show);
  };
  const known = (key) => [...new Set(rows.map((r) => r[at[key]]).filter((x) => x))];

  function kept(r) {
    const is = (id) => !find(id).value || r[at[id]] === find(id).value;
    const mujoco = find("mujoco").value;
    const asked = find("object").value.trim().toLowerCase().replaceAll(" ", "_");
    return is("hand") && is("kind") && is("verdict") && (!mujoco || word(r) === mujoco)
      && (!asked || r[at.object].toLowerCase().replaceAll(" ", "_").includes(asked))
      && (!find("best").checked || r[at.best]);
  }

  function order(a, b) {
    const [x, y] = [a[at[by]], b[at[by]]];
    const none = (v) => v === null || v === undefined || v === "";
    if (none(x) || none(y)) return none(x) - none(y); // what has no value comes last, both ways
    const way = typeof x === "number" ? x - y : String(x).localeCompare(String(y));
    return down ? -way : way;
  }

  function cell(r, [, key, text, words, told]) {
    const td = document.createElement("td");
    td.textContent = text(r);
    if (words) td.classList.add("words");
    if (key === "gives_out") td.classList.add("wide-words");
    if (key === "verdict") td.classList.add(classes[r[at.verdict]] || "none");
    if (key === "mujoco" && r[at.mujoco]) td.classList.add({ HELD: "good", LOST: "bad" }[word(r)] || "none");
    const title = told ? told(r) : "";
    if (title) td.title = title;
    return td;
  }

  function show() {
    const some = rows.filter(kept).sort(order);
    find("count").textContent = `${some.length} of ${rows.length} rows`;
    find("rows").tBodies[0].replaceChildren(...some.map((r) => {
      const tr = document.createElement("tr");
      tr.append(...columns.map((column) => cell(r, column)));
      return tr;
    }));
    for (const th of find("rows").tHead.rows[0].cells) {
      th.removeAttribute("aria-sort");
      if (th.dataset.key === by) th.setAttribute("aria-sort", down ? "descending" : "ascending");
    }
  }

  const head = document.createElement("tr");
  for (const [name, key, , words] of columns) {
    const th = document.createElement("th"), button = document.createElement("button");
    th.dataset.key = key;
    if (words) th.classList.add("words");
    button.type = "button";
    button.textContent = name;
    button.addEventListener("click", () => {
      down = by === key ? !down : !words;
      by = key;
      show();
    });
    th.append(button);
    head.append(th);
  }
  find("rows").tHead.append(head);
  for (const id of ["hand", "kind", "verdict"]) choices(id, known(id));
  choices("mujoco", [...new Set(rows.map(word).filter((x) => x))]);
  for (const id of ["object", "best"]) find(id).addEventListener("input", show);
  document.querySelector("form").addEventListener("submit", (event) => event.preventDefault());
  for (const button of document.querySelectorAll("[data-hand]")) {
    button.addEventListener("click", () => {
      find("hand").value = find("hand").value === button.dataset.hand ? "" : button.dataset.hand;
      show();
      find("rows").scrollIntoView({ behavior: "smooth", block: "start" });
    });
  }
  show();
})();
