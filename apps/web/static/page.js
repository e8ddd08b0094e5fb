// Starts the viewer on the page's canvas, or says why it cannot.
//
// The page's address may have ?scene=…&setup=… (addresses of files, as the page sees them), &camera=NAME, &exposure=EV and
// &resolution=SHARE; without them it is what the body's data attributes say.

import init, { start } from './probelight_web.js';

const NEEDS_WEBGPU = `
  <p><strong>This page needs WebGPU, which this browser does not have.</strong></p>
  <p>Chrome and Edge have it from version 113, Safari from 26, Firefox from 141 on Windows and 145 on macOS; on Linux it
  may have to be <a href="https://github.com/gpuweb/gpuweb/wiki/Implementation-Status">switched on</a>. A page must come
  from https:// or from this computer.</p>`;

const text = document.getElementById('text');

/** Shows an error; it may hold what others wrote, so it is text. */
function fail(error) {
  text.innerHTML = '<p><strong>Probelight cannot start.</strong></p><p></p>';
  text.lastElementChild.textContent = error?.message ?? String(error);
}

async function main() {
  if (!navigator.gpu) {
    text.innerHTML = NEEDS_WEBGPU;
    return;
  }
  const address = new URLSearchParams(location.search);
  const options = Object.fromEntries(['scene', 'setup', 'camera', 'exposure', 'resolution']
    .map((name) => [name, address.get(name) ?? document.body.dataset[name] ?? '']));
  const wasm = await init();
  const page = await start(document.getElementById('view'), options);
  text.replaceChildren();
  // For whoever measures, tests, or puts a scene into the page.
  window.probelight = {
    /** What the last frame was. */
    stats: () => ({ ...JSON.parse(page.stats()), wasm_bytes: wasm.memory.buffer.byteLength }),
    /** The picture without what lies over it: width, height, pixels. */
    picture: () => page.picture(),
    /** Lights, objects and colours as they are now: the text of a setup file. */
    setup: () => page.setup(),
    /** Opens a .plight, .glb or .json by its bytes. */
    open: (name, bytes) => page.open(name, new Uint8Array(bytes)),
  };
}

main().catch(fail);
