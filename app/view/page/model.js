// A result as three.js draws it: one buffer for all faces, a mesh for each block of them, a texture for each page.
import * as THREE from 'three';
import { getBytes, getImage, getJson } from './api.js';
import { fragmentShader, kWide, vertexShader } from './shader.js';

const kFullTexels = 2 * 8192 * 8192; // of pages that are kept at their full size

/// A texture of one value a face.
export function faceTexture(values, format, type) {
  const rows = Math.max(1, Math.ceil(values.length / kWide));
  const padded = new values.constructor(rows * kWide);
  padded.set(values);
  const texture = new THREE.DataTexture(padded, kWide, rows, format, type);
  texture.minFilter = texture.magFilter = THREE.NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

/// The arrays of "geometry": see bytes_of() in drawn_model.h.
function parsed(bytes) {
  const length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  let place = 4 + length;
  const take = (Type, count) => {
    place = Math.ceil(place / 8) * 8;
    const array = new Type(bytes, place, count);
    place += array.byteLength;
    return array;
  };
  const n = head.faces;
  const faces = take(Uint32Array, n), positions = take(Float32Array, 9 * n);
  const uv = take(Uint16Array, head.wide_uv ? 0 : 6 * n), wide = take(Float32Array, head.wide_uv ? 6 * n : 0);
  return { ...head, faces, positions, uv: head.wide_uv ? wide : uv, seams: take(Uint8Array, n) };
}

export class Model {
  /// \param earlier the same result before a change: pages that stay are taken from it
  static async load(number, redraw, earlier = null, origin = null) {
    const folder = `results/${number}/`;
    const [info, bytes] = await Promise.all([getJson(folder + 'model.json'), getBytes(folder + 'geometry')]);
    return new Model(folder, info, parsed(bytes), redraw, earlier, origin);
  }

  constructor(folder, info, data, redraw, earlier, origin) {
    Object.assign(this, { folder, info, data, redraw });
    this.group = new THREE.Group();
    // All results share the first one's origin, so that cameras and slider fit both.
    this.origin = origin ?? data.origin;
    this.group.position.set(...data.origin.map((value, i) => value - this.origin[i]));
    this.marked = new Uint8Array(Math.ceil(data.faces.length / kWide) * kWide);
    this.marks = faceTexture(this.marked, THREE.RedIntegerFormat, THREE.UnsignedByteType);
    this.marked = this.marks.image.data;
    this.values = { none: faceTexture(new Float32Array(1), THREE.RedFormat, THREE.FloatType) };
    this.shared = {
      values: { value: this.values.none }, marks: { value: this.marks }, mode: { value: 0 }, low: { value: 0 }, high: { value: 1 },
      strength: { value: 0.8 }, numbers: { value: false }, showsSeams: { value: false },
      seams: { value: faceTexture(data.seams, THREE.RedIntegerFormat, THREE.UnsignedByteType) },
    };
    this.makePages(earlier);
    this.makeBlocks();
  }

  makePages(earlier) {
    const kept = new Map((earlier?.pages ?? []).map((page) => [page.key, page]));
    this.pages = this.info.pages.map((page, n) => {
      const old = kept.get(page.key);
      const texture = old?.texture ?? null;
      return { ...page, number: n, texture, uniform: { value: texture }, shown: { value: Boolean(texture) }, loaded: old?.loaded ?? 0, texel: Infinity, wanted: 0 };
    });
    this.reused = this.pages.filter((page) => page.loaded > 0).length;
  }

  makeBlocks() {
    const { positions, uv, wide_uv: wide, blocks } = this.data;
    const position = new THREE.BufferAttribute(positions, 3), at = new THREE.BufferAttribute(uv, 2, !wide);
    const material = (page) => new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader, fragmentShader, side: THREE.DoubleSide,
      uniforms: { ...this.shared, page: page?.uniform ?? { value: this.values.none }, textured: page?.shown ?? { value: false } },
    });
    const bare = material(null), materials = this.pages.map(material);
    for (const block of blocks) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', position);
      geometry.setAttribute('uv', at);
      geometry.setDrawRange(3 * block.first, 3 * block.count);
      geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(...block.middle), block.radius);
      const mesh = new THREE.Mesh(geometry, block.page < 0 ? bare : materials[block.page]);
      mesh.matrixAutoUpdate = false;
      this.group.add(mesh);
      if (block.page >= 0) this.pages[block.page].texel = Math.min(this.pages[block.page].texel, this.texelOf(block));
    }
    this.group.updateMatrixWorld();
  }

  /// The length of a texel on the surface, by the block's middle face.
  texelOf({ page, first, count }) {
    const n = first + (count >> 1), { positions: p, uv } = this.data, scale = this.data.wide_uv ? 1 : 1 / 65535;
    const edge = Math.hypot(...[0, 1, 2].map((k) => p[9 * n + 3 + k] - p[9 * n + k]));
    const { width, height } = this.info.pages[page];
    const texels = Math.hypot((uv[6 * n + 2] - uv[6 * n]) * scale * width, (uv[6 * n + 3] - uv[6 * n + 1]) * scale * height);
    return texels > 0 ? edge / texels : Infinity;
  }

  /// Around all but the outermost hundredth on each side: stray faces shall not decide what one sees at first.
  sphere() {
    const { positions } = this.data, step = 9 * Math.max(1, Math.floor(positions.length / 9 / 20000));
    const ends = [0, 1, 2].map((k) => {
      const values = [];
      for (let i = k; i < positions.length; i += step) values.push(positions[i]);
      values.sort((a, b) => a - b);
      return [0.01, 0.99].map((share) => values[Math.floor(share * (values.length - 1))]);
    });
    const box = new THREE.Box3(...[0, 1].map((end) => new THREE.Vector3(...ends.map((pair) => pair[end]))));
    return box.translate(this.group.position).getBoundingSphere(new THREE.Sphere());
  }

  async setPage(page, path, level, most) {
    page.loading = true;
    try {
      const image = await getImage(this.folder + path + page.number, most);
      const texture = new THREE.Texture(image);
      texture.flipY = false;
      texture.wrapS = texture.wrapT = this.data.wide_uv ? THREE.RepeatWrapping : THREE.ClampToEdgeWrapping;
      texture.anisotropy = 4;
      texture.onUpdate = () => image.close();
      texture.needsUpdate = true;
      page.texture?.dispose();
      page.texture = page.uniform.value = texture;
      page.shown.value = true;
      page.loaded = level;
      this.redraw();
    } finally {
      page.loading = false;
    }
  }

  async loadQuarters(most) {
    await Promise.all(this.pages.filter((page) => page.loaded === 0).map((page) => this.setPage(page, 'quarters/', 1, most)));
  }

  /// Full pages where one looks: those whose quarter's texels are drawn larger than a pixel, as many as memory is planned for.
  sharpen(camera, height, most) {
    const frustum = new THREE.Frustum().setFromProjectionMatrix(
      new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    const angle = 2 * Math.tan(THREE.MathUtils.degToRad(camera.fov) / 2) / height;
    for (const page of this.pages) page.wanted = 0;
    this.group.children.forEach((mesh, i) => {
      const { page } = this.data.blocks[i];
      if (page < 0) return;
      const sphere = mesh.geometry.boundingSphere.clone().applyMatrix4(mesh.matrixWorld);
      if (!frustum.intersectsSphere(sphere)) return;
      const distance = Math.max(camera.position.distanceTo(sphere.center) - sphere.radius, 1e-9);
      this.pages[page].wanted = Math.max(this.pages[page].wanted, 4 * this.pages[page].texel / (distance * angle));
    });
    if (this.pages.some((page) => page.loading)) return;
    const order = [...this.pages].sort((a, b) => b.wanted - a.wanted);
    let texels = 0;
    for (const page of order) {
      texels += page.width * page.height;
      const isWanted = page.wanted > 1 && (texels <= kFullTexels || page === order[0]);
      if (isWanted && page.loaded === 1) return void this.setPage(page, 'pages/', 2, most).catch(console.error);
      if (!isWanted && page.loaded === 2 && texels > kFullTexels) return void this.setPage(page, 'quarters/', 1, most).catch(console.error);
    }
  }

  async valuesOf(name) {
    this.values[name] ??= (async () => {
      const array = new Float32Array(await getBytes(`${this.folder}values/${name}`));
      return { array, texture: faceTexture(array, THREE.RedFormat, THREE.FloatType) };
    })();
    return this.values[name];
  }

  dispose(heir) {
    for (const page of this.pages) if (!heir?.pages.some((other) => other.texture === page.texture)) page.texture?.dispose();
    this.group.children.forEach((mesh) => mesh.geometry.dispose());
    this.marks.dispose();
  }
}
