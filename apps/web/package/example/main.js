// A baked scene in three.js: three draws it with the direct light of a lamp, Probelight adds what bounces. The lamp follows
// the mouse. The scene is ?scene=ADDRESS, or scene.plight beside this file.

import * as THREE from 'three/webgpu';
import { init } from 'probelight';

const EXPOSURE = 2;

/** Three's mesh of one of the scene's, lit by a lightmap. */
function meshOf({ name, baseColor, emission, positions, normals, lightmapUvs, indices }, lightMap) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
  // Three's lightmaps are at the second texture coordinates.
  geometry.setAttribute('uv1', new THREE.BufferAttribute(lightmapUvs, 2));
  geometry.setIndex(new THREE.BufferAttribute(indices, 1));
  const material = new THREE.MeshLambertMaterial({ name, lightMap });
  material.color.setRGB(...baseColor);
  material.emissive.setRGB(...emission);
  const mesh = new THREE.Mesh(geometry, material);
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}

/** The lightmap as a texture of three's: the same memory of the same device. */
function textureOf(lightmap) {
  const texture = new THREE.ExternalTexture(lightmap);
  texture.type = THREE.HalfFloatType;
  texture.format = THREE.RGBAFormat;
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.channel = 1;
  texture.image = { width: lightmap.width, height: lightmap.height };
  texture.needsUpdate = true;
  return texture;
}

async function main() {
  const probelight = await init();
  const address = new URLSearchParams(location.search).get('scene') ?? 'scene.plight';
  const file = await fetch(address);
  if (!file.ok) throw new Error(`${address} is not there: probelight bake room.glb -o ${address}`);
  const lit = await probelight.load(await file.arrayBuffer());

  const renderer = new THREE.WebGPURenderer({ device: probelight.device, antialias: true });
  await renderer.init();
  renderer.setSize(innerWidth, innerHeight);
  renderer.shadowMap.enabled = true;
  renderer.toneMapping = THREE.AgXToneMapping;
  renderer.toneMappingExposure = EXPOSURE;
  document.body.append(renderer.domElement);

  const scene = new THREE.Scene();
  const lightMap = textureOf(lit.lightmap);
  scene.add(...lit.meshes.filter(({ indices }) => indices.length > 0).map((mesh) => meshOf(mesh, lightMap)));
  const bounds = new THREE.Box3().setFromObject(scene);
  const size = bounds.getSize(new THREE.Vector3()).length();
  const middle = bounds.getCenter(new THREE.Vector3());
  const [view] = lit.setup.cameras;
  const camera = new THREE.PerspectiveCamera(view?.vfov_deg ?? 40, innerWidth / innerHeight, 1e-3 * size, 4 * size);
  camera.position.set(...view?.position ?? [middle.x, middle.y, middle.z + size]);
  camera.lookAt(...view?.target ?? middle.toArray());

  // The same lamp for both, W/sr.
  const strength = 0.12 * size ** 2;
  const lamp = new THREE.PointLight(0xffffff, strength);
  lamp.castShadow = true;
  lamp.shadow.mapSize.set(1024, 1024);
  // Depth is fine near the lamp and coarse far from it: the nearer it begins, the larger the bias must be.
  lamp.shadow.bias = -5e-4;
  lamp.shadow.camera.near = 0.02 * size;
  lamp.shadow.camera.far = 2 * size;
  scene.add(lamp);
  const moveLamp = (x, y) => {
    const half = bounds.getSize(new THREE.Vector3()).multiplyScalar(0.4);
    lamp.position.set(middle.x - x * half.x, middle.y + y * half.y, middle.z);
    lit.setLights({
      ...lit.setup,
      lights: [{ type: 'point', position: lamp.position.toArray(), intensity: [strength, strength, strength] }],
    });
  };
  moveLamp(0.4, 0.5);
  addEventListener('pointermove', (event) => moveLamp(2 * event.clientX / innerWidth - 1, 1 - 2 * event.clientY / innerHeight));
  addEventListener('resize', () => {
    camera.aspect = innerWidth / innerHeight;
    camera.updateProjectionMatrix();
    renderer.setSize(innerWidth, innerHeight);
  });
  window.frames_drawn = 0;
  renderer.setAnimationLoop(() => {
    lit.frame();
    renderer.render(scene, camera);
    window.frames_drawn += 1;
  });
}

main().catch((error) => {
  const text = document.createElement('p');
  text.textContent = error.message;
  document.body.replaceChildren(text);
  console.error(error);
});
