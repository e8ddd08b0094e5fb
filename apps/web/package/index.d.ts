/** Starts Probelight. */
export function init(options?: {
  /** Your device; without it one is opened, with WebGPU's default limits. */
  device?: GPUDevice;
  /** Address of probelight_web_bg.wasm, if it is not beside this file. */
  module?: string | URL;
}): Promise<Probelight>;

export interface Probelight {
  /** The device that scenes are lit on. */
  readonly device: GPUDevice;
  /** Loads a baked file (.plight). Load one scene at a time. */
  load(bytes: ArrayBuffer | Uint8Array): Promise<Scene>;
}

/** A baked scene and its light. */
export interface Scene {
  /**
   * Irradiance, W/m², linear Rec. 709, rgba16float, with mipmaps: light that bounced, the sky's, and that of emissive
   * surfaces. The direct light of lamps and suns is your renderer's. A surface of diffuse colour ρ adds ρ/π times this.
   */
  readonly lightmap: GPUTexture;
  /** The scene's triangles, a mesh for each material, in the order of the glTF file's. */
  readonly meshes: readonly Mesh[];
  /** Lights and cameras of the glTF file that was baked, as a setup. */
  readonly setup: Setup;
  /**
   * Lights, sky, strength of emission, changed colours.
   * @throws if it breaks the rules of setup files; nothing is changed then.
   */
  setLights(setup: Setup | string): void;
  /** Submits one frame's light to the device: one more bounce. Call it once per frame, before you draw. */
  frame(): void;
  /** Gives the scene's memory back. The lightmap is gone then, too. */
  free(): void;
}

/** A setup, as docs/user-guide.md describes it. */
export interface Setup {
  version: 1;
  name: string;
  scene: string;
  use_emissive: boolean;
  lights: object[];
  cameras: object[];
  [more: string]: unknown;
}

export interface Mesh {
  /** The material's. */
  readonly name: string;
  /** Linear red, green, blue. */
  readonly baseColor: Float32Array;
  /** Radiance, W·m⁻²·sr⁻¹. */
  readonly emission: Float32Array;
  /** World space, metres. */
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  /** Of the material's textures. */
  readonly uvs: Float32Array;
  /** In the lightmap: 0 to 1 from its top left corner. */
  readonly lightmapUvs: Float32Array;
  /** Three per triangle, counter-clockwise. */
  readonly indices: Uint32Array;
}
