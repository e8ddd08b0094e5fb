// Real-time global illumination of baked scenes, on a WebGPU device of your own. index.d.ts says what there is.
//
// The WebAssembly module opens its device by itself and keeps its textures to itself. Both are handed over here: while it
// opens a device, adapters hand out the given one; while it loads a scene, the device is asked for what it makes.

import start, { open } from './probelight_web.js';

/** What the module calls the texture with the light. */
const LIGHTMAP = 'irradiance lightmap';

export async function init({ device, module } = {}) {
  if (!navigator.gpu) throw new Error('this browser has no WebGPU');
  await start(module && { module_or_path: module });
  const request = GPUAdapter.prototype.requestDevice;
  let opened;
  GPUAdapter.prototype.requestDevice = async function requestDevice(...wanted) {
    opened = device ?? await request.apply(this, wanted);
    return opened;
  };
  try {
    return new Probelight(await open(), opened);
  } finally {
    GPUAdapter.prototype.requestDevice = request;
  }
}

class Probelight {
  #opened;

  constructor(opened, device) {
    this.#opened = opened;
    this.device = device;
  }

  async load(bytes) {
    let lightmap;
    // A member of its own hides the device's method, until it is deleted.
    this.device.createTexture = (descriptor) => {
      const texture = GPUDevice.prototype.createTexture.call(this.device, descriptor);
      if (descriptor.label === LIGHTMAP) lightmap = texture;
      return texture;
    };
    try {
      return new Scene(await this.#opened.load(new Uint8Array(bytes)), lightmap);
    } finally {
      delete this.device.createTexture;
    }
  }
}

class Scene {
  #scene;

  constructor(scene, lightmap) {
    this.#scene = scene;
    this.lightmap = lightmap;
    this.meshes = scene.meshes();
    this.setup = JSON.parse(scene.setup());
  }

  setLights(setup) {
    this.#scene.setLights(typeof setup === 'string' ? setup : JSON.stringify(setup));
  }

  frame() {
    this.#scene.frame();
  }

  free() {
    this.#scene.free();
  }
}
