// What the page gets from its server, or from the folder that holds an export.

async function checked(answer) {
  if (!answer.ok) throw new Error((await answer.text()) || `the server answers ${answer.status}`);
  return answer;
}

export async function getJson(path) {
  return (await checked(await fetch(path))).json();
}

export async function getBytes(path) {
  return (await checked(await fetch(path))).arrayBuffer();
}

/// An image, its first row first. `longest`: texels of its edge, at most.
export async function getImage(path, longest = Infinity) {
  const blob = await (await checked(await fetch(path))).blob();
  const options = { premultiplyAlpha: 'none', colorSpaceConversion: 'none' };
  const image = await createImageBitmap(blob, options);
  const factor = Math.max(image.width, image.height) / longest;
  if (factor <= 1) return image;
  const resizeWidth = Math.floor(image.width / factor), resizeHeight = Math.floor(image.height / factor);
  return createImageBitmap(image, { ...options, resizeWidth, resizeHeight, resizeQuality: 'high' });
}

export async function post(path, json = {}) {
  const headers = { 'Content-Type': 'application/json' };
  return (await checked(await fetch(path, { method: 'POST', headers, body: JSON.stringify(json) }))).json();
}

/// Calls `hear` with what background runs report. As long as this page listens, the server stays.
export function listen(hear, lost) {
  const events = new EventSource('events');
  events.addEventListener('job', (event) => hear(JSON.parse(event.data)));
  events.onerror = () => lost(events.readyState === EventSource.CLOSED);
  events.onopen = () => lost(false);
  return events;
}
