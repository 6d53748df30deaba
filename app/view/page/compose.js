// The difference in colour between two results, pixel by pixel.
import * as THREE from 'three';
import { colorDifference } from './shader.js';

const fragmentShader = `
precision highp float;
in vec2 at;
out vec4 color;
uniform sampler2D first, second;
${colorDifference}
void main() {
  vec4 a = texture(first, at), b = texture(second, at);
  color = a.a == 0.0 && b.a == 0.0 ? vec4(0.0) : vec4(heat(difference(a.rgb, b.rgb) / 30.0), 1.0);
}`;
const vertexShader = `
in vec3 position;
out vec2 at;
void main() { at = position.xy * 0.5 + 0.5; gl_Position = vec4(position, 1.0); }`;

export class Difference {
  constructor() {
    this.targets = [0, 1].map(() => new THREE.WebGLRenderTarget(1, 1));
    const [first, second] = this.targets.map((target) => ({ value: target.texture }));
    const material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader, fragmentShader, uniforms: { first, second }, depthTest: false });
    this.scene = new THREE.Scene();
    const all = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    all.frustumCulled = false;
    this.scene.add(all);
  }

  draw(stage) {
    const size = stage.renderer.getDrawingBufferSize(new THREE.Vector2());
    this.targets.forEach((target, which) => {
      if (target.width !== size.x || target.height !== size.y) target.setSize(size.x, size.y);
      stage.drawModel(which, target);
    });
    stage.renderer.setRenderTarget(null);
    stage.renderer.render(this.scene, stage.camera);
  }
}
