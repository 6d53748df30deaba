// A link with camera and mode, and pictures of the view.
import * as THREE from 'three';

const round = (value) => Number(value.toPrecision(9));

/// What the address says behind #: camera and target in the scene's coordinates, mode, slider.
export function linkOf(stage, origin, mode) {
  const world = (v) => v.toArray().map((value, i) => round(value + origin[i])).join(',');
  const parts = { from: world(stage.camera.position), to: world(stage.controls.target), up: stage.camera.up.toArray().map(round).join(','), fov: round(stage.camera.fov), mode };
  if (stage.models.length > 1) parts.split = round(stage.split);
  return `#${new URLSearchParams(parts)}`;
}

/// The same from an address; null where it says none of it, or something else.
export function placeIn(hash, origin) {
  const parts = new URLSearchParams(hash.slice(1));
  const numbers = (name) => (parts.get(name) ?? '').split(',').map(Number);
  const [from, to, up] = ['from', 'to', 'up'].map(numbers), fov = Number(parts.get('fov'));
  if (![from, to, up].every((v) => v.length === 3 && v.every(Number.isFinite)) || !(fov > 0 && fov < 180)) return null;
  const local = (v) => new THREE.Vector3(...v.map((value, i) => value - origin[i]));
  return { position: local(from), target: local(to), up: new THREE.Vector3(...up), fov, mode: parts.get('mode') ?? 'none', split: Number(parts.get('split') ?? 0.5) };
}

/// A PNG of the view, `width` pixels wide, of the screen's shape.
export async function picture(stage, width) {
  const { renderer, camera } = stage, ratio = renderer.getPixelRatio(), size = renderer.getSize(new THREE.Vector2());
  const height = Math.round((width * size.y) / size.x);
  const most = Math.min(stage.most, 16384);
  if (width > most || height > most) throw new Error(`This graphics card draws at most ${most} pixels.`);
  renderer.setPixelRatio(1);
  renderer.setSize(width, height, false);
  try {
    for (const call of stage.beforeDraw ?? []) call();
    stage.draw();
    return await new Promise((done) => stage.canvas.toBlob(done, 'image/png'));
  } finally {
    renderer.setPixelRatio(ratio);
    renderer.setSize(size.x, size.y, false);
    camera.updateProjectionMatrix();
    stage.redraw();
  }
}
