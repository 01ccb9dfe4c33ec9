/* Chart: all designs as points; those on the front that have a hand can be clicked. */

const NS = "http://www.w3.org/2000/svg";

function drawn(name, attributes, text) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** Round numbers from low to high, about so many. */
function ticks(low, high, count) {
  const rough = (high - low || Math.abs(high) || 1) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((k) => k * power >= rough);
  return Array.from({ length: Math.floor(high / step + 1e-9) - Math.ceil(low / step - 1e-9) + 1 }, (_, k) => (Math.ceil(low / step - 1e-9) + k) * step);
}

class Chart {
  constructor(svg, { points, axes, designs }, choose) {
    Object.assign(this, { svg, points, axes, choose, shown: new Set(designs.map((d) => d.design)), now: null });
    new ResizeObserver(() => this.draw()).observe(svg);
  }

  draw() {
    const { svg, points } = this, w = svg.clientWidth, h = svg.clientHeight, box = [46, 8, w - 10, h - 40];
    if (!w || !h) return;
    svg.setAttribute("viewBox", `0 0 ${w} ${h}`);
    const [px, a, b] = this.scale(points.x, box[0], box[2]), [py, c, d] = this.scale(points.y, box[3], box[1]);
    const text = (x, y, said, more) => drawn("text", { x, y, ...more }, said);
    const made = [];
    for (const t of ticks(a, b, 5)) {
      made.push(drawn("line", { class: "grid", x1: px(t), x2: px(t), y1: box[1], y2: box[3] }), text(px(t), box[3] + 14, number(t), { "text-anchor": "middle" }));
    }
    for (const t of ticks(c, d, 5)) {
      made.push(drawn("line", { class: "grid", x1: box[0], x2: box[2], y1: py(t), y2: py(t) }), text(box[0] - 5, py(t) + 4, number(t), { "text-anchor": "end" }));
    }
    made.push(text((box[0] + box[2]) / 2, h - 6, this.axes[0], { "text-anchor": "middle" }));
    made.push(text(-(box[1] + box[3]) / 2, 11, this.axes[1], { "text-anchor": "middle", transform: "rotate(-90)" }));
    this.dots = new Map();
    for (let k = points.x.length - 1; k >= 0; k--) {
      const design = points.design[k], front = k < points.front, shown = front && this.shown.has(design);
      const dot = drawn("circle", { class: shown ? "front shown" : front ? "front" : "other", cx: px(points.x[k]), cy: py(points.y[k]), r: shown ? 5 : front ? 3.5 : 2 });
      if (shown) {
        dot.append(drawn("title", {}, `design ${design}`));
        dot.setAttribute("tabindex", "0");
        dot.addEventListener("click", () => this.choose(design));
        dot.addEventListener("keydown", (e) => { if (e.key === "Enter" || e.key === " ") { e.preventDefault(); this.choose(design); } });
        this.dots.set(design, dot);
      }
      made.push(dot);
    }
    svg.replaceChildren(...made);
    if (this.now !== null) this.mark(this.now);
  }

  /** Of numbers along a line of the screen: the place of each, and the ends with some room. */
  scale(values, from, to) {
    const low = Math.min(...values), high = Math.max(...values), room = 0.05 * (high - low) || Math.abs(high) || 1;
    const [a, b] = [low - room, high + room];
    return [(v) => from + (to - from) * (v - a) / (b - a), a, b];
  }

  mark(design) {
    this.dots?.get(this.now)?.classList.remove("now");
    this.now = design;
    this.dots?.get(design)?.classList.add("now");
  }
}
