// Opens the page that reproduce_paper.sh makes in headless Chromium: tables with the paper's numbers beside ours, figures as
// pictures, curves over epsilon. Then breaks it in one place after another and insists that this is noticed.
//
//   node paper_browser.mjs FOLDER_OF_PAGE SCRATCH
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

import { insist, insistOnBreakages, insistOnWidth, withPage } from './browser.mjs';

const [folder, scratch] = process.argv.slice(2).map((path) => resolve(path));
mkdirSync(scratch, { recursive: true });
const html = readFileSync(join(folder, 'index.html'), 'utf8');

async function look(page, file) {
  page.problems.length = 0;
  await page.open(pathToFileURL(file).href);
  insist(page.problems.length === 0, page.problems.join('\n'));
  const sections = await page.evaluate(`[...document.querySelectorAll('section')].map((place) => ({
    title: place.querySelector('h2').textContent, said: place.querySelector('.verdict')?.textContent ?? '',
    text: place.textContent, pictures: place.querySelectorAll('img').length, lines: place.querySelectorAll('polyline').length,
  }))`);
  const section = (start) => sections.find(({ title }) => title.startsWith(start)) ?? { said: '', text: '', pictures: 0, lines: 0 };
  // A number of the paper in each table, and what is said of ours.
  for (const [table, number] of [[1, '4718 · 99.13 %'], [2, '4735 · 99.30 %'], [3, '9604 · 50.00 %'], [4, '4802 · 100.00 %'], [5, '4717 · 99.11 %'], [6, '4802 · 100.00 %']]) {
    insist(section(`Table ${table}:`).text.includes(number), `table ${table} lacks the paper's ${number}`);
    insist(section(`Table ${table}:`).said.length > 40, `nothing is said of table ${table}`);
  }
  for (const table of [1, 2, 3, 4]) insist(section(`Table ${table}:`).lines === 6, `table ${table} has not three models of the paper and of ours`);
  insist(section('Figure 15').said.includes('as in the paper') && section('Figure 15').pictures === 2, 'figure 15 does not show its effect');
  insist(section('Figure 21').pictures > 2 && section('Figure 25').pictures > 3, 'the figures have no pictures');
  insist(section('No epsilon').lines > 0, 'agreement is not plotted over epsilon');
  const widths = await page.evaluate(`Promise.all([...document.images].map((image) => {
    image.loading = 'eager';
    return image.decode().then(() => image.naturalWidth, () => 0);
  }))`);
  insist(widths.length > 0 && widths.every((width) => width > 0), `pictures ${widths} px wide`);
}

const kBreakages = [
  ['no tables', "accuracyOverEpsilon(1, '", "((...unused) => 0)(1, '"],
  ['another number', '6 4718 99.13', '6 4719 99.14'],
  ['no figure 15', '\nfigure15();', ''],
  ['no pictures', "if (byId('scene').value) showScene();", ''],
  ['no curves over epsilon', '\noverEpsilon();', ''],
];

await withPage({ width: 1280, height: 900 }, async (page) => {
  await look(page, join(folder, 'index.html'));
  writeFileSync(join(scratch, 'paper.png'), await page.screenshot());
  await insistOnBreakages(page, html, kBreakages, join(folder, 'broken.html'), look);
  await page.command('Emulation.setDeviceMetricsOverride', { width: 360, height: 800, deviceScaleFactor: 1, mobile: false });
  await page.open(pathToFileURL(join(folder, 'index.html')).href);
  await insistOnWidth(page, 360);
});
