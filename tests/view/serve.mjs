// gpvc view for a test: its address, and its end.
import { spawn, spawnSync } from 'node:child_process';
import { insist } from '../browser/browser.mjs';

export function run(gpvc, ...words) {
  const { status, stderr, stdout } = spawnSync(gpvc, words, { encoding: 'utf8', maxBuffer: 1 << 28 });
  insist(status === 0, `gpvc ${words[0]}: ${stderr.slice(-1000)}`);
  return stdout;
}

/// Calls work(address) while `gpvc view WORDS` serves.
export async function served(gpvc, words, work) {
  const program = spawn(gpvc, ['view', ...words, '--no-browser'], { stdio: ['ignore', 'pipe', 'pipe'] });
  let said = '';
  program.stderr.on('data', (bytes) => (said += bytes));
  const ended = new Promise((resolve) => program.on('close', resolve));
  try {
    const address = await new Promise((resolve, reject) => {
      program.stdout.on('data', (bytes) => resolve(String(bytes).trim()));
      program.on('close', () => reject(new Error(`gpvc view ended: ${said}`)));
    });
    await work(address, () => said);
  } finally {
    program.kill('SIGINT');
    await ended;
  }
}

/// Waits until the page shows its results.
export async function ready(page) {
  await page.evaluate(`new Promise((done, fail) => {
    const start = performance.now(), look = setInterval(() => {
      const late = performance.now() - start > 30000;
      if (!document.documentElement.dataset.textured && !late) return;
      clearInterval(look);
      late ? fail(new Error(document.getElementById('message').textContent)) : done();
    }, 20);
  })`);
}

export const pause = (page, ms) => page.evaluate(`new Promise((done) => setTimeout(done, ${ms}))`);

/// Clicks as a mouse does, in CSS pixels of the window.
export async function click(page, x, y, modifiers = 0) {
  for (const type of ['mousePressed', 'mouseReleased'])
    await page.command('Input.dispatchMouseEvent', { type, x, y, button: 'left', clickCount: 1, modifiers });
}

/// The number of colours of the window, 5 bits a channel: a page that shows nothing has few.
export async function colours(page) {
  const png = (await page.screenshot()).toString('base64');
  return page.evaluate(`(async () => {
    const bitmap = new Image();
    bitmap.src = 'data:image/png;base64,${png}';
    await bitmap.decode();
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height), seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add((data[i] >> 3) * 1024 + (data[i + 1] >> 3) * 32 + (data[i + 2] >> 3));
    return seen.size;
  })()`.replace('await (await fetch(', 'await (await fetch('));
}
