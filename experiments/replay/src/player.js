import { decodeReplay } from './decode.js';
import { METRES_PER_NEWTON, Stage } from './stage.js';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
const CHART = { width: 600, height: 70 };

function element(name, attributes = {}, children = []) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in made) made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

function svg(name, attributes) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

const json = (id) => JSON.parse(document.getElementById(id).textContent);

/** Chooses a trial, plays it, scrubs its time. */
export class Player {
  constructor(root) {
    this.index = json('replay-index');
    this.build(root);
    this.stage = new Stage(this.canvas);
    this.playing = false;
    new ResizeObserver(() => this.fit()).observe(this.canvas);
    this.load(0);
  }

  build(root) {
    this.trials = element('select', { ariaLabel: 'trial' },
      this.index.map(({ label }) => element('option', { textContent: label })));
    this.canvas = element('canvas', { tabIndex: 0, ariaLabel: '3-D view' });
    this.button = element('button', { type: 'button' });
    this.slider = element('input', { type: 'range', min: 0, step: 'any', ariaLabel: 'time' });
    this.speeds = element('select', { ariaLabel: 'speed' },
      SPEEDS.map((speed) => element('option', { value: speed, textContent: `${speed} x` })));
    this.speeds.value = 1;
    this.forces = element('input', { type: 'checkbox', checked: true });
    this.clock = element('output');
    this.note = element('p', { className: 'note' });
    this.chart = svg('svg', {
      viewBox: `0 0 ${CHART.width} ${CHART.height}`, preserveAspectRatio: 'none',
      role: 'img', 'aria-label': 'contact force on the robot over time',
    });
    root.replaceChildren(
      element('p', {}, [element('label', {}, ['Trial ', this.trials])]),
      this.canvas,
      element('div', { className: 'controls' },
        [this.button, this.slider, this.speeds, this.clock]),
      this.chart,
      this.note,
      element('p', {}, [
        element('label', {}, [this.forces, ' contact forces as arrows']),
        `, 0.1 m for ${0.1 / METRES_PER_NEWTON} N: red on the robot, blue between objects and cell.` +
        ' Drag to turn, scroll or pinch to zoom, space to play.',
      ]),
    );
    this.trials.addEventListener('change', () => this.load(this.trials.selectedIndex));
    this.button.addEventListener('click', () => this.play(!this.playing));
    this.slider.addEventListener('input', () => this.seek(Number(this.slider.value)));
    this.forces.addEventListener('change', () => {
      this.stage.showForces = this.forces.checked;
      this.seek(this.frame);
    });
    this.chart.addEventListener('click', (event) => {
      this.seek((event.offsetX / this.chart.clientWidth) * (this.replay.frames - 1));
    });
    this.canvas.addEventListener('keydown', (event) => {
      if (event.key !== ' ') return;
      event.preventDefault();
      this.play(!this.playing);
    });
  }

  /** Follows a link such as #replay-3 to its trial. */
  choose(hash) {
    const trial = /^#replay-(\d+)$/.exec(hash);
    if (!trial || trial[1] >= this.index.length) return;
    this.trials.selectedIndex = Number(trial[1]);
    this.load(this.trials.selectedIndex);
    this.trials.scrollIntoView();
  }

  load(trial) {
    const { data, scene } = this.index[trial];
    this.replay = decodeReplay(json(data));
    this.play(false);
    this.slider.max = this.replay.frames - 1;
    this.stage.load(json(scene), this.replay);
    this.drawChart();
    this.seek(0);
    this.fit();
  }

  play(on) {
    this.playing = on;
    this.button.textContent = on ? 'Pause' : 'Play';
    if (!on) return;
    if (this.frame >= this.replay.frames - 1) this.seek(0);
    let last = performance.now();
    const advance = (now) => {
      if (!this.playing) return;
      const frames = ((now - last) / 1000 / this.replay.interval) * Number(this.speeds.value);
      last = now;
      this.seek(this.frame + Math.max(frames, 0));
      if (this.frame >= this.replay.frames - 1) this.play(false);
      else requestAnimationFrame(advance);
    };
    requestAnimationFrame(advance);
  }

  seek(frame) {
    const { frames, interval, start, peaks, notes } = this.replay;
    this.frame = Math.min(Math.max(frame, 0), frames - 1);
    this.slider.value = this.frame;
    this.stage.show(this.frame);
    const time = start + this.frame * interval;
    const force = peaks[Math.round(this.frame)];
    this.clock.textContent = `${time.toFixed(2)} s, ${force.toFixed(1)} N on the robot`;
    const past = notes.filter((note) => note.time <= time);
    this.note.textContent = past.length > 0 ? past[past.length - 1].text : '';
    const x = (this.frame / Math.max(frames - 1, 1)) * CHART.width;
    this.cursor.setAttribute('x1', x);
    this.cursor.setAttribute('x2', x);
  }

  /** Contact force on the robot over time; ticks where something is noted. */
  drawChart() {
    const { peaks, frames, notes, start, interval } = this.replay;
    const highest = Math.max(10, ...peaks);
    const x = (frame) => (frame / Math.max(frames - 1, 1)) * CHART.width;
    const y = (force) => CHART.height - (force / highest) * (CHART.height - 4);
    const path = peaks.map((force, i) => `${x(i).toFixed(1)},${y(force).toFixed(1)}`).join(' ');
    this.cursor = svg('line', { y1: 0, y2: CHART.height, class: 'cursor' });
    const ticks = notes.map(({ time }) => {
      const at = x((time - start) / interval);
      return svg('line', { x1: at, x2: at, y1: 0, y2: 6, class: 'tick' });
    });
    const line = svg('polyline', { points: path, class: 'force' });
    const title = svg('title', {});
    title.textContent = `Contact force on the robot, up to ${highest.toFixed(0)} N`;
    this.chart.replaceChildren(title, line, ...ticks, this.cursor);
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width > 0 && height > 0) this.stage.resize(width, height);
  }
}
