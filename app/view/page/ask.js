// A click: where the point is, which photo is shown there, and what all photos show or why they do not. Two clicks: how far.
import * as THREE from 'three';
import { getJson } from './api.js';
import { kTags } from './colours.js';

const kCut = 160; // pixels of a cut-out, shown at 1:1

const make = (tag, text, name = '') => Object.assign(document.createElement(tag), { textContent: text, className: name });
const number = (value, digits = 3) => (value === null ? '–' : Number(value).toFixed(digits));

export function sizeText(length) {
  return Math.abs(length) >= 100 ? length.toFixed(1) : Number(length.toPrecision(4)).toString();
}

export class Ask {
  constructor(stage, info, panel, showPhoto) {
    Object.assign(this, { stage, info, panel, showPhoto, last: null });
    this.marker = new THREE.Group();
    stage.over.add(this.marker);
  }

  /// \param found of Stage.pick(); \param measures from the last point as well
  async click(found, measures) {
    const place = found.point.toArray().map((value, i) => value + found.model.origin[i]);
    const face = found.face === null ? null : found.model.data.faces[found.face], earlier = this.last;
    this.last = { place, face, point: found.point };
    this.mark(measures && earlier ? [earlier.point, found.point] : [found.point]);
    this.panel.replaceChildren(make('p', 'Asking ...'));
    const parts = [];
    if (measures && earlier) parts.push(this.distance(earlier.place, place));
    const asked = (this.asked = {});
    try {
      if (this.info.asks) {
        const [x, y, z] = place;
        const answer = await getJson(`ask?${new URLSearchParams(face === null ? { x, y, z } : { x, y, z, face })}`);
        if (this.asked !== asked) return null;
        this.answer = answer;
        parts.push(...this.parts(answer, found));
      } else parts.push(...(await this.without(found, place)));
    } catch (error) {
      parts.push(make('p', error.message, 'wrong'));
    }
    if (this.asked === asked) this.panel.replaceChildren(...parts);
    return this.answer;
  }

  distance(a, b) {
    const d = a.map((value, i) => b[i] - value);
    return make('p', `Distance ${sizeText(Math.hypot(...d))} (x ${sizeText(d[0])}, y ${sizeText(d[1])}, z ${sizeText(d[2])})`, 'distance');
  }

  coordinates(name, at) {
    return make('p', `${name}: ${at.map((value) => number(value)).join(', ')}`, 'coordinates');
  }

  /// Of an export, and of results without their scene: what is in the files.
  async without(found, place) {
    const parts = [this.coordinates('Point', place)];
    if (found.face === null) return parts;
    parts.push(make('p', `Face ${found.model.data.faces[found.face]}`));
    if (found.model.info.values.includes('photo')) {
      const photo = (await found.model.valuesOf('photo')).array[found.face];
      parts.push(make('p', photo === photo ? `Photo ${this.info.photos[photo] ?? photo}` : 'No photo shows this face', 'shown'));
    }
    return parts;
  }

  parts(answer, found) {
    const shown = answer.photos.find((photo) => photo.textures_face);
    const parts = [this.coordinates(answer.at_srs ? answer.srs : 'Point', answer.at_srs ?? answer.at_file)];
    if (answer.at_srs) parts.push(this.coordinates("Mesh's file", answer.at_file));
    parts.push(make('p', `Face ${answer.faces[0]}`));
    parts.push(this.heading(shown, found), this.tag(found));
    const strip = make('div', '', 'strip'), others = make('ul', '', 'others');
    for (const photo of answer.photos) if (photo.shows) strip.append(this.cut(photo)); else others.append(this.other(photo));
    parts.push(make('h3', `${answer.shown} of ${answer.photos.length} photos show it`), strip);
    if (others.children.length > 0) parts.push(make('h3', 'The others do not'), others);
    if (!answer.judged) parts.push(make('p', 'Outliers and silhouettes are not known: the result was made without --editable.', 'remark'));
    return parts;
  }

  heading(shown, found) {
    const line = make('p', '', 'shown');
    if (shown) {
      line.textContent = `Shows ${shown.name}: ${sizeText(shown.gsd)} a pixel, ${shown.angle.toFixed(0)}° off`;
      return line;
    }
    if (found.face === null || !found.model.info.values.includes('photo')) return line;
    line.textContent = '…';
    found.model.valuesOf('photo').then(({ array }) => {
      const photo = array[found.face];
      line.textContent = photo === photo ? `Shows ${this.info.photos[photo] ?? photo}` : 'No photo shows this face: filled from its surroundings';
    });
    return line;
  }

  /// Whether the photos see the face whole.
  tag(found) {
    const line = make('p', '', 'remark');
    if (found.face !== null && found.model.info.values.includes('tag'))
      found.model.valuesOf('tag').then(({ array }) => (line.textContent = `This face is ${kTags[array[found.face]]}.`));
    return line;
  }

  cut(photo) {
    const entry = make('figure', '', photo.textures_face ? 'best' : ''), picture = new Image(kCut, kCut);
    picture.loading = 'lazy';
    picture.alt = '';
    picture.src = `cut?${new URLSearchParams({ view: photo.view, x: photo.pixel[0], y: photo.pixel[1], size: kCut })}`;
    const caption = make('figcaption', '');
    const cost = photo.cost ? `cost ${photo.cost.total.toFixed(2)}: ` : '';
    caption.append(make('b', photo.name), make('span', `${sizeText(photo.gsd)} a pixel, ${photo.angle.toFixed(0)}° off`), make('span', cost + photo.plain));
    const frame = make('div', '', 'cut');
    frame.append(picture);
    entry.append(frame, caption);
    entry.tabIndex = 0;
    entry.title = 'Lay this photo over the model';
    const show = () => this.showPhoto(photo.view);
    entry.addEventListener('click', show);
    entry.addEventListener('keydown', (event) => event.key === 'Enter' && show());
    return entry;
  }

  other(photo) {
    const entry = make('li', '');
    entry.append(make('b', photo.name), ` ${photo.words}`);
    if (photo.hidden_by !== undefined) {
      const button = make('button', 'show face', 'link');
      button.addEventListener('click', () => this.onFace?.(photo.hidden_by));
      entry.append(' ', button);
    }
    return entry;
  }

  mark(points) {
    this.marker.clear();
    const dots = new THREE.Points(new THREE.BufferGeometry().setFromPoints(points), new THREE.PointsMaterial({ color: 0xff00ff, size: 9, sizeAttenuation: false, depthTest: false }));
    this.marker.add(dots);
    if (points.length > 1)
      this.marker.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color: 0xff00ff, depthTest: false })));
    this.stage.redraw();
  }

}
