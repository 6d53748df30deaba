// Faces that are marked, rules about their photos, and a result made anew by them.
import { getJson, post } from './api.js';

const kBrush = 12; // CSS pixels to its rim

/// Ascending faces as rules list them: 7, [100, 120].
export function ranges(faces) {
  const list = [];
  for (let i = 0; i < faces.length; ) {
    let end = i + 1;
    while (end < faces.length && faces[end] === faces[end - 1] + 1) ++end;
    list.push(end - i === 1 ? faces[i] : [faces[i], faces[end - 1]]);
    i = end;
  }
  return list;
}
export const listed = (list) => list.flatMap((entry) => (Array.isArray(entry) ? Array.from({ length: entry[1] - entry[0] + 1 }, (_, i) => entry[0] + i) : [entry]));

export class Change {
  constructor(stage, model, info, ui) {
    Object.assign(this, { stage, info, ui, tool: 'ask', chosen: new Set(), steps: [], undone: [], rules: [] });
    this.setModel(model);
    for (const [index, name] of info.photos.entries())
      if (info.used.includes(index)) ui.photo.append(new Option(name, index));
    ui.veto.addEventListener('click', () => this.addRule('forbid'));
    ui.only.addEventListener('click', () => this.addRule('allow'));
    ui.photo.addEventListener('change', () => this.hatch());
    ui.undo.addEventListener('click', () => this.undo());
    ui.redo.addEventListener('click', () => this.redo());
    ui.clear.addEventListener('click', () => this.choose([], 'replace'));
    ui.apply.addEventListener('click', () => this.apply());
    ui.cancel.addEventListener('click', () => post('cancel'));
    if (info.changes) getJson('rules').then(({ rules }) => this.take(rules)).catch((error) => (ui.state.textContent = error.message));
    this.tell();
  }

  setModel(model) {
    this.model = model;
    this.drawn = new Map();
    model.data.faces.forEach((face, n) => this.drawn.set(face, n));
    this.paint();
  }

  // --- faces

  choose(faces, how = 'add') {
    if (how === 'replace') this.chosen.clear();
    for (const face of faces) if (how === 'remove') this.chosen.delete(face); else this.chosen.add(face);
    this.unseen = [];
    this.paint();
    this.tell();
    clearTimeout(this.later);
    this.later = setTimeout(() => this.hatch(), 250);
  }

  paint() {
    const { marked, marks } = this.model;
    marked.fill(0);
    for (const face of this.chosen) marked[this.drawn.get(face)] |= 1;
    for (const face of this.unseen ?? []) marked[this.drawn.get(face)] |= 2;
    if (this.pointed !== undefined) marked[this.drawn.get(this.pointed)] |= 4;
    marks.needsUpdate = true;
    this.stage.redraw();
  }

  /// Shows one face, which may lie anywhere.
  point(face) {
    this.pointed = face;
    this.paint();
  }

  /// Faces under the brush, which hides nothing: what lies in front.
  brush(x, y, removes) {
    const edge = 2 * kBrush + 1, found = new Set();
    this.stage.facesAround(x, y, kBrush).forEach((n, i) => {
      if (n >= 0 && Math.hypot((i % edge) - kBrush, Math.floor(i / edge) - kBrush) <= kBrush) found.add(this.model.data.faces[n]);
    });
    this.choose(found, removes ? 'remove' : 'add');
  }

  async polygon(points, removes) {
    if (points.length < 3) return;
    const { faces } = await this.asked(() => post('faces-in', { ...this.stage.screen(this.model), polygon: points }));
    this.choose(listed(faces), removes ? 'remove' : 'add');
  }

  async chart(face, removes) {
    const { faces } = await this.asked(() => post('chart', { face }));
    this.choose(listed(faces), removes ? 'remove' : 'add');
  }

  async asked(question) {
    try {
      this.ui.state.textContent = '';
      return await question();
    } catch (error) {
      this.ui.state.textContent = error.message;
      return { faces: [] };
    }
  }

  /// Stripes over the chosen faces that the chosen photo does not see: "only this photo" leaves them to the others.
  async hatch() {
    this.unseen = [];
    if (this.chosen.size > 0 && this.ui.photo.value !== '' && this.info.judged) {
      const { faces } = await this.asked(() => post('unseen', { view: Number(this.ui.photo.value), faces: this.chosenRanges() }));
      this.unseen = listed(faces).filter((face) => this.chosen.has(face));
    }
    this.paint();
    this.tell();
  }

  chosenRanges() {
    return ranges([...this.chosen].sort((a, b) => a - b));
  }

  // --- rules

  addRule(kind) {
    if (this.chosen.size === 0 || this.ui.photo.value === '') return;
    const unseen = new Set(this.unseen);
    const faces = [...this.chosen].filter((face) => kind === 'forbid' || !unseen.has(face)).sort((a, b) => a - b);
    if (faces.length === 0) return void (this.ui.state.textContent = 'The photo sees none of these faces.');
    this.change([...this.rules, { faces: ranges(faces), [kind]: this.info.photos[Number(this.ui.photo.value)] }]);
    this.chosen.clear();
    this.unseen = [];
    this.paint();
  }

  change(rules) {
    this.steps.push(this.rules);
    this.undone = [];
    this.keep(rules);
  }
  undo() {
    if (this.steps.length === 0) return;
    this.undone.push(this.rules);
    this.keep(this.steps.pop());
  }
  redo() {
    if (this.undone.length === 0) return;
    this.steps.push(this.rules);
    this.keep(this.undone.pop());
  }
  take(rules) {
    this.rules = rules;
    this.applied = JSON.stringify(rules);
    this.tell();
  }
  async keep(rules) {
    this.rules = rules;
    this.tell();
    await this.asked(() => post('rules', { rules }));
  }

  tell() {
    const { ui } = this, faces = this.chosen.size;
    const hidden = this.unseen?.length ? `, ${this.unseen.length.toLocaleString()} of them not seen by the photo (striped)` : '';
    ui.count.textContent = faces === 0 ? 'No face is marked' : `${faces.toLocaleString()} faces are marked${hidden}`;
    ui.list.replaceChildren(...this.rules.map((rule, n) => this.entry(rule, n)));
    const ready = this.info.changes && !this.running;
    ui.veto.disabled = ui.only.disabled = !ready || faces === 0 || ui.photo.value === '';
    ui.undo.disabled = !ready || this.steps.length === 0;
    ui.redo.disabled = !ready || this.undone.length === 0;
    ui.apply.disabled = !ready || JSON.stringify(this.rules) === this.applied;
    ui.cancel.hidden = !this.running;
  }

  entry(rule, n) {
    const names = [rule.allow ?? rule.forbid].flat().join(', '), count = rule.faces ? listed(rule.faces).length : 0;
    const item = document.createElement('li'), remove = document.createElement('button');
    item.textContent = `${rule.allow ? 'only' : 'not'} ${names}, ${count ? `${count.toLocaleString()} faces` : Object.keys(rule)[0]} `;
    remove.textContent = 'remove';
    remove.className = 'link';
    remove.addEventListener('click', () => this.change(this.rules.filter((_, i) => i !== n)));
    item.append(remove);
    if (rule.faces) item.addEventListener('mouseenter', () => this.choose(listed(rule.faces), 'replace'));
    return item;
  }

  // --- a new result

  async apply() {
    try {
      await post('rules', { rules: this.rules });
      this.sent = JSON.stringify(this.rules);
      this.started = performance.now();
      await post('apply');
      this.running = true;
      this.ui.state.textContent = 'Applying ...';
    } catch (error) {
      this.ui.state.textContent = error.message;
    }
    this.tell();
  }

  /// What the run in the background reports; `reload` loads the new result.
  async hear(news, reload) {
    const { state } = this.ui;
    if (news.warning) return void (this.warning = news.warning);
    if (news.stage) {
      this.running = true;
      state.textContent = news.total ? `${news.stage}: ${news.done} of ${news.total} ${news.unit}` : `${news.stage} ...`;
    }
    if (news.ended) {
      this.running = false;
      if (news.ended === 'done') {
        this.applied = this.sent;
        const { reused, pages } = await reload();
        const seconds = ((performance.now() - this.started) / 1000).toFixed(1);
        state.textContent = `Applied in ${seconds} s; ${reused} of ${pages} pages stay as they were.${this.warning ? ` ${this.warning}` : ''}`;
      } else state.textContent = news.ended === 'failed' ? news.why : 'Cancelled: the earlier result stays.';
      this.warning = null;
    }
    this.tell();
  }
}
