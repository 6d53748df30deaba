// What clicks and strokes on the canvas mean, by the tool that is chosen.
export class Pointer {
  constructor(stage, outline, act) {
    Object.assign(this, { stage, outline, act, tool: 'ask', points: [] });
    const { canvas } = stage;
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerup', (event) => this.up(event));
    canvas.addEventListener('pointercancel', () => this.end());
    canvas.addEventListener('dblclick', () => this.tool === 'polygon' && this.close());
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  }

  set(tool) {
    this.tool = tool;
    this.end();
    // With a tool one finger or the left button draws; the others move the camera still.
    this.stage.controls.enabled = true;
    const draws = tool === 'brush' || tool === 'box';
    Object.assign(this.stage.controls.mouseButtons, { LEFT: draws ? null : 0 });
    Object.assign(this.stage.controls.touches, { ONE: draws ? null : 0 });
    this.stage.canvas.style.cursor = tool === 'ask' ? 'default' : 'crosshair';
  }

  at(event) {
    const box = this.stage.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    if (event.button !== 0 || !event.isPrimary) return;
    const at = this.at(event);
    this.start = { at, time: event.timeStamp, pointer: event.pointerId };
    if (this.tool === 'brush') this.act.brush(...at, event.altKey);
    if (this.tool === 'box') this.points = [at, at];
  }

  move(event) {
    const at = this.at(event);
    if (this.start && this.tool === 'brush') this.act.brush(...at, event.altKey);
    if (this.start && this.tool === 'box') this.draw([this.points[0], at]);
    if (this.tool === 'polygon' && this.points.length > 0) this.draw([...this.points, at], true);
  }

  up(event) {
    if (!this.start || event.button !== 0) return;
    const { at: [x0, y0] } = this.start, [x, y] = this.at(event), isClick = Math.hypot(x - x0, y - y0) < 5;
    this.start = null;
    if (this.tool === 'box' && !isClick) {
      const [left, right] = [Math.min(x0, x), Math.max(x0, x)], [top, bottom] = [Math.min(y0, y), Math.max(y0, y)];
      this.act.polygon([[left, top], [right, top], [right, bottom], [left, bottom]], event.altKey);
    }
    if (this.tool === 'box') return this.end();
    if (!isClick) return;
    if (this.tool === 'ask') this.act.ask(x, y, event.shiftKey);
    if (this.tool === 'chart') this.act.chart(x, y, event.altKey);
    if (this.tool === 'polygon') {
      const [first] = this.points;
      if (this.points.length > 2 && Math.hypot(x - first[0], y - first[1]) < 10) return this.close(event.altKey);
      this.points.push([x, y]);
      this.draw(this.points);
    }
  }

  close(removes = false) {
    const { points } = this;
    this.end();
    if (points.length > 2) this.act.polygon(points, removes);
  }

  draw(points, isOpen = false) {
    const corners = this.tool === 'box' ? [points[0], [points[1][0], points[0][1]], points[1], [points[0][0], points[1][1]]] : points;
    this.outline.setAttribute('d', corners.map(([x, y], i) => `${i ? 'L' : 'M'}${x} ${y}`).join('') + (isOpen ? '' : 'Z'));
    if (this.tool === 'box') this.points = points;
  }

  end() {
    this.start = null;
    this.points = [];
    this.outline.setAttribute('d', '');
  }
}
