// The canvas: camera, moving around, drawing, and which face lies under a pixel.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const kFieldOfView = 50, kFlight = 500; // degrees; milliseconds

export class Stage {
  /// \param up of the scene
  constructor(canvas, up) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setClearColor(0, 0); // the page's own colour shows there, and pictures are transparent
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // pages are shown as they are
    this.renderer.autoClear = false;
    this.most = this.renderer.capabilities.maxTextureSize;
    this.camera = new THREE.PerspectiveCamera(kFieldOfView, 1, 0.1, 1000);
    this.turn(new THREE.Vector3(...up));
    this.scene = new THREE.Scene();
    this.over = new THREE.Scene(); // drawn on top: frustums, photos, lines
    this.controls = new OrbitControls(this.camera, canvas); // after the camera has its up direction
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.redraw());
    this.keys = new Set();
    this.models = [];
    this.split = 1; // of the width that shows the first model
    this.pixel = new THREE.WebGLRenderTarget(1, 1);
    this.frames = { count: 0, since: performance.now(), rate: 0 };
    this.onFrame = [];
    this.listen();
  }

  turn(up) {
    this.up = up.normalize();
    this.camera.up.copy(this.up);
  }

  listen() {
    new ResizeObserver(() => this.resize()).observe(this.canvas.parentElement);
    // Arrows and WASD fly, Q and E sink and rise; with shift faster.
    const isText = (event) => /INPUT|SELECT|TEXTAREA/.test(event.target.tagName);
    addEventListener('keydown', (event) => {
      if (isText(event) || event.ctrlKey || event.metaKey) return;
      this.keys.add(event.code);
      if (event.code.startsWith('Arrow')) event.preventDefault();
      this.redraw();
    });
    addEventListener('keyup', (event) => this.keys.delete(event.code));
    addEventListener('blur', () => this.keys.clear());
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  /// Looks at all of a sphere from 40 degrees above the horizon.
  overview(sphere) {
    const side = Math.abs(this.up.z) < 0.9 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(0, -1, 0);
    side.addScaledVector(this.up, -side.dot(this.up)).normalize();
    const distance = sphere.radius / Math.sin(THREE.MathUtils.degToRad(kFieldOfView / 2)) * 0.9 * Math.max(1, 0.8 / this.camera.aspect);
    const from = side.multiplyScalar(Math.cos(0.7)).addScaledVector(this.up, Math.sin(0.7)).multiplyScalar(distance);
    return { position: from.add(sphere.center), target: sphere.center.clone() };
  }

  place({ position, target, up = this.up, fov = kFieldOfView }) {
    this.camera.position.copy(position);
    this.camera.up.copy(up);
    this.camera.fov = fov;
    this.controls.target.copy(target);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.camera.lookAt(target);
    this.redraw();
  }

  /// Moves there in half a second. A later flight ends an earlier one.
  fly(to) {
    const flight = (this.flight = {});
    const from = { position: this.camera.position.clone(), target: this.controls.target.clone(), up: this.camera.up.clone(), fov: this.camera.fov };
    const goal = { up: this.up, fov: kFieldOfView, ...to }, start = performance.now();
    return new Promise((done) => {
      const step = () => {
        if (this.flight !== flight) return done(false);
        const t = Math.min(1, (performance.now() - start) / kFlight), s = t * t * (3 - 2 * t);
        const between = (name) => from[name].clone().lerp(goal[name], s);
        this.place({ position: between('position'), target: between('target'), up: between('up').normalize(), fov: from.fov + (goal.fov - from.fov) * s });
        if (t < 1) return requestAnimationFrame(step);
        this.controls.enabled = true;
        done(true);
      };
      step();
    });
  }

  redraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  walk(seconds) {
    const has = (...codes) => codes.some((code) => this.keys.has(code));
    const along = has('KeyW', 'ArrowUp') - has('KeyS', 'ArrowDown'), across = has('KeyD', 'ArrowRight') - has('KeyA', 'ArrowLeft');
    const rise = has('KeyE', 'PageUp') - has('KeyQ', 'PageDown');
    if (!along && !across && !rise) return false;
    const speed = Math.max(this.camera.position.distanceTo(this.controls.target), this.sphere.radius / 50) * (has('ShiftLeft', 'ShiftRight') ? 3 : 1);
    const ahead = this.camera.getWorldDirection(new THREE.Vector3());
    const right = new THREE.Vector3().crossVectors(ahead, this.camera.up).normalize();
    const step = new THREE.Vector3().addScaledVector(ahead, along).addScaledVector(right, across).addScaledVector(this.up, rise)
      .multiplyScalar(speed * seconds);
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
    return true;
  }

  frame(now) {
    this.asked = false;
    if (!this.sphere) return;
    if (this.walk(Math.min(0.1, (now - (this.last ?? now)) / 1000))) this.redraw();
    this.last = now;
    this.setDepthRange();
    for (const model of this.models) model.update?.(this.camera, this.canvas.clientHeight);
    for (const call of this.beforeDraw ?? []) call();
    this.draw();
    const { frames } = this;
    ++frames.count;
    if (now - frames.since > 500) Object.assign(frames, { rate: (frames.count * 1000) / (now - frames.since), count: 0, since: now });
    for (const call of this.onFrame) call();
  }

  setDepthRange() {
    const far = this.camera.position.distanceTo(this.sphere.center) + 2 * this.sphere.radius;
    this.camera.near = far / 20000;
    this.camera.far = far;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  /// Only the first or the second model is drawn, all over `target`.
  drawModel(which, target) {
    this.models.forEach((model, i) => (model.group.visible = i === which));
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
  }

  /// Each model on its side of the slider, on the screen or over `target`.
  drawModels(target = null) {
    const { renderer, models } = this, size = target ? { x: target.width, y: target.height } : renderer.getSize(new THREE.Vector2());
    const scissor = (isOn, x = 0, width = size.x) => {
      if (target) {
        target.scissorTest = isOn;
        target.scissor.set(x, 0, width, size.y);
      } else {
        renderer.setScissorTest(isOn);
        renderer.setScissor(x, 0, width, size.y);
      }
      renderer.setRenderTarget(target);
    };
    scissor(false);
    renderer.clear();
    const edge = models.length > 1 ? Math.round(size.x * this.split) : size.x;
    [[0, 0, edge], [1, edge, size.x - edge]].forEach(([which, x, width]) => {
      if (width <= 0 || !models[which]) return;
      scissor(true, x, width);
      models.forEach((model, i) => (model.group.visible = i === which));
      renderer.render(this.scene, this.camera);
    });
    scissor(false);
  }

  draw() {
    if (this.compose) {
      this.renderer.setRenderTarget(null);
      this.renderer.clear();
      this.compose(this);
    } else this.drawModels();
    this.renderer.render(this.over, this.camera);
  }

  /// Numbers of the faces in drawing order under the pixels of a square around x, y (CSS pixels), row by row from below; -1: none.
  facesAround(x, y, reach, which = 0) {
    const { clientWidth: width, clientHeight: height } = this.canvas, edge = 2 * reach + 1;
    if (this.pixel.width !== edge) this.pixel.setSize(edge, edge);
    const model = this.models[which], bytes = new Uint8Array(4 * edge * edge);
    this.setDepthRange();
    this.camera.setViewOffset(width, height, Math.floor(x) - reach, Math.floor(y) - reach, edge, edge);
    model.shared.numbers.value = true;
    this.drawModel(which, this.pixel);
    model.shared.numbers.value = false;
    this.camera.clearViewOffset();
    this.renderer.readRenderTargetPixels(this.pixel, 0, 0, edge, edge, bytes);
    this.renderer.setRenderTarget(null);
    return new Uint32Array(bytes.buffer).map((n) => n - 1).reduce((all, n) => (all.push(n === 0xffffffff ? -1 : n), all), []);
  }

  /// The surface under a pixel, in doubles: the face's number in drawing order, and the point less the model's origin; null: none.
  pick(x, y) {
    const which = this.models.length > 1 && x > this.canvas.clientWidth * this.split ? 1 : 0;
    const at = new THREE.Vector3((2 * (Math.floor(x) + 0.5)) / this.canvas.clientWidth - 1, 1 - (2 * (Math.floor(y) + 0.5)) / this.canvas.clientHeight, 0.5);
    if (this.models[which].hit) {
      const point = this.models[which].hit(at, this.camera);
      return point && { face: null, which, model: this.models[which], point };
    }
    const face = this.facesAround(x, y, 0, which)[0];
    this.redraw();
    if (face < 0) return null;
    const model = this.models[which], p = model.data.positions, shift = model.group.position;
    const corner = (i) => new THREE.Vector3(p[9 * face + 3 * i], p[9 * face + 3 * i + 1], p[9 * face + 3 * i + 2]).add(shift);
    const [a, b, c] = [corner(0), corner(1), corner(2)];
    const ray = at.unproject(this.camera).sub(this.camera.position).normalize();
    const normal = b.clone().sub(a).cross(c.clone().sub(a));
    const along = normal.dot(a.clone().sub(this.camera.position)) / normal.dot(ray);
    // The graphics card finds faces in less than doubles: at a rim the ray may pass the face that it names.
    const onPlane = Number.isFinite(along) ? this.camera.position.clone().addScaledVector(ray, along) : a;
    const point = new THREE.Triangle(a, b, c).closestPointToPoint(onPlane, new THREE.Vector3());
    return { face, which, model, point };
  }

  /// The camera as the server takes it: a view of the screen.
  screen(model) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const m = this.camera.matrixWorld.elements; // columns: right, up, back
    const rotation = [m[0], m[1], m[2], -m[4], -m[5], -m[6], -m[8], -m[9], -m[10]];
    const centre = this.camera.position.toArray().map((value, i) => value + model.origin[i]);
    return { width, height, focal: height / 2 / Math.tan(THREE.MathUtils.degToRad(this.camera.fov) / 2), rotation, centre };
  }
}
