// Clicks on 200 points of the page of gpvc view and holds its answers against `gpvc photos`.
//
//   node ask_browser.mjs GPVC SCENE MESH RESULT SCRATCH [OPTION OF GPVC PHOTOS]...
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { insist, withPage } from '../browser/browser.mjs';
import { click, colours, pause, ready, run, served } from './serve.mjs';

const [gpvc, scene, mesh, result, scratch, ...options] = process.argv.slice(2);
const kPoints = 200, kWidth = 860, kHeight = 480, kPanel = 380;

/// Places of the canvas, the same in each run, spread evenly.
const places = Array.from({ length: 4 * kPoints }, (_, n) => [10 + ((n * 0.7548776662) % 1) * (kWidth - kPanel - 20), 10 + ((n * 0.5698402910) % 1) * (kHeight - 20)]);

await served(gpvc, [result, scene, mesh], (address) => withPage({ width: kWidth, height: kHeight }, async (page) => {
  const start = Date.now();
  await page.open(address);
  await ready(page);
  console.log(`ready ${Date.now() - start} ms after it was opened`);
  insist((await colours(page)) > 200, 'the page shows hardly a colour');
  await page.evaluate(`view.stage.fly(view.stage.overview({ center: view.stage.sphere.center, radius: 0.35 * view.stage.sphere.radius }))`);
  const found = [];
  for (const [x, y] of places) {
    if (found.length === kPoints) break;
    await page.evaluate('(view.ask.answer = view.ask.failed = null)');
    await click(page, x, y);
    const answer = await page.evaluate(`(async () => {
      if (!view.stage.pick(${x}, ${y})) return null;
      for (let i = 0; i < 500 && !view.ask.answer; ++i) await new Promise((done) => setTimeout(done, 10));
      return { answer: view.ask.answer, asked: view.ask.last };
    })()`);
    if (answer) found.push({ ...answer.answer, place: answer.asked.place, clicked: answer.asked.face });
  }
  insist(found.length === kPoints, `${found.length} of ${kPoints} clicks met the model`);
  const file = join(scratch, 'answers.json');
  run(gpvc, 'photos', scene, mesh, ...options, '--from', result, '--json', file, ...found.flatMap(({ place }) => ['--at', place.join(',')]));
  const expected = JSON.parse(readFileSync(file, 'utf8')).points;
  // On an edge the page asks about the face that was clicked, and the command about the first of the two.
  let same = 0, onFace = 0, onEdge = 0;
  found.forEach((answer, n) => {
    const shown = (photos) => photos.filter((photo) => photo.shows).map((photo) => photo.name).join();
    const reasons = (photos) => photos.map((photo) => `${photo.name} ${photo.reason}`).join();
    onFace += expected[n].faces.includes(answer.clicked);
    const isOther = answer.faces[0] !== expected[n].faces[0] && expected[n].faces.includes(answer.faces[0]);
    if (isOther) return void ++onEdge;
    same += shown(answer.photos) === shown(expected[n].photos) && reasons(answer.photos) === reasons(expected[n].photos);
  });
  console.log(`${same} of ${kPoints} answers are those of gpvc photos, ${onEdge} are about the other face of an edge; ${onFace} points lie on the face that was clicked`);
  insist(same + onEdge === kPoints, 'an answer differs');
  insist(onEdge <= 0.05 * kPoints, 'too many points lie on edges');
  insist(onFace >= 0.99 * kPoints, 'points do not lie on the faces that were clicked');
  await pause(page, 1000);
  writeFileSync(join(scratch, 'ask.png'), await page.screenshot());
  const strip = await page.evaluate(`[...document.querySelectorAll('#answer img')].map((image) => image.complete && image.naturalWidth === 160)`);
  insist(strip.length > 0 && strip[0], 'the strip of photos shows nothing');
  // Two points, the second with shift.
  await click(page, 150, 300);
  await pause(page, 500);
  await click(page, 330, 300, 8);
  await pause(page, 500);
  insist(await page.evaluate(`/^Distance [0-9.]+ /.test(document.querySelector('#answer .distance')?.textContent ?? '')`), 'two clicks measure nothing');
  insist(page.problems.length === 0, page.problems.join('\n'));
}));
