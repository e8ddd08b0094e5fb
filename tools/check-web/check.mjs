// Uses the page as one would, in a browser without a window: `node check.mjs CHROMIUM PAGE OUT`. PAGE is a folder that
// `probelight web` wrote for a scene with one lamp. Pictures and setups that others compare are left in OUT.

import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { openBrowser, serve } from './browser.mjs';

const [program, folder, out] = process.argv.slice(2);
/** Narrow enough that the page begins without panels; small, as drivers in software take their time. */
const SIZE = { width: 320, height: 262 };
/** Where pictures are not compared. */
const COARSE = '&resolution=0.15';
/** Frames in which memory must not grow, after so many that fill caches. */
const STEADY_FRAMES = 500;
const FIRST_FRAMES = 150;

function check(is, what) {
  if (!is) throw new Error(what);
}

const stats = (tab) => tab.ask('window.probelight.stats()');
const settle = (tab) => tab.waitFor('the light does not settle', 180,
  'probelight.stats().is_open && !probelight.stats().is_busy');

/** Opens the page; the exposure is fixed so that pictures can be compared. */
async function open(tab, address, more = '') {
  await tab.open(`${address}/?exposure=1${more}`);
  await tab.waitFor('the page does not start', 60, '!!window.probelight || text.innerText.includes("cannot")');
  check(await tab.ask('!!window.probelight'), await tab.ask('text.innerText'));
  await settle(tab);
}

/** Writes the picture and what it shows. */
async function keep(tab, name) {
  const picture = await tab.ask(`(async () => {
    const { width, height, pixels } = await probelight.picture();
    const canvas = new OffscreenCanvas(width, height);
    const rgba = new Uint8ClampedArray(4 * width * height);
    for (let i = 0; i < width * height; i++) {
      rgba.set([pixels[3 * i], pixels[3 * i + 1], pixels[3 * i + 2], 255], 4 * i);
    }
    canvas.getContext('2d').putImageData(new ImageData(rgba, width, height), 0, 0);
    const bytes = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
    return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
  })()`);
  await writeFile(join(out, `${name}.png`), Buffer.from(picture, 'base64'));
  await writeFile(join(out, `${name}.json`), await tab.ask('probelight.setup()'));
}

/** Drops a file into the page. */
async function drop(tab, name, bytes) {
  await tab.ask(`(() => {
    const bytes = Uint8Array.from(atob('${Buffer.from(bytes).toString('base64')}'), (c) => c.charCodeAt(0));
    const data = new DataTransfer();
    data.items.add(new File([bytes], '${name}'));
    view.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
  })()`);
}

/** The lamp follows the mouse, and the light the lamp. */
async function relight(tab, address) {
  await open(tab, address);
  await keep(tab, 'first');
  const { lights: [[x, y]] } = await stats(tab);
  await tab.drag([[x, y], [x - 20, y + 10], [x - 60, y + 40]]);
  await settle(tab);
  const { lights: [[movedX, movedY]] } = await stats(tab);
  check(Math.hypot(movedX - x + 60, movedY - y - 40) < 3, `the lamp is not where it was dragged: ${movedX}, ${movedY}`);
  await keep(tab, 'dragged');
}

/** What is dropped is opened, the camera goes around, a ball is dragged. */
async function use(tab, address) {
  await open(tab, address, COARSE);
  const { lights: [[x, y]] } = await stats(tab);
  await tab.drag([[x, y], [x - 20, y + 10], [x - 60, y + 40]]);
  await drop(tab, 'setup.json', await readFile(join(folder, 'setup.json')));
  await tab.waitFor('a dropped setup is not opened', 30, `Math.hypot(probelight.stats().lights[0][0] - ${x}, probelight.stats().lights[0][1] - ${y}) < 1`);
  await drop(tab, 'broken.plight', 'no bake');
  await tab.waitFor('a broken file is not refused', 30, 'probelight.stats().messages.some((m) => m.includes("broken.plight"))');
  await settle(tab);

  await tab.drag([[x, y + 80], [x - 30, y + 80], [x - 60, y + 70]]);
  await settle(tab);
  const { lights: [[turnedX]] } = await stats(tab);
  check(Math.abs(turnedX - x) > 10, 'dragging does not turn the camera');

  await tab.ask('view.focus()');
  for (const type of ['keyDown', 'keyUp']) {
    await tab.send('Input.dispatchKeyEvent', { type, key: 'b', code: 'KeyB', text: type === 'keyDown' ? 'b' : undefined });
  }
  await tab.waitFor('there is no ball', 30, 'probelight.stats().objects.length === 1');
  await settle(tab);
  const { objects: [[ballX, ballY]] } = await stats(tab);
  await tab.drag([[ballX, ballY], [ballX + 10, ballY + 10], [ballX + 40, ballY + 30]]);
  await settle(tab);
  const { objects: [[draggedX, draggedY]] } = await stats(tab);
  check(Math.hypot(draggedX - ballX - 40, draggedY - ballY - 30) < 3, 'the ball does not follow the mouse');
}

/** Drags the lamp to and fro until so many more pictures were drawn. */
async function draw(tab, pictures) {
  const end = (await stats(tab)).pictures + pictures;
  for (;;) {
    const { pictures: drawn, lights: [[x, y]] } = await stats(tab);
    if (drawn >= end) return;
    await tab.drag([[x, y], [x - 30, y], [x - 30, y + 30], [x, y]]);
  }
}

async function heap(tab) {
  await tab.send('HeapProfiler.collectGarbage');
  const { usedSize } = await tab.send('Runtime.getHeapUsage');
  return { wasm: (await stats(tab)).wasm_bytes, script: usedSize };
}

async function watchMemory(tab, address) {
  await open(tab, address, COARSE);
  await draw(tab, FIRST_FRAMES);
  const before = await heap(tab);
  const start = Date.now();
  await draw(tab, STEADY_FRAMES);
  const after = await heap(tab);
  const milliseconds = (Date.now() - start) / STEADY_FRAMES;
  console.log(`${STEADY_FRAMES} frames of ${milliseconds.toFixed(0)} ms: WebAssembly ${before.wasm} → ${after.wasm} bytes, `
    + `scripts ${before.script} → ${after.script} bytes`);
  check(after.wasm === before.wasm, 'the memory of the page grows');
  check(after.script < before.script + 1e6, 'the memory of scripts grows');
}

async function withoutWebGpu(tab, address) {
  const { identifier } = await tab.send('Page.addScriptToEvaluateOnNewDocument',
    { source: 'Object.defineProperty(Navigator.prototype, "gpu", { get: () => undefined })' });
  await tab.open(address);
  await tab.waitFor('without WebGPU nothing is said', 10, 'text.innerText.includes("needs WebGPU")');
  await tab.send('Page.removeScriptToEvaluateOnNewDocument', { identifier });
}

const files = await mkdtemp(join(tmpdir(), 'probelight-browser-'));
const server = await serve(folder);
const tab = await openBrowser(program, files, SIZE);
try {
  await withoutWebGpu(tab, server.address);
  await relight(tab, server.address);
  await use(tab, server.address);
  await watchMemory(tab, server.address);
  check(tab.complaints.length === 0, `the console has ${tab.complaints.join('\n')}`);
  console.log('the page works');
} catch (error) {
  console.error(`FAILED: ${error.message}\n${tab.complaints.join('\n')}`);
  await writeFile(join(out, 'failed.png'), await tab.screenshot()).catch(() => {});
  process.exitCode = 1;
} finally {
  await tab.close();
  server.close();
  await rm(files, { recursive: true, force: true });
}
