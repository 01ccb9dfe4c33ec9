/* Labels: names and values beside their points, apart from each other, with a line to the point. */

class Labels {
  constructor(box, lines) {
    this.box = box;
    this.lines = lines;
    this.items = [];
    this.visible = true;
  }

  /** items : { at, away, name, says, colour }; at : a point in space, away : one that the label keeps clear of. */
  show(items) {
    this.box.replaceChildren();
    this.lines.replaceChildren();
    this.items = items.map((item) => {
      const label = document.createElement("div"), name = document.createElement("b"), says = document.createElement("span");
      label.className = "label";
      label.style.color = item.colour;
      name.textContent = item.name;
      says.textContent = item.says;
      label.append(name, says);
      this.box.append(label);
      const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
      this.lines.append(line);
      return { ...item, label, line, w: label.offsetWidth, h: label.offsetHeight };
    });
  }

  /** Put all of them where the view is now. project : a point in space to pixels. */
  place(project, width, height) {
    this.box.hidden = !this.visible;
    this.lines.style.display = this.visible ? "" : "none";
    if (!this.visible || !this.items.length) return;
    const points = this.items.map((item) => project(item.at));
    const middle = points.reduce((sum, p) => [sum[0] + p[0] / points.length, sum[1] + p[1] / points.length], [0, 0]);
    const boxes = this.items.map((item, k) => {
      const [px, py] = points[k], [ax, ay] = project(item.away);
      let dx = px - middle[0] + 0.6 * (px - ax), dy = py - middle[1] + 0.6 * (py - ay);
      const far = Math.hypot(dx, dy) || 1;
      [dx, dy] = far > 1 ? [dx / far, dy / far] : [0, -1];
      const reach = 34, x = px + reach * dx + (dx < 0 ? -item.w : 0), y = py + reach * dy - item.h / 2;
      return { x, y, w: item.w, h: item.h };
    });
    apart(boxes, width, height);
    boxes.forEach((b, k) => {
      const { label, line } = this.items[k], [px, py] = points[k];
      label.style.transform = `translate(${Math.round(b.x)}px, ${Math.round(b.y)}px)`;
      const x = Math.min(Math.max(px, b.x), b.x + b.w), y = Math.min(Math.max(py, b.y), b.y + b.h);
      for (const [key, value] of Object.entries({ x1: px, y1: py, x2: x, y2: y })) line.setAttribute(key, value.toFixed(1));
    });
  }
}

/** Move boxes until none covers another, as little as that takes, and keep them inside. */
function apart(boxes, width, height) {
  const gap = 4;
  for (let round = 0; round < 60; round++) {
    let moved = false;
    for (let i = 0; i < boxes.length; i++) {
      for (let j = i + 1; j < boxes.length; j++) {
        const a = boxes[i], b = boxes[j];
        const across = Math.min(a.x + a.w, b.x + b.w) - Math.max(a.x, b.x) + gap;
        const along = Math.min(a.y + a.h, b.y + b.h) - Math.max(a.y, b.y) + gap;
        if (across <= 0 || along <= 0) continue;
        const down = a.y + a.h / 2 <= b.y + b.h / 2 ? 1 : -1;
        a.y -= down * along / 2;
        b.y += down * along / 2;
        moved = true;
      }
    }
    for (const b of boxes) {
      b.x = Math.max(gap, Math.min(width - b.w - gap, b.x));
      b.y = Math.max(gap + 40, Math.min(height - b.h - gap, b.y));
    }
    if (!moved) break;
  }
}
