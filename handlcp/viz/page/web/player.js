/* Player: the slider through the steps of a loading, its stages and events. */

const PERIOD = 90;  // milliseconds a step, longer where there are few

class Player {
  /** show(k) : draw frame k. */
  constructor(data, show) {
    this.data = data;
    this.path = data.path;
    this.showFrame = show;
    this.at = 0;
    this.timer = 0;
    if (!this.path) return;
    this.last = data.frames.length - 1;
    this.slider = document.getElementById("slider");
    this.button = document.getElementById("play");
    document.getElementById("bar").hidden = false;
    document.getElementById("modes").hidden = this.path.first === 0;
    this.slider.max = this.last - this.path.first;
    this.slider.addEventListener("input", () => { this.stop(); this.go(this.path.first + Number(this.slider.value)); });
    this.button.addEventListener("click", () => this.timer ? this.stop() : this.play());
    document.getElementById("once").addEventListener("click", () => { this.stop(); this.go(0); });
    document.getElementById("steps").addEventListener("click", () => this.play());
    this.ticks(document.getElementById("ticks"));
    this.list(document.getElementById("events"));
  }

  share(frame) {
    return (frame - this.path.first) / Math.max(this.last - this.path.first, 1);
  }

  /** Stages below the slider, events on it. */
  ticks(box) {
    let from = this.path.first;
    for (const { name, end } of this.path.stages) {
      const tick = element("span", name);
      if (end > from) tick.style.left = `${100 * this.share((from + end) / 2)}%`;
      else tick.hidden = true;
      box.append(tick);
      from = Math.max(from, end);
    }
    for (const { frame, says } of this.path.events) {
      const mark = element("i");
      mark.style.left = `calc(8px + ${this.share(frame)} * (100% - 16px))`;
      mark.title = says;
      box.append(mark);
    }
  }

  list(box) {
    document.getElementById("happens").hidden = !this.path.events.length;
    this.rows = this.path.events.map(({ frame, where, says, lost }) => {
      const row = element("li"), button = element("button", "", lost ? "lost" : "");
      button.type = "button";
      button.append(element("span", where), element("span", says));
      button.addEventListener("click", () => { this.stop(); this.go(frame); });
      row.append(button);
      box.append(row);
      return { frame, button };
    });
  }

  go(frame) {
    this.at = frame;
    if (this.path) {
      const once = frame < this.path.first;
      document.getElementById("once").setAttribute("aria-pressed", once);
      document.getElementById("steps").setAttribute("aria-pressed", !once);
      document.getElementById("player").style.opacity = once ? 0.45 : 1;
      this.slider.value = once ? this.last - this.path.first : frame - this.path.first;
      for (const { frame: at, button } of this.rows) button.classList.toggle("now", at === frame);
    }
    this.showFrame(frame);
  }

  play() {
    const period = Math.max(PERIOD, Math.min(350, 4000 / (this.last - this.path.first + 1)));
    this.stop();
    this.go(this.at < this.path.first || this.at === this.last ? this.path.first : this.at);
    this.button.textContent = "❚❚";
    this.button.setAttribute("aria-label", "Stop");
    this.timer = setInterval(() => this.at < this.last ? this.go(this.at + 1) : this.stop(), period);
  }

  stop() {
    if (this.timer) clearInterval(this.timer);
    this.timer = 0;
    if (this.button) this.button.textContent = "▶";
    if (this.button) this.button.setAttribute("aria-label", "Play");
  }
}
