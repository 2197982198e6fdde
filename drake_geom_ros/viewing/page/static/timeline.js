// The timeline over the whole width: minimum distance over time, what is proved, and the time of now.

const OUTCOMES = {clear: '#1a59ff', contact: '#f25900', unknown: '#9aa3ad'};
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const LEFT = 64, RIGHT = 14, TOP = 22, BOTTOM = 22, STRIP = 6;  // pixels around the plot

const clockText = element('span', {className: 'clock'});
const playButton = element('button', {onclick: () => send('play', {on: !state.clock?.playing})}, 'play');
const speedField = element('select', {
  'aria-label': 'speed', onchange: event => send('speed', {value: Number(event.target.value)}),
}, SPEEDS.map(speed => element('option', {value: speed, selected: speed === 1}, `${speed}×`)));
const plotPlace = element('div', {
  className: 'plot', role: 'slider', tabIndex: 0, 'aria-label': 'time of the motion',
});
const strip = drawn('svg'), cursor = drawn('line', {stroke: 'var(--violet)', 'stroke-width': 2});
const cover = drawn('svg');
cover.append(cursor);
plotPlace.append(strip, cover);
const proofText = element('div', {className: 'hint wide'});

$('timeline').append(element('div', {className: 'buttons'},
  element('div', {}, playButton,
    element('button', {title: 'one step back (,)', onclick: () => send('step', {count: -1})}, '‹'),
    element('button', {title: 'one step on (.)', onclick: () => send('step', {count: 1})}, '›')),
  element('div', {}, speedField, clockText),
  element('div', {}, element('button', {title: 'go to the time of the minimum distance', onclick: () => send('least')}, 'minimum')),
), plotPlace);

const width = () => Math.max(50, plotPlace.clientWidth - LEFT - RIGHT);
const xOf = time => LEFT + width() * (time - state.timeline.start) / Math.max(state.timeline.end - state.timeline.start, 1e-12);

function showPlot() {
  const line = state.timeline;
  $('timeline').hidden = !line;
  if (!line) return;
  const height = plotPlace.clientHeight, bottom = height - BOTTOM;
  const known = line.least.filter(value => value !== null);
  strip.replaceChildren();
  const high = known.length ? Math.max(...known) : 1, low = Math.min(0, ...known);
  const yOf = value => TOP + (bottom - STRIP - TOP) * (high - value) / Math.max(high - low, 1e-12);
  for (const tick of ticks(line.start, line.end, width() / 90)) {
    const x = xOf(tick);
    strip.append(drawn('line', {x1: x, x2: x, y1: TOP, y2: bottom, stroke: 'var(--line)'}),
      drawn('text', {x, y: height - 7, 'text-anchor': 'middle'}, `${+tick.toPrecision(6)} s`));
  }
  for (const tick of ticks(1000 * low, 1000 * high, 3)) {
    const y = yOf(tick / 1000);
    strip.append(drawn('line', {x1: LEFT, x2: LEFT + width(), y1: y, y2: y, stroke: 'var(--line)'}),
      drawn('text', {x: LEFT - 6, y: y + 4, 'text-anchor': 'end'}, `${+tick.toPrecision(6)} mm`));
  }
  if (low < 0) {
    strip.append(drawn('rect', {x: LEFT, y: yOf(0), width: width(), height: Math.max(0, yOf(low) - yOf(0)), fill: '#f25900', opacity: 0.18}));
  }
  const parts = [[]];
  line.times.forEach((time, row) => {
    if (line.least[row] === null) parts.push([]);
    else parts.at(-1).push(`${xOf(time).toFixed(1)},${yOf(line.least[row]).toFixed(1)}`);
  });
  for (const points of parts.filter(part => part.length)) {
    strip.append(drawn('polyline', {points: points.join(' '), fill: 'none', stroke: 'var(--blue)', 'stroke-width': 1.6}));
  }
  strip.append(drawn('text', {x: 4, y: 10},
    `minimum distance of ${line.about ? `pairs ${line.about}` : 'all pairs'}`));
  showOutcomes(line, bottom);
  showCursor();
}

/** Draw what is proved as a strip below the curve, one rectangle for each run of equal outcomes. */
function showOutcomes(line, bottom) {
  let first = 0;
  line.outcomes.forEach((outcome, row) => {
    if (row + 1 < line.outcomes.length && line.outcomes[row + 1] === outcome) return;
    const x = xOf(line.times[first]);
    const mark = drawn('rect', {x, y: bottom - STRIP, height: STRIP, width: Math.max(0.5, xOf(line.times[row + 1]) - x), fill: OUTCOMES[outcome], 'data-outcome': outcome});
    mark.append(drawn('title', {}, `${outcome}, for all times of a piece that is straight from pose to pose`));
    strip.append(mark);
    first = row + 1;
  });
  if (line.unproved) notify(`nothing is proved between the moments: ${line.unproved}`, 6);
}

function showCursor() {
  const {timeline: line, clock} = state;
  if (!line || !clock) return;
  const x = xOf(clock.time), row = line.times.findIndex(time => time >= clock.time - 1e-9);
  for (const [name, value] of Object.entries({x1: x, x2: x, y1: TOP, y2: plotPlace.clientHeight - BOTTOM})) cursor.setAttribute(name, value);
  const least = line.least[row];
  clockText.textContent = `${clock.time.toFixed(2)} s`;
  plotPlace.setAttribute('aria-valuenow', clock.time);
  plotPlace.title = least === null || least === undefined ? '' : `minimum distance ${millimetres(least)} at ${line.times[row].toFixed(2)} s`;
  playButton.textContent = clock.playing ? 'pause' : 'play';
  if (document.activeElement !== speedField) speedField.value = String(clock.speed);
}

const goTo = throttled(value => send('time', {value}));
function dragged(event) {
  const {left} = plotPlace.getBoundingClientRect();
  const share = Math.min(1, Math.max(0, (event.clientX - left - LEFT) / width()));
  goTo(state.timeline.start + share * (state.timeline.end - state.timeline.start));
}
plotPlace.addEventListener('pointerdown', event => { plotPlace.setPointerCapture(event.pointerId); dragged(event); });
plotPlace.addEventListener('pointermove', event => { if (event.buttons) dragged(event); });
plotPlace.addEventListener('keydown', event => {
  const count = {ArrowLeft: -1, ArrowRight: 1, PageUp: 10, PageDown: -10}[event.key];
  if (count) { send('step', {count}); event.preventDefault(); }
});
on('timeline', showPlot);
on('clock', showCursor);
new ResizeObserver(() => state.timeline && showPlot()).observe(plotPlace);
