// view_model.mjs NODE_MODULES OUT MODEL [SCREENSHOT.png] [--cesium] [--lit] [--measure=MBIT]: three.js or CesiumJS in headless
// Chromium loads OUT/MODEL and draws it from the viewpoint of OUT/preview.png, which the picture must resemble; nothing may reach
// the console. --lit: the viewer lights it, so that only what is where is compared. --measure: it is drawn alone, over a line of so many
// megabits a second, for the seconds until it was loaded and until its first picture was there.
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname } from 'node:path';
import { fileURLToPath } from 'node:url';
import { withPage } from './browser.mjs';

const flags = process.argv.filter((argument) => argument.startsWith('--'));
const [modules, out, model, screenshot] = process.argv.slice(2).filter((argument) => !argument.startsWith('--'));
const viewer = flags.includes('--cesium') ? 'view_model_cesium.html' : 'view_model.html';
const lit = flags.includes('--lit'), measure = flags.find((flag) => flag.startsWith('--measure='))?.split('=')[1];
const { preview } = JSON.parse(readFileSync(`${out}/run.json`)).counts;

// Both pictures are means of 2 x 2 samples a pixel, of the same pages, with trilinear lookups, so what remains is
// this: three.js filters in linear light and preview.png does not, renderers choose mip levels differently, and
// silhouettes move by a fraction of a sample. In means of 8 x 8 pixels that is 0.2 levels on llvmpipe; a level leaves
// room for other drivers. A page that is missing, turned over or displaced by 16 texels is far beyond, which is
// tried below.
const kMean = 1, kFar = 0.002, kCorrelation = 0.995, kBlock = 8;
const kLitCorrelation = 0.9;
const resembles = (d) => lit ? d.correlation >= kLitCorrelation
                             : d.mean <= kMean && d.far <= kFar && d.correlation >= kCorrelation;
const told = (d) => `mean difference ${d.mean.toFixed(2)} levels, ${(100 * d.far).toFixed(2)} % beyond 16, ` +
                    `correlation ${d.correlation.toFixed(4)}`;
const problems = [];

await withPage({ folders: { '/': dirname(fileURLToPath(import.meta.url)), '/out/': out, '/three/': `${modules}/three`,
                            '/cesium/': `${modules}/cesium/Build/Cesium` },
                 width: preview.width, height: preview.height, seconds: 240 }, async (page) => {
  await page.open(`/${viewer}`);
  if (measure)
    await page.command('Network.emulateNetworkConditions',
                       { offline: false, latency: 20, downloadThroughput: measure * 1e6 / 8, uploadThroughput: 1e6 });
  const drawn = await page.evaluate(
    `show('/out/${encodeURIComponent(model)}', ${JSON.stringify(preview)}, ${JSON.stringify(preview.background)}, 2)`);
  console.log(`${model}: ${JSON.stringify(drawn)}`);
  if (measure) return screenshot && writeFileSync(screenshot, await page.screenshot());
  const compare = async () => {
    const png = await page.screenshot();
    const width = preview.width / kBlock, height = preview.height / kBlock;
    return { png, ...await page.evaluate(
      `compare('data:image/png;base64,${png.toString('base64')}', '/out/preview.png', ${width}, ${height})`) };
  };
  const seen = await compare();
  console.log(`as it is: ${told(seen)}`);
  if (screenshot) writeFileSync(screenshot, seen.png);
  if (!resembles(seen)) problems.push(`the picture differs from preview.png: ${told(seen)}`);
  if (drawn.triangles === 0 || drawn.textures === 0) problems.push('nothing was drawn');
  if (lit && !drawn.withNormals) problems.push('nothing has normals');
  problems.push(...page.problems);
  for (const how of lit ? ['untextured'] : await page.evaluate('spoils')) {
    await page.evaluate(`spoil('${how}')`);
    const spoilt = await compare();
    console.log(`${how}: ${told(spoilt)}`);
    if (resembles(spoilt)) problems.push(`a model ${how} would pass: ${told(spoilt)}`);
  }
});
for (const problem of problems) console.error(problem);
process.exit(problems.length === 0 ? 0 : 1);
