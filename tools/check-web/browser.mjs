// A browser without a window, and a server of static files. The browser is told what to do by the Chrome DevTools Protocol
// through a pipe, so that nothing but Node.js is needed.

import { spawn } from 'node:child_process';
import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { extname, join, normalize } from 'node:path';

const KINDS = {
  '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm',
  '.json': 'application/json',
};

/** Hands out a folder; returns its address. */
export async function serve(folder) {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
    try {
      const bytes = await readFile(join(folder, path.endsWith('/') ? `${path}index.html` : path));
      response.writeHead(200, { 'Content-Type': KINDS[extname(path)] ?? (path.endsWith('/') ? 'text/html' : 'application/octet-stream') });
      response.end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { address: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

/** WebGPU by a driver in software, which needs neither a GPU nor a display. */
const SOFTWARE_GPU = ['--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader', '--enable-features=Vulkan',
  '--use-vulkan=swiftshader', '--use-angle=swiftshader'];

/** Starts a Chromium whose files are kept in `folder`. */
export async function openBrowser(program, folder, { width, height, gpu = true }) {
  const browser = spawn(program, ['--headless=new', '--no-sandbox', '--no-first-run', '--disable-extensions',
    '--remote-debugging-pipe', `--user-data-dir=${folder}`,
    ...(gpu ? SOFTWARE_GPU : ['--disable-features=WebGPU', '--disable-blink-features=WebGPU']), 'about:blank'],
  { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
  const [, , , toBrowser, fromBrowser] = browser.stdio;
  const waiting = new Map();
  const listeners = [];
  let last = 0;
  let received = '';
  fromBrowser.setEncoding('utf8');
  fromBrowser.on('data', (part) => {
    const messages = (received + part).split('\0');
    received = messages.pop();
    for (const message of messages.map(JSON.parse)) {
      const { resolve, reject } = waiting.get(message.id) ?? {};
      waiting.delete(message.id);
      if (message.error) reject?.(new Error(message.error.message));
      else if (message.id) resolve?.(message.result);
      else listeners.forEach((listener) => listener(message));
    }
  });
  const ended = new Promise((resolve) => { browser.on('exit', resolve); browser.on('error', resolve); });
  ended.then(() => waiting.forEach(({ reject }) => reject(new Error('the browser has ended'))));
  const send = (method, params = {}, sessionId = undefined) => new Promise((resolve, reject) => {
    waiting.set(++last, { resolve, reject });
    toBrowser.write(`${JSON.stringify({ id: last, method, params, sessionId })}\0`);
  });
  const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
  const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
  const tab = new Tab((method, params) => send(method, params, sessionId), listeners, async () => {
    browser.kill();
    await ended;
  });
  await tab.send('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: false });
  return tab;
}

/** A page, what it complains of, and what one can do there. */
class Tab {
  complaints = [];

  constructor(send, listeners, close) {
    Object.assign(this, { send, close });
    listeners.push(({ method, params }) => {
      if (method === 'Page.loadEventFired') this.hasLoaded();
      if (method === 'Runtime.exceptionThrown') {
        this.complaints.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
      }
      if (method === 'Runtime.consoleAPICalled' && ['error', 'warning', 'assert'].includes(params.type)) {
        this.complaints.push(params.args.map((arg) => arg.value ?? arg.description).join(' '));
      }
      if (method === 'Log.entryAdded' && ['error', 'warning'].includes(params.entry.level)) {
        this.complaints.push(params.entry.text);
      }
    });
  }

  async open(address) {
    await this.send('Runtime.enable');
    await this.send('Log.enable');
    await this.send('Page.enable');
    const loaded = new Promise((resolve) => { this.hasLoaded = resolve; });
    await this.send('Page.navigate', { url: address });
    await loaded;
  }

  /** The value of an expression in the page; promises are waited for. */
  async ask(expression) {
    const answer = await this.send('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
    if (answer.exceptionDetails) {
      throw new Error(answer.exceptionDetails.exception?.description ?? answer.exceptionDetails.text);
    }
    return answer.result.value;
  }

  /** Asks until the answer is right. */
  async waitFor(what, seconds, expression) {
    const deadline = Date.now() + 1000 * seconds;
    while (!await this.ask(expression)) {
      if (Date.now() > deadline) throw new Error(`${what}: not after ${seconds} s`);
      await new Promise((resolve) => setTimeout(resolve, 200));
    }
  }

  /** Drags the mouse with its left button through places, CSS pixels. */
  async drag(places) {
    const event = (type, [x, y]) =>
      this.send('Input.dispatchMouseEvent', { type, x, y, button: 'left', buttons: type === 'mouseReleased' ? 0 : 1, clickCount: 1 });
    await this.send('Input.dispatchMouseEvent', { type: 'mouseMoved', x: places[0][0], y: places[0][1] });
    await event('mousePressed', places[0]);
    for (const place of places.slice(1)) {
      await event('mouseMoved', place);
      await this.ask('new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))');
    }
    await event('mouseReleased', places.at(-1));
  }

  /** What one sees, as the bytes of a PNG file. */
  async screenshot() {
    const { data } = await this.send('Page.captureScreenshot', { format: 'png' });
    return Buffer.from(data, 'base64');
  }
}
