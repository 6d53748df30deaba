// The page of gpvc view: loads the results, and joins canvas, panels and server.
import { getJson, listen } from './api.js';
import { Ask } from './ask.js';
import { Change } from './change.js';
import { Colours } from './colours.js';
import { Difference } from './compose.js';
import { Model } from './model.js';
import { Photos } from './photos.js';
import { Pointer } from './pointer.js';
import { linkOf, picture, placeIn } from './share.js';
import { Stage } from './stage.js';
import { Tiles } from './tiles.js';

const byId = (id) => document.getElementById(id);
const say = (text) => (byId('message').textContent = text);

function showTab(name) {
  for (const button of document.querySelectorAll('[data-tab]')) button.classList.toggle('chosen', button.dataset.tab === name);
  for (const section of document.querySelectorAll('section')) section.hidden = section.id !== name;
}

/// Loads pages in two steps, and redraws by what is in sight.
class Page {
  constructor(info, tiles) {
    this.info = info;
    this.tiles = tiles;
    this.stage = new Stage(byId('canvas'), tiles ? tiles.up.toArray() : info.up);
    this.redraw = () => this.stage.redraw();
    this.stage.beforeDraw = [];
  }

  async load(numbers) {
    const models = [];
    for (const number of numbers) {
      const model = await Model.load(number, this.redraw, null, models[0]?.origin);
      this.stage.scene.add(model.group);
      models.push(model);
      this.stage.models.push(model);
      if (models.length > 1) continue;
      this.stage.sphere = model.sphere();
      this.stage.place(this.stage.overview(this.stage.sphere));
    }
    this.numbers = numbers;
    this.stage.resize();
    // Until its page is there, a face is shaded by its direction.
    this.textured = Promise.all(models.map((model) => model.loadQuarters(this.stage.most))).then(() => say(''), (error) => say(error.message));
  }

  /// A tileset, which loads what is in sight by itself.
  loadTiles() {
    const { stage, tiles } = this;
    tiles.redraw = this.redraw;
    stage.scene.add(tiles.group);
    stage.models.push(tiles);
    stage.sphere = tiles.sphere();
    stage.place(stage.overview(stage.sphere));
    stage.resize();
  }

  /// The chosen results instead of those that are shown.
  async replace(numbers) {
    const { stage } = this, old = [...stage.models], origin = old[0].origin;
    const fresh = [];
    for (const number of numbers) {
      const kept = old[this.numbers.indexOf(number)];
      fresh.push(kept ?? (await Model.load(number, this.redraw, null, origin)));
    }
    this.put(old, fresh);
    this.numbers = numbers;
    await Promise.all(fresh.map((model) => model.loadQuarters(stage.most)));
    await this.colours.show(this.colours.name ?? 'none');
  }

  /// The first result once it has been made anew.
  async reload() {
    const { stage } = this, [first, ...others] = stage.models;
    const fresh = await Model.load(this.numbers[0], this.redraw, first, first.origin);
    fresh.shared.showsSeams.value = first.shared.showsSeams.value;
    this.put([first], [fresh, ...others]);
    this.change?.setModel(fresh);
    await fresh.loadQuarters(stage.most);
    await this.colours.show(this.colours.name ?? 'none');
    return { reused: fresh.reused, pages: fresh.pages.length };
  }

  put(old, models) {
    const { stage } = this;
    for (const model of old) if (!models.includes(model)) {
      model.group.removeFromParent();
      model.dispose(models.find((other) => other.folder === model.folder));
    }
    for (const model of models) stage.scene.add(model.group);
    stage.models.splice(0, stage.models.length, ...models);
    this.colours.fill();
    this.showSeams();
    stage.redraw();
  }

  showSeams() {
    for (const model of this.stage.models) model.shared.showsSeams.value = byId('seams').checked;
    this.redraw();
  }
}

function setUpLook(page) {
  const { stage, info } = page, { views } = info;
  page.colours = new Colours(byId('mode'), byId('legend'), stage.models, page.redraw);
  page.photos = new Photos(stage, info, stage.models[0].origin);
  stage.beforeDraw.push(() => page.photos.beforeDraw());
  byId('seams').addEventListener('change', () => page.showSeams());
  byId('frustums').addEventListener('change', (event) => {
    page.photos.group.visible = event.target.checked;
    stage.redraw();
  });
  byId('home').addEventListener('click', () => stage.fly(stage.overview(stage.sphere)));
  const photo = byId('photo'), misfit = byId('misfit'), fade = byId('fade');
  if (page.tiles) for (const id of ['mode', 'seams']) byId(id).disabled = true;
  byId('photo-tools').hidden = views.length === 0;
  byId('frustums').disabled = views.length === 0;
  views.forEach((view, n) => info.used.includes(n) && photo.append(new Option(view.name, n)));
  page.showPhoto = (number) => {
    photo.value = number;
    if (number === '') return page.photos.hide();
    page.photos.show(Number(number)).catch((error) => say(error.message));
  };
  photo.addEventListener('change', () => page.showPhoto(photo.value));
  const set = () => page.photos.set(fade.value / 100, misfit.checked);
  for (const input of [fade, misfit]) input.addEventListener('input', set);
}

function setUpBeside(page) {
  const { stage, info } = page, slider = byId('slider');
  if (info.results.length < 2) return;
  const difference = new Difference(), selects = [byId('first'), byId('second')];
  const name = () => selects.forEach((select, i) => (byId(['left-name', 'right-name'][i]).textContent = info.results[select.value].name));
  selects.forEach((select, i) => {
    info.results.forEach((result, n) => select.append(new Option(result.name, n)));
    select.value = i;
    select.addEventListener('change', () => {
      name();
      page.replace(selects.map((each) => Number(each.value))).catch((error) => say(error.message));
    });
  });
  name();
  for (const id of ['slider', 'divider', 'names', 'which', 'compares']) byId(id).hidden = false;
  page.divide = (share) => {
    stage.split = share;
    slider.value = 1000 * share;
    byId('divider').style.left = `${100 * share}%`;
    stage.redraw();
  };
  page.divide(0.5);
  slider.addEventListener('input', () => page.divide(slider.value / 1000));
  byId('difference').addEventListener('change', (event) => {
    stage.compose = event.target.checked ? () => difference.draw(stage) : null;
    byId('divider').hidden = event.target.checked;
    stage.redraw();
  });
}

function setUpTools(page) {
  const { stage, info } = page;
  page.ask = new Ask(stage, info, byId('answer'), (view) => page.showPhoto(String(view)));
  const ui = { count: 'count', photo: 'rule-photo', veto: 'veto', only: 'only', clear: 'clear', undo: 'undo', redo: 'redo', apply: 'apply', cancel: 'cancel', list: 'rules', state: 'state' };
  for (const name of Object.keys(ui)) ui[name] = byId(ui[name]);
  page.change = page.tiles ? null : new Change(stage, stage.models[0], info, ui);
  page.ask.onFace = (face) => page.change?.point(face);
  if (info.rules) byId('rules-file').textContent = `Rules are kept in ${info.rules}.`;
  if (!info.changes) {
    byId('cannot').hidden = false;
    byId('cannot').textContent = 'This result cannot be changed: it takes one of gpvc texture --editable, with its scene and photos.';
    for (const button of document.querySelectorAll('#change button, #change select')) button.disabled = true;
  }
  const act = {
    ask: (x, y, measures) => {
      const found = stage.pick(x, y);
      if (!found) return;
      showTab('ask');
      return page.ask.click(found, measures || byId('measures').checked);
    },
    brush: (x, y, removes) => page.change.brush(x, y, removes),
    polygon: (points, removes) => page.change.polygon(points, removes),
    chart: (x, y, removes) => {
      const found = stage.pick(x, y);
      if (found) return page.change.chart(found.model.data.faces[found.face], removes);
    },
  };
  page.pointer = new Pointer(stage, byId('outline'), act);
  for (const button of document.querySelectorAll('[data-tool]'))
    button.addEventListener('click', () => {
      for (const other of document.querySelectorAll('[data-tool]')) other.classList.toggle('chosen', other === button);
      page.pointer.set(button.dataset.tool);
    });
}

function setUpShare(page) {
  const { stage } = page, link = () => linkOf(stage, stage.models[0].origin, page.colours.name ?? 'none');
  page.go = async () => {
    const place = placeIn(location.hash, stage.models[0].origin);
    if (!place) return;
    stage.place(place);
    page.divide?.(place.split);
    await page.colours.show(place.mode);
  };
  addEventListener('hashchange', page.go);
  byId('link').addEventListener('click', async () => {
    history.replaceState(null, '', link());
    byId('link-text').textContent = location.href;
    await navigator.clipboard?.writeText(location.href).catch(() => {});
  });
  byId('save').addEventListener('click', async () => {
    try {
      const file = await picture(stage, Number(byId('width').value));
      const anchor = Object.assign(document.createElement('a'), { href: URL.createObjectURL(file), download: 'view.png' });
      anchor.click();
      setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
    } catch (error) {
      say(error.message);
    }
  });
}

async function main() {
  for (const button of document.querySelectorAll('[data-tab]')) button.addEventListener('click', () => showTab(button.dataset.tab));
  const info = await getJson('page.json'), tiles = info.tileset ? await Tiles.load() : null, page = new Page(info, tiles);
  document.title = `${info.tileset ?? info.results[0].name} – gpvc view`;
  if (info.live)
    listen((news) => page.change?.hear(news, () => page.reload()).catch((error) => say(error.message)),
      (gone) => gone && say('gpvc view has ended: the page shows what it has, and answers nothing more.'));
  if (tiles) page.loadTiles();
  else await page.load(info.results.length > 1 ? [0, 1] : [0]);
  setUpLook(page);
  setUpBeside(page);
  setUpTools(page);
  setUpShare(page);
  await page.go();
  say(tiles ? '' : 'Loading the texture ...');
  const { stage } = page;
  let later = 0;
  stage.onFrame.push(() => {
    byId('rate').textContent = stage.frames.rate > 1 ? `${stage.frames.rate.toFixed(0)} frames a second` : '';
    clearTimeout(later);
    later = setTimeout(() => stage.models.forEach((model) => model.sharpen(stage.camera, stage.canvas.height, stage.most)), 200);
  });
  stage.redraw();
  Promise.resolve(page.textured).then(() => (document.documentElement.dataset.textured = 'yes'));
  window.view = page; // for tests and for those who write scripts
  document.documentElement.dataset.ready = 'yes';
}

main().catch((error) => say(error.message));
