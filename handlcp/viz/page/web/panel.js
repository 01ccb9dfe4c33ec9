/* Panel: legend with switches, table of contacts, joint torques. */

function element(name, text = "", cls = "") {
  const made = document.createElement(name);
  made.textContent = text;
  if (cls) made.className = cls;
  return made;
}

/** An element with a name that may break behind each "_"; what stands in it is text. */
function named(kind, name) {
  const made = element(kind);
  for (const [k, piece] of name.split(/(?<=_)/).entries()) made.append(...(k ? [element("wbr")] : []), piece);
  return made;
}

/** A switch for each layer, off for those that are hidden; toggle(layer, on) is called. */
function fillLegend(list, lines, toggle, hidden = new Set()) {
  const known = new Map();
  for (const [layer, kind, colour, text] of lines) {
    const row = element("li"), label = element("label"), box = element("input");
    box.type = "checkbox";
    box.checked = !hidden.has(layer);
    label.classList.toggle("off", !box.checked);
    const css = Array.isArray(colour) ? `rgb(${colour.map((c) => Math.round(255 * c)).join(",")})` : colour;
    label.append(box, symbol(kind, css), element("span", text));
    row.append(label);
    list.append(row);
    known.set(layer, [...(known.get(layer) || []), { box, label }]);
    box.addEventListener("change", () => {
      for (const other of known.get(layer)) {  // lines of one layer go together
        other.box.checked = box.checked;
        other.label.classList.toggle("off", !box.checked);
      }
      toggle(layer, box.checked);
    });
  }
}

const SYMBOLS = {
  patch: '<rect x="2" y="3" width="22" height="12" rx="2" fill="currentColor" stroke="#555" stroke-width=".6"/>',
  cone: '<path d="M13 17 L4 4 A9 2.6 0 0 1 22 4 Z" fill="currentColor" fill-opacity=".25" stroke="currentColor"/>',
  arrow: '<path d="M1 7.5 H16 V3.5 L25 9 L16 14.5 V10.5 H1 Z" fill="currentColor"/>',
  dashed: '<path d="M1 9 H17" stroke="currentColor" stroke-width="3" stroke-dasharray="5 3"/><path d="M16 4 L25 9 L16 14 Z" fill="currentColor"/>',
  dot: '<circle cx="13" cy="9" r="4.5" fill="currentColor"/>',
  turn: '<path d="M20 9 A7 7 0 1 0 13 16" fill="none" stroke="currentColor" stroke-width="2.4"/><path d="M12 12 L19 16 L12 20 Z" fill="currentColor" transform="translate(0 -1.5)"/>',
  text: '<text x="13" y="14" font-size="14" text-anchor="middle" fill="currentColor">Aa</text>',
};

function symbol(kind, colour) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 26 18");
  svg.style.color = colour;
  svg.innerHTML = SYMBOLS[kind];
  return svg;
}

function fillContacts(table, data, frame) {
  const head = element("tr"), shown = data.columns;
  head.append(...shown.map((title) => element("th", title)));
  const rows = frame.contacts.map((contact, i) => {
    const row = element("tr");
    row.append(named("td", data.contacts[i].name), ...contact.row.map((text, k) => element("td", text, k ? "" : contact.state)));
    return row;
  });
  table.replaceChildren(head, ...rows);
}

/** Bars of torque over limit, those of the frame shown first in falling order; in N·m where no limit is known. */
class Torques {
  constructor(box, section, data) {
    this.data = data;
    section.hidden = !data.joints.length;
    const known = data.frames.filter((f) => f.torques), first = data.frames[data.first].torques;
    const most = data.joints.map((joint, j) => Math.max(0, ...known.map((f) => share(f.torques[j], joint.limit))));
    const at = first ? first.map((t, j) => share(t, data.joints[j].limit)) : most;
    this.order = data.joints.map((_, j) => j).sort((a, b) => at[b] - at[a] || most[b] - most[a]);
    this.full = Math.max(1, ...most);
    this.largest = Math.max(0, ...known.flatMap((f) => f.torques.map(Math.abs)));
    this.rows = this.order.map((j) => {
      const row = element("div"), words = element("div"), gauge = element("div", "", "gauge"), bar = element("i");
      const text = element("span");
      words.append(named("span", data.joints[j].name), text);
      gauge.append(bar);
      row.append(words, gauge);
      box.append(row);
      return { row, text, bar, gauge, j };
    });
  }

  show(frame) {
    const shares = frame.torques ? frame.torques.map((t, j) => share(t, this.data.joints[j].limit)) : [];
    const most = Math.max(0, ...shares);
    for (const { row, text, bar, gauge, j } of this.rows) {
      const { limit } = this.data.joints[j], s = shares[j] ?? 0;
      gauge.hidden = limit === null;
      bar.style.width = `${100 * s / this.full}%`;
      const value = frame.torques ? rounded(frame.torques[j], limit || this.largest) : "–";
      text.textContent = limit === null ? `${value} N·m, limit unknown` : `${value} of ${number(limit)} N·m, ${Math.round(100 * s)} %`;
      row.className = "joint" + (s > 1 ? " over" : s > 0 && s === most ? " most" : "");
    }
  }
}

function share(torque, limit) {
  return limit === null ? 0 : limit > 0 ? Math.abs(torque) / limit : 0;
}

/** With as many decimals as a thousandth of a scale needs: the limit, or the largest torque. */
function rounded(value, scale) {
  const text = value.toFixed(scale > 0 ? Math.min(9, Math.max(0, Math.round(3 - Math.log10(scale)))) : 3);
  return Number(text) ? text : "0";
}

function number(value) {
  return Math.abs(value) < 5e-5 ? "0" : String(Number(value.toPrecision(3)));
}
