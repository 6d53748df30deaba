// Photos: where their cameras stand, and each laid over the model as its camera sees it.
import * as THREE from 'three';
import { getImage } from './api.js';
import { colorDifference } from './shader.js';

const vertexShader = `
precision highp float;
uniform mat4 modelViewMatrix, projectionMatrix;
in vec3 position;
in vec2 uv;
out vec2 at;
void main() { at = uv; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }`;

const fragmentShader = `
precision highp float;
in vec2 at;
out vec4 color;
uniform sampler2D photo, model;
uniform float fade;
uniform vec2 size;
uniform bool compares;
${colorDifference}
void main() {
  vec3 shown = texture(photo, at).rgb;
  if (!compares) { color = vec4(shown, fade); return; }
  vec4 drawn = texture(model, gl_FragCoord.xy / size);
  if (drawn.a == 0.0) discard;
  color = vec4(heat(difference(shown, drawn.rgb) / 30.0), 1.0);
}`;

/// Rows of a view's rotation as vectors: right, down, ahead.
const axes = (view) => [0, 3, 6].map((i) => new THREE.Vector3(view.rotation[i], view.rotation[i + 1], view.rotation[i + 2]));

export class Photos {
  constructor(stage, info, origin) {
    Object.assign(this, { stage, views: info.views, used: new Set(info.used), origin });
    this.group = new THREE.Group();
    this.group.visible = false;
    stage.over.add(this.group);
    this.size = stage.sphere.radius * 0.03;
    if (this.views.length > 0) this.group.add(this.frustums());
    this.target = new THREE.WebGLRenderTarget(1, 1);
    this.material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader, fragmentShader, transparent: true, depthTest: false, depthWrite: false, side: THREE.DoubleSide,
      uniforms: { photo: { value: null }, model: { value: this.target.texture }, fade: { value: 0.5 }, size: { value: new THREE.Vector2() }, compares: { value: false } },
    });
  }

  centre(view) {
    return new THREE.Vector3(...view.centre.map((value, i) => value - this.origin[i]));
  }

  /// The corners of the undistorted photo at a depth, from the top left one on.
  corners(view, depth) {
    const [right, down, ahead] = axes(view), centre = this.centre(view);
    const [x0, y0, width, height] = view.frame;
    return [[x0, y0], [x0 + width, y0], [x0 + width, y0 + height], [x0, y0 + height]].map(([x, y]) =>
      centre.clone().addScaledVector(ahead, depth).addScaledVector(right, ((x - view.cx) / view.fx) * depth)
        .addScaledVector(down, ((y - view.cy) / view.fy) * depth));
  }

  frustums() {
    const points = [], colors = [];
    this.views.forEach((view, n) => {
      const c = this.centre(view), corners = this.corners(view, this.size), color = this.used.has(n) ? [0.1, 0.6, 1] : [0.5, 0.5, 0.5];
      for (let i = 0; i < 4; ++i) points.push(c, corners[i], corners[i], corners[(i + 1) % 4]);
      for (let i = 0; i < 16; ++i) colors.push(...color);
    });
    const geometry = new THREE.BufferGeometry().setFromPoints(points);
    geometry.setAttribute('color', new THREE.Float32BufferAttribute(colors, 3));
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ vertexColors: true }));
  }

  /// Where the camera of the page sees what the photo's saw, all of it.
  pose(view) {
    const [, down, ahead] = axes(view), position = this.centre(view);
    const reach = Math.max(this.stage.sphere.center.clone().sub(position).dot(ahead), this.size);
    const [x0, y0, width, height] = view.frame;
    const upper = Math.max(view.cy - y0, y0 + height - view.cy) / view.fy, wider = Math.max(view.cx - x0, x0 + width - view.cx) / view.fx;
    const half = Math.max(upper, wider / this.stage.camera.aspect);
    return { position, target: position.clone().addScaledVector(ahead, reach), up: down.negate(), fov: (2 * Math.atan(half) * 180) / Math.PI };
  }

  /// Flies to the photo's camera and lays the photo over the model.
  async show(number) {
    this.hide();
    const view = this.views[number], shown = (this.shown = { number });
    const [image] = await Promise.all([getImage(`photos/${number}`), this.stage.fly(this.pose(view))]);
    if (this.shown !== shown) return;
    const texture = new THREE.Texture(image);
    texture.flipY = false;
    texture.needsUpdate = true;
    const geometry = new THREE.BufferGeometry().setFromPoints(this.corners(view, this.size));
    geometry.setAttribute('uv', new THREE.Float32BufferAttribute([0, 0, 1, 0, 1, 1, 0, 1], 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    this.material.uniforms.photo.value = texture;
    this.quad = new THREE.Mesh(geometry, this.material);
    this.quad.renderOrder = 1;
    this.stage.over.add(this.quad);
    this.place = this.stage.camera.position.clone();
    this.stage.redraw();
  }

  set(fade, compares) {
    this.material.uniforms.fade.value = fade;
    this.material.uniforms.compares.value = compares;
    this.stage.redraw();
  }

  /// What the difference is taken from: the models as they are drawn now. Away from the photo's camera nothing is laid over.
  beforeDraw() {
    if (!this.quad) return;
    const { stage } = this;
    this.quad.visible = stage.camera.position.distanceTo(this.place) < 1e-6 * stage.sphere.radius + 1e-9;
    if (!this.quad.visible || !this.material.uniforms.compares.value) return;
    const size = stage.renderer.getDrawingBufferSize(this.material.uniforms.size.value);
    if (this.target.width !== size.x || this.target.height !== size.y) this.target.setSize(size.x, size.y);
    stage.drawModels(this.target);
    stage.renderer.setRenderTarget(null);
  }

  hide() {
    this.shown = null;
    if (!this.quad) return;
    this.quad.removeFromParent();
    this.quad.geometry.dispose();
    this.material.uniforms.photo.value?.dispose();
    this.quad = null;
    this.stage.redraw();
  }
}
