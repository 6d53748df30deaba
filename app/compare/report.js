'use strict';
// What the page of a comparison and the paper's page share.
const byId = (id) => document.getElementById(id);
const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
const drawing = (tag, attributes, text) => {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text !== undefined) element.textContent = text;
  return element;
};
const grouped = (n) => String(Math.round(n)).replace(/\B(?=(\d{3})+$)/g, '\u202f');
const valueAt = (mode, path) => {
  const value = path.split('.').reduce((at, key) => (at && typeof at === 'object' ? at[key] : undefined), mode);
  return typeof value === 'number' ? value : null;
};
const scaleOf = (figure) => figure.unit === '%' ? 100 : 1;
const printed = (value, figure) => value === null ? '–'
  : figure.digits === 0 ? grouped(value) : (value * scaleOf(figure)).toFixed(figure.digits);
const kColours = { 'shadow-map:spc': '--spc', 'shadow-map:apc': '--apc', 'ray:sparse': '--sparse', 'ray:dense': '--dense' };

/// A table { title, note, columns, rows } of texts; row `ours` is marked. A cell is a text, that is "..., CLASS" where it
/// has a class, or [text, class].
const showTable = ({ title, note, columns, rows }, place, ours) => {
  const head = make('tr', {}, ...columns.map((name) => make('th', { scope: 'col', textContent: name })));
  const cell = (content) => {
    const [textContent, className] = Array.isArray(content) ? content : [content, content.split(', ')[1] ?? ''];
    return make('td', { textContent, className });
  };
  const body = rows.map(([name, ...cells], n) =>
    make('tr', { className: n === ours ? 'ours' : '' }, make('th', { scope: 'row', textContent: name }), ...cells.map(cell)));
  if (title) place.append(make('h2', { textContent: title }));
  if (note) place.append(make('p', { className: 'note', textContent: note }));
  place.append(make('div', { className: 'scroll', tabIndex: 0, role: 'region', ariaLabel: title || 'table' },
      make('table', {}, make('thead', {}, head), make('tbody', {}, ...body))));
};

/// Pictures in rows of `columns`: [{ src, caption }].
const showStrip = (pictures, place, columns) => {
  const figures = pictures.map(({ src, caption }) =>
    make('figure', {}, make('img', { src, alt: caption, loading: 'lazy' }), make('figcaption', { textContent: caption })));
  const strip = make('div', { className: 'strip' }, ...figures);
  strip.style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
  place.append(make('div', { className: 'strips', tabIndex: 0, role: 'region', ariaLabel: 'pictures side by side' }, strip));
};

/// A plot with its legend. `lines`: [{ name, colour, dashed, points: [{ x, y, title }] }], where x is a logarithm and
/// titled points have dots; `levels`: [{ name, colour, dashed, y }], the same for all x.
function showPlot({ title, across, digits, lines, levels = [] }, place) {
  const kWidth = 760, kHeight = 340, kLeft = 72, kRight = 20, kTop = 34, kBottom = 44;
  const points = lines.flatMap((line) => line.points);
  const values = [...points, ...levels].map(({ y }) => y), logs = points.map(({ x }) => x);
  const first = Math.min(...logs), last = Math.max(...logs);
  const low = Math.min(...values), high = Math.max(...values), range = high - low || Math.abs(high) || 1;
  // Ticks at 1, 2 or 5 times a power of ten; 1e-9 of a tick is what rounding leaves of whole numbers of them.
  const power = 10 ** Math.floor(Math.log10(range / 4)), step = power * [1, 2, 5, 10].find((n) => range / (n * power) <= 5);
  const least = Math.floor(low / step + 1e-9) * step, most = Math.max(least + step, Math.ceil(high / step - 1e-9) * step);
  const decimals = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const x = (log) => kLeft + 20 + (log - first) / (last - first || 1) * (kWidth - kLeft - kRight - 40);
  const y = (value) => kTop + (most - value) / (most - least) * (kHeight - kTop - kBottom);
  const svg = drawing('svg', { viewBox: `0 0 ${kWidth} ${kHeight}`, role: 'img', 'aria-label': title });
  for (let n = 0; n <= Math.round((most - least) / step); ++n) {
    const value = least + n * step;
    svg.append(drawing('line', { x1: kLeft, x2: kWidth - kRight, y1: y(value), y2: y(value), stroke: 'var(--line)' }),
      drawing('text', { x: kLeft - 8, y: y(value) + 4, 'text-anchor': 'end' },
        digits === 0 && decimals === 0 ? grouped(value) : value.toFixed(decimals)));
  }
  const decades = Math.ceil((last - first) / 12) || 1;  // a dozen labels fit
  for (let log = Math.ceil(first); log <= last; log += decades)
    svg.append(drawing('text', { x: x(log), y: kHeight - kBottom + 22, 'text-anchor': 'middle' }, `1e${log}`));
  svg.append(drawing('text', { x: (kLeft + kWidth - kRight) / 2, y: kHeight - 6, 'text-anchor': 'middle' }, across),
    drawing('text', { x: 14, y: 20 }, title));
  const stroke = ({ colour, dashed }, width) =>
    ({ fill: 'none', stroke: `var(${colour})`, 'stroke-width': width, 'stroke-dasharray': dashed ? '3 5' : 'none' });
  for (const level of levels)
    svg.append(drawing('line', { x1: kLeft, x2: kWidth - kRight, y1: y(level.y), y2: y(level.y), ...stroke(level, level.dashed ? 2 : 3) }));
  for (const line of lines) {
    svg.append(drawing('polyline', { points: line.points.map((p) => `${x(p.x)},${y(p.y)}`).join(' '), ...stroke(line, 2) }));
    for (const p of line.points.filter((point) => point.title)) {
      const dot = drawing('circle', { cx: x(p.x), cy: y(p.y), r: 4.5, fill: `var(${line.colour})` });
      dot.append(drawing('title', {}, p.title));
      svg.append(dot);
    }
  }
  const legend = [...levels, ...lines].map(({ name, colour, dashed }) => {
    const sample = make('i');
    sample.style.borderTop = `3px ${dashed ? 'dotted' : 'solid'} var(${colour})`;
    return make('li', {}, sample, name);
  });
  place.replaceChildren(make('div', {}, svg), make('ul', { className: 'legend' }, ...legend));
}

/// A figure of all modes of a report over what their epsilons bridge.
function showBias(report, figure, place) {
  const has = (mode) => valueAt(mode, figure.path) !== null, at = (mode) => valueAt(mode, figure.path) * scaleOf(figure);
  const biased = report.modes.filter((mode) => mode.epsilon !== null && has(mode));
  const lines = [...new Set(biased.map((mode) => mode.family))].map((family) => ({
    name: family, colour: kColours[family] ?? '--soft',
    points: biased.filter((mode) => mode.family === family).sort((a, b) => a.epsilon - b.epsilon).map((mode) =>
      ({ x: Math.log10(mode.depth_share), y: at(mode), title: `${mode.name}: ${printed(valueAt(mode, figure.path), figure)} ${figure.unit}` })),
  }));
  const levels = report.modes.filter((mode) => ['gpvc', 'none'].includes(mode.name) && has(mode))
    .map((mode) => ({ name: mode.name, colour: mode.name === 'gpvc' ? '--accent' : '--none', dashed: mode.name === 'none', y: at(mode) }));
  showPlot({
    title: `${figure.name}${figure.unit ? ', ' + figure.unit : ''} (${figure.better > 0 ? 'more' : 'less'} is better)`,
    across: 'what epsilon bridges, as a share of the median depth', digits: figure.digits, lines, levels,
  }, place);
}
