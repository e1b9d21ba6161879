// The player below "Replays in 3-D" of a report: see experiments/report_replays.cpp for its page.

import { Player } from './player.js';

const root = document.getElementById('replay');
try {
  const player = new Player(root);
  player.choose(location.hash);
  window.addEventListener('hashchange', () => player.choose(location.hash));
  root.dataset.state = 'ready';
} catch (error) {
  root.dataset.state = 'failed';
  root.textContent = `The 3-D view needs WebGL, which this browser does not offer (${error.message}).`;
}
