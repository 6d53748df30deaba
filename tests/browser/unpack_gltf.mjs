// A GLB whose arrays EXT_meshopt_compression packs as one that holds them as they are, by three.js' decoder, for tools that do
// not know the extension.
const kExtension = 'EXT_meshopt_compression';
const padded = (length) => Math.ceil(length / 4) * 4;

/// \param bytes a Buffer of a GLB; returned as it is where nothing is packed \param modules folder of npm's packages
export async function unpackedGlb(bytes, modules) {
  if (bytes.toString('latin1', 0, 4) !== 'glTF') return bytes;
  const jsonBytes = bytes.readUInt32LE(12), gltf = JSON.parse(bytes.toString('utf8', 20, 20 + jsonBytes));
  if (!gltf.extensionsUsed?.includes(kExtension)) return bytes;
  const { MeshoptDecoder } = await import(`${modules}/three/examples/jsm/libs/meshopt_decoder.module.js`);
  await MeshoptDecoder.ready;
  const binary = bytes.subarray(28 + jsonBytes);
  const parts = [];
  let length = 0;
  for (const view of gltf.bufferViews) {
    const packed = view.extensions?.[kExtension], { byteOffset = 0, byteLength } = packed ?? view;
    let part = binary.subarray(byteOffset, byteOffset + byteLength);
    if (packed) {
      part = Buffer.alloc(packed.count * packed.byteStride);
      if (part.length !== view.byteLength) throw new Error('a packed view holds another number of bytes than it says');
      MeshoptDecoder.decodeGltfBuffer(part, packed.count, packed.byteStride,
                                      binary.subarray(byteOffset, byteOffset + byteLength), packed.mode, packed.filter);
    }
    delete view.extensions;
    Object.assign(view, { buffer: 0, byteOffset: length });
    parts.push(part, Buffer.alloc(padded(part.length) - part.length));
    length += padded(part.length);
  }
  gltf.buffers = [{ byteLength: length }];
  for (const list of ['extensionsUsed', 'extensionsRequired']) {
    gltf[list] = gltf[list]?.filter((name) => name !== kExtension);
    if (!gltf[list]?.length) delete gltf[list];
  }
  const text = Buffer.from(JSON.stringify(gltf)), json = Buffer.alloc(padded(text.length), ' ');
  text.copy(json);
  const head = Buffer.alloc(20), chunk = Buffer.alloc(8);
  [0x46546C67, 2, 28 + json.length + length, json.length, 0x4E4F534A].forEach((word, n) => head.writeUInt32LE(word, 4 * n));
  [length, 0x004E4942].forEach((word, n) => chunk.writeUInt32LE(word, 4 * n));
  return Buffer.concat([head, json, chunk, ...parts]);
}
