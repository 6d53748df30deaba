// Opens the page of `gpvc compare` from disk in headless Chromium and uses it: other modes, the slider, the keyboard,
// the table, a narrow window. Then breaks the page in one place after another and insists that this is noticed.
//
//   node report_browser.mjs FOLDER_OF_REPORT SCRATCH [FOLDER_OF_ANOTHER]
//
// FOLDER_OF_ANOTHER: a report in which the gpvc model of the first one is an external one called 'again'.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

import { insist, insistOnBreakages, insistOnWidth, withPage } from './browser.mjs';

const [folder, scratch, other] = process.argv.slice(2).map((path) => resolve(path));
mkdirSync(scratch, { recursive: true });
const report = JSON.parse(readFileSync(join(folder, 'report.json'), 'utf8'));
const html = readFileSync(join(folder, 'report.html'), 'utf8');

/// In the page: what each canvas shows, and how varied its pixels are.
const kCanvases = `[...document.querySelectorAll('canvas')].map((canvas) => {
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  const colours = new Set();
  let hash = 0;
  for (let i = 0; i < data.length; i += 4) {
    const rgb = data[i] << 16 | data[i + 1] << 8 | data[i + 2];
    colours.add(rgb);
    hash = (Math.imul(hash, 31) + rgb) | 0;
  }
  return { shown: canvas.dataset.shown ?? '', colours: colours.size, hash };
})`;

/// Sets controls as a user does, and waits until every canvas says that it shows them.
async function choose(page, { left, right, split }) {
  await page.evaluate(`for (const [id, value] of Object.entries(${JSON.stringify({ left, right, split })})) {
    if (value === undefined) continue;
    const control = document.getElementById(id);
    control.value = value;
    control.dispatchEvent(new Event('input', { bubbles: true }));
  }`);
  return settled(page);
}

async function settled(page) {
  const expected = await page.evaluate(`['left', 'right', 'split'].map((id) => document.getElementById(id).value)`);
  const shown = `${expected[0]}|${expected[1]}|${expected[2]}`;
  for (let wait = 0; wait < 100; ++wait) {
    const canvases = await page.evaluate(kCanvases);
    if (canvases.length > 0 && canvases.every((canvas) => canvas.shown === shown)) return canvases;
    await new Promise((resume) => setTimeout(resume, 50));
  }
  throw new Error(`the canvases never showed ${shown}`);
}

const differing = (a, b) => a.filter((canvas, n) => canvas.hash !== b[n].hash).length;

async function use(page, file) {
  page.problems.length = 0;
  await page.open(pathToFileURL(file).href);
  const first = await settled(page);
  insist(first.length === report.crops.length, `${first.length} canvases for ${report.crops.length} crops`);
  first.forEach((canvas, n) => insist(canvas.colours > 16, `canvas ${n} is blank: ${canvas.colours} colours`));

  // The slider: all of the left at one end, all of the right at the other, something of both between.
  const left = await choose(page, { left: 'photo', right: 'none', split: 1000 });
  const right = await choose(page, { split: 0 });
  const between = await choose(page, { split: 400 });
  insist(differing(left, right) === left.length, 'the slider does not change every canvas');
  insist(differing(between, left) === left.length && differing(between, right) === left.length, 'the slider has no middle');

  // The modes: another right side is another picture, whatever the left side is.
  const ours = await choose(page, { right: 'gpvc', split: 0 });
  insist(differing(right, ours) > 0, 'none and gpvc look the same everywhere');
  insist(differing(await choose(page, { left: 'gpvc:uncorrected' }), ours) === 0, 'the left side shows at the right end');
  insist(differing(await choose(page, { left: 'none', split: 1000 }), right) === 0, 'none on the left is not none on the right');

  // The keyboard.
  const press = (key) => page.evaluate(`document.dispatchEvent(new KeyboardEvent('keydown', { key: '${key}', bubbles: true }))`);
  await press('p');
  insist(await page.evaluate(`document.getElementById('right').value`) === 'photo', 'p does not show the photo');
  await press(']');
  insist(await page.evaluate(`document.getElementById('right').value`) !== 'photo', '] does not change the mode');
  await settled(page);

  // The table: every mode has a row; a heading sorts by its column, the other way when pressed again.
  const names = `[...document.querySelectorAll('#table tbody th')].map((cell) => cell.firstChild.textContent)`;
  insist((await page.evaluate(names)).length === report.modes.length, 'a mode has no row');
  const column = `[...document.querySelectorAll('#table thead button')].findIndex((b) => b.textContent.startsWith('V: full'))`;
  const sorted = async () => page.evaluate(`(() => {
    const at = ${column};
    document.querySelectorAll('#table thead button')[at].click();
    return [...document.querySelectorAll('#table tbody tr')].map((row) => row.children[at].textContent.replace(/\\D/g, ''))
      .filter((text) => text !== '').map(Number);
  })()`);
  const rising = await sorted(), falling = await sorted();
  insist(rising.length > 1 && rising.every((value, n) => n === 0 || rising[n - 1] <= value), `not sorted: ${rising}`);
  insist(falling.join() === [...rising].reverse().join(), `not sorted the other way: ${falling}`);
  insist(await page.evaluate(`document.querySelectorAll('#table td.best').length`) > 0, 'no best value is marked');

  // What the page opens with: gpvc and each family before and after, then the curve, then the best and the worst of each.
  const opening = await page.evaluate(`[...document.querySelectorAll('#opening tbody th')].map((cell) => cell.textContent)`);
  const families = [...new Set(report.modes.map((mode) => mode.family))];
  const withBias = families.filter((family) => report.modes.some((mode) => mode.family === family && mode.epsilon !== null));
  insist(opening.length === families.length + withBias.length && opening[0] === 'gpvc', `the page opens with ${opening.join('; ')}`);
  insist(await page.evaluate(`document.querySelector('main > :not([hidden])').id`) === 'opening', 'the page does not open with its table');
  insist(await page.evaluate(`document.querySelectorAll('#plot circle').length`) > 1, 'the biases are not plotted');
  const strips = await page.evaluate(`Promise.all([...document.querySelectorAll('.strip img')].map((image) => {
    image.loading = 'eager';
    return image.decode().then(() => image.naturalWidth, () => 0);
  }))`);
  insist(strips.length === report.crops.length * 2 * (1 + withBias.length) && strips.every((width) => width > 0),
    `${strips.length} pictures of best and worst epsilons, widths ${strips}`);
  const biased = report.modes.filter((mode) => mode.epsilon !== null).length;
  insist(await page.evaluate(`document.querySelectorAll('#against tbody tr').length`) === biased, 'a mode with a bias is not compared with gpvc');
  insist(page.problems.length === 0, page.problems.join('\n'));
}

async function fits(page, file, width) {
  await page.command('Emulation.setDeviceMetricsOverride', { width, height: 800, deviceScaleFactor: 1, mobile: false });
  await page.open(pathToFileURL(file).href);
  await settled(page);
  await insistOnWidth(page, width);
}

const kBreakages = [
  ['no picture on the right', 'pen.drawImage(images[1], 0, 0);', ''],
  ['no picture on the left', 'if (at > 0) pen.drawImage(images[0]', 'if (false) pen.drawImage(images[0]'],
  ['a deaf slider', 'for (const control of [left, right, split])', 'for (const control of [left, right])'],
  ['sides exchanged', 'const wanted = [left.value, right.value];', 'const wanted = [right.value, left.value];'],
  ['no sorting', 'body.append(...rows.map(({ row }) => row));\n  }', '}'],
  ['no biases compared with gpvc', 'if (data.contest) showTable', 'if (false) showTable'],
  ['no table to begin with', 'if (data.opening) showTable', 'if (false) showTable'],
  ['no curve', '\n  showEpsilons();', ''],
  ['the best epsilons alone', "...ends.map(({ worst }) => worst)", ''],
  ['an error on the console', "'use strict';", "'use strict'; console.error('broken');"],
  ['a picture from elsewhere', '<header class="top">', '<img src="missing.png" alt=""><header class="top">'],
];

insist(html.length < 25e6, `the page has ${html.length} bytes`);
await withPage({ width: 1280, height: 900 }, async (page) => {
  const file = join(folder, 'report.html');
  await use(page, file);
  writeFileSync(join(scratch, 'report.png'), await page.screenshot({ whole: true }));
  await insistOnBreakages(page, html, kBreakages, join(scratch, 'broken.html'), use);
  for (const width of [360, 1280, 2200]) await fits(page, file, width);
});

const modeOf = (json, name) => json.modes.find((mode) => mode.name === name);
if (other) {
  // A model of another program: our own of the same scene, read from its file, scores what it scored before.
  const again = JSON.parse(readFileSync(join(other, 'report.json'), 'utf8'));
  const before = modeOf(report, 'gpvc').score, after = modeOf(again, 'again').score;
  for (const key of Object.keys(before)) {
    // The file's pages are JPEG, whose coarse chroma shows in differences of colour.
    const most = (key.startsWith('ciede2000') ? 0.05 : 0.02) * Math.abs(before[key]);
    insist(Math.abs(before[key] - after[key]) <= most, `${key}: ${before[key]} became ${after[key]}`);
  }
}
insist(modeOf(report, 'gpvc').oracle.agreement === 1, `gpvc agrees with the oracle in ${modeOf(report, 'gpvc').oracle.agreement}`);
insist(modeOf(report, 'none').oracle.agreement < 1, 'a mode without a test agrees with the oracle');
console.log(`${report.modes.length} modes, ${report.crops.length} crops, ${(html.length / 1e6).toFixed(1)} MB`);
