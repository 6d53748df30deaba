// A tileset of 3D Tiles 1.1, level by level: coarse tiles far away, their children where one looks.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { getBytes, getJson } from './api.js';

const kTolerated = 16; // pixels of a tile's error
const kLoads = 4, kKept = 400; // tiles loaded at a time; kept in memory
const kOnGlobe = 1e6; // metres from the earth's middle, at least

export class Tiles {
  static async load(redraw) {
    return new Tiles(await getJson('tileset/tileset.json'), redraw);
  }

  constructor(json, redraw) {
    this.redraw = redraw;
    this.info = { values: [] };
    this.loads = 0;
    this.now = 0;
    this.loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
    this.group = new THREE.Group();
    const transform = new THREE.Matrix4().fromArray(json.root.transform ?? new THREE.Matrix4().elements);
    const place = new THREE.Vector3().setFromMatrixPosition(transform);
    // On the globe tiles are shown in their own axes; else the transform leads to the scene's coordinates.
    const isOnGlobe = place.length() > kOnGlobe, offset = json.asset?.extras?.offset ?? [0, 0, 0];
    this.origin = isOnGlobe ? offset : place.toArray();
    this.group.matrixAutoUpdate = false;
    if (!isOnGlobe) this.group.matrix.copy(transform).setPosition(0, 0, 0);
    this.group.updateMatrixWorld(true);
    this.up = new THREE.Vector3(0, 0, 1).transformDirection(this.group.matrix);
    this.root = this.tile(json.root);
    this.shared = { showsSeams: {} };
  }

  tile({ boundingVolume: { box }, geometricError: error, content, children = [] }) {
    const axes = [3, 6, 9].map((i) => Math.hypot(box[i], box[i + 1], box[i + 2]));
    const sphere = new THREE.Sphere(new THREE.Vector3(...box.slice(0, 3)), Math.hypot(...axes)).applyMatrix4(this.group.matrix);
    return { sphere, error, uri: content?.uri, children: children.map((child) => this.tile(child)), used: 0 };
  }

  sphere() {
    return this.root.sphere.clone();
  }

  async fetch(tile) {
    tile.loading = true;
    ++this.loads;
    try {
      const { scene } = await this.loader.parseAsync(await getBytes(`tileset/${tile.uri}`), '');
      scene.traverse((mesh) => {
        if (!mesh.isMesh) return;
        const { map } = mesh.material;
        if (map) map.colorSpace = THREE.NoColorSpace; // shown as it is
        mesh.material = new THREE.MeshBasicMaterial({ map, side: THREE.DoubleSide });
      });
      const turned = new THREE.Group();
      turned.rotation.x = Math.PI / 2; // glTF's y is up, the tiles' z
      turned.add(scene);
      turned.visible = false;
      this.group.add(turned);
      turned.updateMatrixWorld(true);
      tile.object = turned;
    } catch (error) {
      tile.failed = true;
      console.error(error.message);
    } finally {
      tile.loading = false;
      --this.loads;
      this.redraw();
    }
  }

  /// Shows what is loaded of what is wanted; true if the tile, or all that stands for it, is shown.
  choose(tile, camera, frustum, pixels) {
    if (!frustum.intersectsSphere(tile.sphere)) return true;
    const distance = Math.max(camera.position.distanceTo(tile.sphere.center) - tile.sphere.radius, camera.near);
    tile.used = this.now;
    const isFine = (tile.error * pixels) / distance <= kTolerated || tile.children.length === 0;
    if (!isFine) {
      const ready = tile.children.filter((child) => child.object || !frustum.intersectsSphere(child.sphere));
      if (ready.length === tile.children.length) return tile.children.map((child) => this.choose(child, camera, frustum, pixels)).every(Boolean);
      for (const child of tile.children) this.want(child, distance);
    }
    if (tile.object) tile.object.visible = true;
    else this.want(tile, distance);
    return Boolean(tile.object);
  }

  want(tile, distance) {
    tile.used = this.now;
    if (!tile.object && !tile.loading && !tile.failed && tile.uri) this.wanted.push({ tile, distance });
  }

  /// To be called before each frame.
  update(camera, height) {
    ++this.now;
    this.wanted = [];
    for (const child of this.group.children) child.visible = false;
    const frustum = new THREE.Frustum().setFromProjectionMatrix(new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    this.choose(this.root, camera, frustum, height / 2 / Math.tan(THREE.MathUtils.degToRad(camera.fov) / 2));
    this.wanted.sort((a, b) => a.distance - b.distance);
    for (const { tile } of this.wanted.slice(0, Math.max(0, kLoads - this.loads))) this.fetch(tile);
    if (this.group.children.length > kKept) this.forget(this.root);
  }

  forget(tile) {
    if (tile.object && this.now - tile.used > 60) {
      tile.object.traverse((mesh) => {
        mesh.geometry?.dispose();
        mesh.material?.map?.dispose();
        mesh.material?.dispose();
      });
      tile.object.removeFromParent();
      tile.object = null;
    }
    tile.children.forEach((child) => this.forget(child));
  }

  /// The surface under a place of the screen (-1 to 1), less the origin; null: none.
  hit(at, camera) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, camera);
    const shown = this.group.children.filter((child) => child.visible);
    return ray.intersectObjects(shown, true)[0]?.point ?? null;
  }

  sharpen() {}
}
