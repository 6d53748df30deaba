// What faces are coloured by, and the legend.
import * as THREE from 'three';
import { faceTexture } from './model.js';

const kModes = {
  none: ['Texture'], photo: ['Photo shown', 'kinds'], tag: ['Seen, in parts, filled', 'tags'], gsd: ['Ground sampling distance', 'low'],
  angle: ['Angle of view', 'angle'], photos: ['Number of photos', 'count'], changed: ['Other photo than beside', 'changed'],
};
export const kTags = ['seen whole', 'seen in parts', 'filled: no photo shows it', 'background in most photos'];

/// Below which a share of the values lies.
function quantile(values, share) {
  const known = values.filter((value) => value === value).sort();
  return known.length === 0 ? 0 : known[Math.min(known.length - 1, Math.floor(share * known.length))];
}

export class Colours {
  constructor(select, legend, models, redraw) {
    Object.assign(this, { select, legend, models, redraw });
    select.addEventListener('change', () => this.show(select.value));
    this.fill();
  }

  fill() {
    const known = ['none', ...(this.models[0]?.info.values ?? [])];
    if (this.models.length > 1 && known.includes('photo') && this.models[1].info.values.includes('photo')) known.push('changed');
    const chosen = this.select.value || 'none';
    this.select.replaceChildren(...known.map((name) => new Option(kModes[name]?.[0] ?? name, name)));
    this.select.value = known.includes(chosen) ? chosen : 'none';
  }

  async show(name) {
    this.select.value = name;
    this.name = name;
    this.legend.textContent = name === 'photos' ? 'Counting photos ...' : '';
    try {
      for (const model of this.models) await this.set(model, name);
    } catch (error) {
      this.legend.textContent = error.message;
    }
    this.redraw();
  }

  async set(model, name) {
    const to = model.shared;
    if (name === 'none' || (name !== 'changed' && !model.info.values.includes(name))) return void (to.mode.value = 0);
    const { array, texture } = name === 'changed' ? await this.changed(model) : await model.valuesOf(name);
    if (this.name !== name) return;
    const kind = kModes[name][1];
    to.values.value = texture;
    to.mode.value = kind === 'kinds' ? 2 : kind === 'tags' ? 3 : 1;
    const [low, high] = kind === 'angle' ? [0, 90] : kind === 'changed' ? [0, 1] : [quantile(array, 0.02), quantile(array, 0.98)];
    if (model === this.models[0]) this.range = [low, high > low ? high : low + 1];
    [to.low.value, to.high.value] = this.range;
    this.tell(kind, array);
  }

  /// 1 where the two results show different photos.
  async changed(model) {
    const other = this.models.find((each) => each !== model);
    const [mine, theirs] = await Promise.all([model, other].map((each) => each.valuesOf('photo')));
    const byFace = new Map();
    other.data.faces.forEach((face, n) => byFace.set(face, theirs.array[n]));
    const array = mine.array.map((photo, n) => {
      const shown = byFace.get(model.data.faces[n]);
      return photo === shown || (photo !== photo && shown !== shown) ? 0 : 1;
    });
    return { array, texture: faceTexture(array, THREE.RedFormat, THREE.FloatType) };
  }

  tell(kind, array) {
    const number = (value) => (Math.abs(value) >= 100 ? value.toFixed(0) : value.toPrecision(3));
    if (kind === 'kinds') return void (this.legend.textContent = 'One colour a photo; grey: none');
    if (kind === 'changed') {
      const share = array.reduce((sum, value) => sum + value, 0) / array.length;
      return void (this.legend.textContent = `Yellow: other photo, ${(100 * share).toFixed(1)} % of the faces`);
    }
    if (kind === 'tags') {
      const counts = kTags.map((_, tag) => array.reduce((sum, value) => sum + (value === tag), 0));
      this.legend.replaceChildren(...kTags.map((name, tag) => {
        const entry = document.createElement('div');
        entry.className = `tag tag${tag}`;
        entry.textContent = `${name}: ${counts[tag].toLocaleString()}`;
        return entry;
      }));
      return;
    }
    const bar = document.createElement('div'), ends = document.createElement('div');
    bar.className = 'ramp';
    ends.className = 'ends';
    const unit = kind === 'angle' ? '°' : '';
    for (const value of this.range) ends.append(Object.assign(document.createElement('span'), { textContent: number(value) + unit }));
    this.legend.replaceChildren(bar, ends);
  }
}
