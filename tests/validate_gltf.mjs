// validate_gltf.mjs NODE_MODULES FILE.glb: Khronos' validator must have nothing to say, neither error nor warning.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const [modules, file] = process.argv.slice(2);
const validator = createRequire(`${modules}/`)('gltf-validator');
const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 50 });
const { numErrors, numWarnings, messages } = report.issues;
console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${report.info.totalTriangleCount} triangles`);
for (const message of messages.filter((m) => m.severity <= 1)) console.log(JSON.stringify(message));
process.exit(numErrors + numWarnings === 0 && report.info.totalTriangleCount > 0 ? 0 : 1);
