// open_tileset.mjs NODE_MODULES FOLDER [PICTURE_STEM]: FOLDER/index.html in headless Chromium. With CesiumJS beside it the page
// must show the tileset, and tell of a face that is clicked which photo it shows; without, how to open it. PICTURE_STEM_shown.png
// and _how.png are what was seen.
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { insist, withPage } from './browser.mjs';

const [modules, folder, stem] = process.argv.slice(2);
const kWidth = 960, kHeight = 640;

const keep = async (page, name) => stem && writeFileSync(`${stem}_${name}.png`, await page.screenshot());
const wait = async (page, condition) => {
  while (!(await page.evaluate(`Boolean(${condition})`))) await new Promise((resolve) => setTimeout(resolve, 200));
};

async function click(page, x, y) {
  for (const type of ['mousePressed', 'mouseReleased'])
    await page.command('Input.dispatchMouseEvent', { type, x, y, button: 'left', clickCount: 1 });
  await new Promise((resolve) => setTimeout(resolve, 500));
  return page.evaluate('document.getElementById("face").textContent');
}

async function open(page) {
  await page.open('/index.html');
  await wait(page, 'window.tileset?.tilesLoaded && window.tileset.statistics.visited > 0');
  await keep(page, 'shown');
  const photos = new Set(JSON.parse(readFileSync(join(folder, 'views.json'), 'utf8')).views.map(({ name }) => name));
  const said = [];
  for (const x of [0.4, 0.5, 0.6]) for (const y of [0.45, 0.55]) said.push(await click(page, x * kWidth, y * kHeight));
  const named = said.map((text) => text.match(/^(.*), ([0-9.e-]+) a pixel$/)).filter(Boolean);
  console.log(`clicks tell: ${said.join('; ')}`);
  insist(named.length >= said.length / 2, `few clicks tell a photo: ${said.join('; ')}`);
  for (const [, name, gsd] of named) insist(photos.has(name) && Number(gsd) > 0, `${name} is no photo of views.json`);
  insist(new Set(named.map(([, name]) => name)).size > 1, 'all faces show one photo');
  insist(page.problems.length === 0, page.problems.join('; '));
}

async function openWithout(page) {
  await page.open('/index.html');
  await keep(page, 'how');
  const text = await page.evaluate('document.body.innerText');
  insist(text.includes('python3 -m http.server') && text.includes('Build/Cesium'), `the page says: ${text}`);
}

try {
  const window = { width: kWidth, height: kHeight, seconds: 240 };
  await withPage({ folders: { '/': folder, '/cesium/': join(modules, 'cesium/Build/Cesium') }, ...window }, open);
  await withPage({ folders: { '/': folder }, ...window }, openWithout);
} catch (error) {
  console.error(`${folder}: ${error.message}`);
  process.exit(1);
}
