// view_tileset.mjs NODE_MODULES FOLDER [PICTURE_STEM] [--cesium]: FOLDER/tileset.json as 3d-tiles-renderer (three.js) or
// CesiumJS shows it in headless Chromium to a camera that comes nearer: finer tiles must replace coarser ones, nothing
// may reach the console. PICTURE_STEM_far.png, _middle.png and _near.png are what was seen.
import { existsSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { insist, withPage } from './browser.mjs';

const viewer = process.argv.includes('--cesium') ? 'cesium' : 'three';
const [modules, folder, stem] = process.argv.slice(2).filter((argument) => argument !== '--cesium');
const kWidth = 960, kHeight = 640, kFieldOfView = Math.PI / 3, kBackground = [70, 90, 110];
// The error in pixels up to which both viewers show a tile instead of its children, unless they are told otherwise.
const kTolerated = 16;

const add = (a, b, scale = 1) => a.map((v, n) => v + scale * b[n]);
const length = (v) => Math.hypot(...v);
/// A 4 x 4 matrix, columns first, times (v, w).
const transformed = (m, v, w) =>
  [0, 1, 2].map((row) => m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * w);
const centreOf = ({ box }) => box.slice(0, 3);
const radiusOf = ({ box }) => length([3, 6, 9].map((at) => length(box.slice(at, at + 3))));

/// Every tile with its parent, the root first. Only the root may have a transform, so that all boxes are in its frame.
function listTiles(tile, parent = null) {
  insist(tile.boundingVolume?.box?.length === 12, 'a tile has no bounding box');
  insist(tile.content?.uri, 'a tile has no content');
  insist(existsSync(join(folder, tile.content.uri)), `there is no ${tile.content.uri}`);
  if (parent) {
    insist(tile.transform === undefined, `${tile.content.uri} has a transform, which only the root may have`);
    insist(tile.geometricError < parent.geometricError, `${tile.content.uri} has no smaller error than its parent`);
  }
  return [{ ...tile, parent }, ...(tile.children ?? []).flatMap((child) => listTiles(child, tile))];
}

/// Cameras in the tileset's frame, looking down to the north. Far: the tileset's sphere fills half the picture. Near: a
/// leaf in the tileset's middle fills it, or is so near that its parent's error is twice what is tolerated. Middle: as
/// many times nearer than far as it is farther than near.
function makeStops(root, tiles) {
  const middle = centreOf(root.boundingVolume), radius = radiusOf(root.boundingVolume);
  const offCentre = (tile) => length(add(centreOf(tile.boundingVolume), middle, -1));
  const leaf = tiles.filter((tile) => tile.parent && !tile.children?.length).sort((a, b) => offCentre(a) - offCentre(b))[0];
  insist(leaf, 'the root has no children');
  const filling = 1 / Math.sin(kFieldOfView / 2), pixelsAtOneMetre = kHeight / 2 / Math.tan(kFieldOfView / 2);
  const far = 2 * filling * radius;
  const near = Math.min(filling * radiusOf(leaf.boundingVolume),
                        leaf.parent.geometricError * pixelsAtOneMetre / (2 * kTolerated));
  const frame = root.transform ?? [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  const stop = (name, distance, target) => ({
    name, distance, radius, target: transformed(frame, target, 1), up: transformed(frame, [0, 0, 1], 0),
    eye: transformed(frame, add(target, [0, -Math.SQRT1_2, Math.SQRT1_2], distance), 1),
    near: distance / 100, far: distance + 4 * radius,
  });
  const focus = centreOf(leaf.boundingVolume);
  return [stop('far', far, middle), stop('middle', Math.sqrt(far * near), focus), stop('near', near, focus)];
}

/// In the page: the share of pixels that are not background, and the number of their colours, 5 bits a channel.
async function measure(png, background) {
  const bitmap = await createImageBitmap(await (await fetch(png)).blob());
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
  const colours = new Set();
  let covered = 0;
  for (let at = 0; at < data.length; at += 4) {
    if (background.every((v, n) => Math.abs(data[at + n] - v) < 8)) continue;
    ++covered;
    colours.add((data[at] >> 3) << 10 | (data[at + 1] >> 3) << 5 | data[at + 2] >> 3);
  }
  return { covered: covered / bitmap.width / bitmap.height, colours: colours.size };
}

const sizeOf = ({ content }) => statSync(join(folder, content.uri)).size;
const megabytes = (tiles) => (tiles.reduce((sum, tile) => sum + sizeOf(tile), 0) / 1e6).toFixed(2);

function findLoaded(page, tiles) {
  const requested = new Set([...page.urls.values()].map((url) => new URL(url).pathname));
  return tiles.filter(({ content }) => requested.has(`/tiles/${content.uri}`));
}

/// Looks from a stop once all is loaded. Returns the number of tiles loaded so far and the least error in view.
async function visit(page, stop, tiles) {
  const shown = await page.evaluate(`look(${JSON.stringify(stop)})`);
  const png = await page.screenshot();
  if (stem) writeFileSync(`${stem}_${stop.name}.png`, png);
  const picture = await page.evaluate(
    `(${measure})('data:image/png;base64,${png.toString('base64')}', ${JSON.stringify(kBackground)})`);
  const loaded = findLoaded(page, tiles);
  const error = Math.min(...shown.map((tile) => tiles.find(({ content }) => content.uri === tile.uri).geometricError));
  const faces = shown.reduce((sum, tile) => sum + tile.faces, 0);
  console.log(`${stop.name}, ${stop.distance.toPrecision(3)} m: ${shown.length} tiles of ${faces} faces in view, ` +
              `least error ${error.toPrecision(3)} m; ` +
              `${(100 * picture.covered).toFixed(1)} % covered in ${picture.colours} colours; ` +
              `loaded ${loaded.length} of ${tiles.length} tiles, ${megabytes(loaded)} of ${megabytes(tiles)} MB`);
  // 3d-tiles-renderer warns so of every tileset of 3D Tiles 1.1, which it shows all the same.
  const problems = page.problems.filter((problem) => !problem.includes('tiles versions at 1.1 or higher'));
  insist(problems.length === 0, `${stop.name}: ${problems.map((problem) => problem.split('\n')[0]).join('; ')}`);
  insist(faces > 0, `${stop.name}: no tile is in view`);
  for (const tile of shown)
    insist((tile.outside ?? 0) <= 1e-3 * stop.radius, `${tile.uri} reaches ${tile.outside} m out of its bounding box`);
  // The far sphere covers a tenth of the picture, a wall seen from its end far less. Untextured faces have one colour.
  insist(picture.covered > 0.0002 && picture.colours > 16, `${stop.name}: the picture shows no textured model`);
  return { loaded: loaded.length, error };
}

async function fly(page) {
  const { root } = JSON.parse(readFileSync(join(folder, 'tileset.json'), 'utf8'));
  const tiles = listTiles(root);
  await page.open(`/view_tileset_${viewer}.html`);
  await page.evaluate(`start('/tiles/tileset.json', ${kWidth}, ${kHeight}, ${kFieldOfView}, ${JSON.stringify(kBackground)})`);
  const seen = [];
  for (const stop of makeStops(root, tiles)) seen.push(await visit(page, stop, tiles));
  const [far, middle, near] = seen;
  insist(far.loaded <= middle.loaded && far.loaded < near.loaded, 'no tiles were loaded on the way from far to near');
  insist(far.error >= middle.error && middle.error >= near.error && far.error > near.error, 'nearer tiles are not finer');
}

try {
  await withPage({ folders: { '/': dirname(fileURLToPath(import.meta.url)), '/tiles/': folder, '/modules/': modules },
                   width: kWidth, height: kHeight, seconds: 240 }, fly);
} catch (error) {
  console.error(`${folder}: ${error.message}`);
  process.exit(1);
}
