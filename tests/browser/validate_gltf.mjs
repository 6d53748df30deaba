// validate_gltf.mjs NODE_MODULES FILE...: Khronos' validator must have nothing to say, not even a hint. One remark is
// switched off: pages are cropped to their content, so their edges are no powers of two, which WebGL 1 alone minded.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';

const [modules, ...files] = process.argv.slice(2);
const validator = createRequire(`${modules}/`)('gltf-validator');
let good = files.length > 0;
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), {
    uri: file,
    maxIssues: 50,
    ignoredIssues: ['IMAGE_NPOT_DIMENSIONS'],
    externalResourceFunction: async (uri) =>
      new Uint8Array(readFileSync(join(dirname(file), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos + numHints} remarks, ` +
              `${report.info.totalTriangleCount} triangles, ${report.info.resources.length} resources`);
  for (const message of messages) console.log(JSON.stringify(message));
  good &&= messages.length === 0 && report.info.totalTriangleCount > 0;
}
process.exit(good ? 0 : 1);
