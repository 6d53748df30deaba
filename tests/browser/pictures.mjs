// Pictures held against each other, in a page.
async function greyLevels(url, width, height) {
  const bitmap = await createImageBitmap(await (await fetch(url)).blob());
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext('2d');
  context.drawImage(bitmap, 0, 0);
  const pixels = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
  if (bitmap.width % width || bitmap.height % height)
    throw new Error(`${bitmap.width} x ${bitmap.height} is no multiple of ${width} x ${height}`);
  // Means of blocks, channel after channel.
  const step = bitmap.width / width, means = new Float64Array(3 * width * height);
  for (let y = 0; y < height * step; ++y)
    for (let x = 0; x < width * step; ++x)
      for (let c = 0; c < 3; ++c)
        means[c * width * height + Math.floor(y / step) * width + Math.floor(x / step)] +=
          pixels[4 * (y * bitmap.width + x) + c] / step / step;
  return means;
}

/// Mean absolute difference in grey levels, the share of values more than 16 apart, and the correlation, of two
/// pictures reduced to width x height.
export async function compare(one, other, width, height) {
  const a = await greyLevels(one, width, height), b = await greyLevels(other, width, height);
  let sum = 0, far = 0, ma = 0, mb = 0;
  for (let i = 0; i < a.length; ++i) {
    sum += Math.abs(a[i] - b[i]);
    far += Math.abs(a[i] - b[i]) > 16 ? 1 : 0;
    ma += a[i] / a.length;
    mb += b[i] / b.length;
  }
  let ab = 0, aa = 0, bb = 0;
  for (let i = 0; i < a.length; ++i) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) ** 2;
    bb += (b[i] - mb) ** 2;
  }
  return { mean: sum / a.length, far: far / a.length, correlation: ab / Math.sqrt(aa * bb) };
}
