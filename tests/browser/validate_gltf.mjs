// validate_gltf.mjs NODE_MODULES FILE...: Khronos' validator must have nothing to say, not even a hint. One remark is
// switched off: pages are cropped to their content, so their edges are no powers of two, which WebGL 1 alone minded. Of two
// extensions it knows the name and no more: it takes their columns for unused, which are held against their accessors here.
// What EXT_meshopt_compression packs is unpacked for it, so that it sees every number. Of WebP it knows the name: the pictures are
// looked at by the viewers' tests.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { unpackedGlb } from './unpack_gltf.mjs';

const [modules, ...files] = process.argv.slice(2);
const validator = createRequire(`${modules}/`)('gltf-validator');

/// The buffer views of a GLB's columns. Throws where a column or a feature's number leads nowhere.
function columnsOf(bytes) {
  if (bytes.toString('latin1', 0, 4) !== 'glTF') return [];
  const gltf = JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
  const tables = gltf.extensions?.EXT_structural_metadata?.propertyTables ?? [];
  for (const { attributes, extensions } of gltf.meshes.flatMap(({ primitives }) => primitives))
    for (const { attribute, propertyTable, featureCount } of extensions?.EXT_mesh_features?.featureIds ?? [])
      if (!(`_FEATURE_ID_${attribute}` in attributes) || tables[propertyTable]?.count !== featureCount)
        throw new Error('features without numbers or table');
  return tables.flatMap(({ properties, count }) => Object.values(properties).flatMap(({ values, stringOffsets }) => {
    if (gltf.bufferViews[stringOffsets ?? values].byteLength !== 4 * (stringOffsets === undefined ? count : count + 1))
      throw new Error('a column is not as long as its table');
    return [values, stringOffsets];
  }));
}

let good = files.length > 0;
for (const file of files) {
  const bytes = await unpackedGlb(readFileSync(file), modules), columns = columnsOf(bytes).map((view) => `/bufferViews/${view}`);
  const isUnknown = ({ code, message, pointer }) =>
    (code === 'UNUSED_OBJECT' && columns.includes(pointer)) ||
    (code === 'UNSUPPORTED_EXTENSION' && /'EXT_(mesh_features|structural_metadata)'/.test(message));
  const report = await validator.validateBytes(new Uint8Array(bytes), {
    uri: file,
    maxIssues: 50,
    ignoredIssues: ['IMAGE_NPOT_DIMENSIONS'],
    externalResourceFunction: async (uri) =>
      new Uint8Array(readFileSync(join(dirname(file), decodeURIComponent(uri)))),
  });
  const messages = report.issues.messages.filter((message) => !isUnknown(message));
  const { numErrors, numWarnings } = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${messages.length} messages, ` +
              `${report.info.totalTriangleCount} triangles, ${report.info.resources.length} resources`);
  for (const message of messages) console.log(JSON.stringify(message));
  good &&= messages.length === 0 && report.info.totalTriangleCount > 0;
}
process.exit(good ? 0 : 1);
