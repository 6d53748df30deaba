// Headless Chromium for tests, over the DevTools protocol on a pipe: no package beyond Node and Chromium.
//
//   import { withPage } from './browser.mjs';
//   await withPage({ folders: { '/': REPORT_FOLDER }, width: 1280, height: 800 }, async (page) => {
//     await page.open('/report.html');                   // or any URL, also file:///...; ends after the load event
//     const rows = await page.evaluate('document.querySelectorAll("tr").length');   // promises are awaited
//     writeFileSync('report.png', await page.screenshot());    // PNG of the window; { whole: true }: of the page
//     if (page.problems.length > 0) throw new Error(page.problems.join('\n'));
//   });
//
// `folders` are served on a port of this machine: URL prefix to folder. `problems` collects console errors and
// warnings, uncaught exceptions, and requests that failed or were answered with an error. WebGL draws on the CPU
// (SwiftShader), so pictures do not depend on a graphics card. The browser is `chromium`, or what the variable
// CHROMIUM names; a page that does not answer within `seconds` (60) is an error. Nothing outside this machine can be
// reached: a page that needs the network has a problem.
import { spawn } from 'node:child_process';
import { createReadStream, existsSync, mkdtempSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { extname, join, normalize } from 'node:path';

const kTypes = {
  '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css',
  '.json': 'application/json', '.gltf': 'model/gltf+json', '.glb': 'model/gltf-binary', '.bin': 'application/octet-stream',
  '.png': 'image/png', '.jpg': 'image/jpeg', '.svg': 'image/svg+xml',
};

/// Serves folders under their prefixes, the longest prefix first. Returns the server and its address.
async function serve(folders) {
  const prefixes = Object.keys(folders).sort((a, b) => b.length - a.length);
  const server = createServer((request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://local').pathname));
    if (path === '/favicon.ico') return response.writeHead(204).end();
    const prefix = prefixes.find((p) => path.startsWith(p));
    const file = prefix === undefined ? '' : join(folders[prefix], path.slice(prefix.length));
    if (!existsSync(file) || !statSync(file).isFile()) return response.writeHead(404).end();
    response.writeHead(200, { 'Content-Type': kTypes[extname(file).toLowerCase()] ?? 'application/octet-stream' });
    createReadStream(file).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { server, address: `http://127.0.0.1:${server.address().port}` };
}

/// The protocol: numbered commands out on file 3, answers and events in on file 4, each ended by a zero byte.
class Connection {
  constructor(process) {
    this.process = process;
    this.waiting = new Map();
    this.listeners = [];
    this.number = 0;
    let rest = [];
    process.stdio[4].on('data', (bytes) => {
      for (let end = bytes.indexOf(0); end >= 0; end = bytes.indexOf(0)) {
        const message = Buffer.concat([...rest, bytes.subarray(0, end)]).toString();
        rest = [];
        bytes = bytes.subarray(end + 1);
        this.receive(JSON.parse(message));
      }
      if (bytes.length > 0) rest.push(bytes);
    });
    process.stdio[3].on('error', () => {});
    process.on('exit', (code) => this.end(new Error(`Chromium ended (${code})`)));
    process.on('error', (error) => this.end(error));
  }
  receive(message) {
    const command = this.waiting.get(message.id);
    this.waiting.delete(message.id);
    if (!command) return this.listeners.forEach((listen) => listen(message));
    if (message.error) command.reject(new Error(`${command.method}: ${message.error.message}`));
    else command.resolve(message.result);
  }
  end(error) {
    this.error = error;
    for (const command of this.waiting.values()) command.reject(error);
    this.waiting.clear();
  }
  send(method, params = {}, sessionId = undefined) {
    if (this.error) return Promise.reject(this.error);
    return new Promise((resolve, reject) => {
      const id = ++this.number;
      this.waiting.set(id, { method, resolve, reject });
      this.process.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + '\0');
    });
  }
}

const textOf = (remote) => remote.description ?? (remote.value === undefined ? remote.type : String(remote.value));

class Page {
  constructor(connection, session, address, seconds) {
    Object.assign(this, { connection, session, address, seconds, problems: [] });
    this.urls = new Map();
    connection.listeners.push((event) => event.sessionId === session && this.note(event.method, event.params));
  }
  note(method, params) {
    if (method === 'Page.loadEventFired') this.loaded?.();
    if (method === 'Network.requestWillBeSent') this.urls.set(params.requestId, params.request.url);
    if (method === 'Runtime.exceptionThrown') {
      const details = params.exceptionDetails;
      this.problems.push(`exception: ${details.exception ? textOf(details.exception) : details.text}`);
    }
    if (method === 'Runtime.consoleAPICalled' && ['error', 'warning', 'assert'].includes(params.type))
      this.problems.push(`console ${params.type}: ${params.args.map(textOf).join(' ')}`);
    if (method === 'Log.entryAdded' && params.entry.source !== 'network' && ['error', 'warning'].includes(params.entry.level))
      this.problems.push(`${params.entry.source} ${params.entry.level}: ${params.entry.text}`);
    if (method === 'Network.responseReceived' && params.response.status >= 400)
      this.problems.push(`request: ${params.response.url} was answered with ${params.response.status}`);
    if (method === 'Network.loadingFailed')
      this.problems.push(`request: ${this.urls.get(params.requestId) ?? 'a request'} failed: ${params.errorText}`);
  }
  async command(method, params) {
    let timer;
    const late = new Promise((_, reject) => {
      timer = setTimeout(() => reject(new Error(`${method} took more than ${this.seconds} s; problems so far: ` +
                                                (this.problems.join('; ') || 'none'))), this.seconds * 1000);
    });
    try {
      return await Promise.race([this.connection.send(method, params, this.session), late]);
    } finally {
      clearTimeout(timer);
    }
  }
  async open(url) {
    const loaded = new Promise((resolve) => (this.loaded = resolve));
    const full = new URL(url, this.address).href;
    const { errorText } = await this.command('Page.navigate', { url: full });
    if (errorText) throw new Error(`${full}: ${errorText}`);
    let timer;
    const late = new Promise((_, reject) => {
      timer = setTimeout(() => reject(new Error(`${full} was not loaded within ${this.seconds} s`)), this.seconds * 1000);
    });
    await Promise.race([loaded, late]).finally(() => clearTimeout(timer));
  }
  async evaluate(expression) {
    const { result, exceptionDetails } = await this.command('Runtime.evaluate',
      { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception ? textOf(exceptionDetails.exception) : exceptionDetails.text);
    return result.value;
  }
  async screenshot({ whole = false } = {}) {
    const { data } = await this.command('Page.captureScreenshot', { format: 'png', captureBeyondViewport: whole });
    return Buffer.from(data, 'base64');
  }
}

function start(profile, width, height) {
  const flags = ['--headless=new', '--remote-debugging-pipe', '--no-sandbox', '--disable-dev-shm-usage',
    '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--force-device-scale-factor=1',
    '--force-color-profile=srgb', '--hide-scrollbars', '--no-first-run', '--disable-extensions', '--disable-sync',
    '--disable-background-networking', '--disable-component-update', '--disable-default-apps',
    '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1', `--user-data-dir=${profile}`,
    `--window-size=${width},${height}`, 'about:blank'];
  return spawn(process.env.CHROMIUM ?? 'chromium', flags, { stdio: ['ignore', 'ignore', 'pipe', 'pipe', 'pipe'] });
}

export const insist = (truth, sentence) => {
  if (!truth) throw new Error(sentence);
};

/// Insists that look(page, FILE) fails for each broken copy of a page of this HTML, which is written to COPY. Of a breakage the
/// name, what stands in the page, and what takes its place.
export async function insistOnBreakages(page, html, breakages, copy, look) {
  for (const [what, whole, broken] of breakages) {
    insist(html.includes(whole), `the page has no place to break: ${what}`);
    writeFileSync(copy, html.replace(whole, () => broken));
    const noticed = await look(page, copy).then(() => '', (error) => error.message);
    insist(noticed !== '', `nothing was noticed of a page with ${what}`);
    console.log(`${what}: ${noticed.split('\n')[0]}`);
  }
}

/// Insists that the open page needs no scrolling sideways.
export async function insistOnWidth(page, width) {
  const wide = await page.evaluate('document.documentElement.scrollWidth');
  insist(wide <= width, `at ${width} px the page is ${wide} px wide`);
}

export async function withPage({ folders = {}, width = 1280, height = 800, seconds = 60 }, work) {
  const profile = mkdtempSync(join(tmpdir(), 'gpvc-browser-'));
  const { server, address } = await serve(folders);
  const browser = start(profile, width, height);
  let words = '';
  browser.stderr.on('data', (bytes) => (words = (words + bytes).slice(-4000)));
  const ended = new Promise((resolve) => browser.on('close', resolve));
  try {
    const connection = new Connection(browser);
    const { targetId } = await connection.send('Target.createTarget', { url: 'about:blank' });
    const { sessionId } = await connection.send('Target.attachToTarget', { targetId, flatten: true });
    const page = new Page(connection, sessionId, address, seconds);
    for (const domain of ['Page', 'Runtime', 'Log', 'Network']) await page.command(`${domain}.enable`);
    await page.command('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: false });
    return await work(page);
  } catch (error) {
    if (/Chromium ended/.test(error.message)) error.message += `\n${words}`;
    throw error;
  } finally {
    browser.kill('SIGKILL');
    await Promise.race([ended, new Promise((resolve) => setTimeout(resolve, 5000))]);
    server.closeAllConnections?.();
    server.close();
    rmSync(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
  }
}
