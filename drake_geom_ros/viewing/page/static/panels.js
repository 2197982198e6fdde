// The tabs beside the picture, and what is selected.

const titled = (title, ...children) => [element('h2', {}, title), ...children];
const hint = text => element('p', {className: 'hint'}, text);

// What is selected.

function bodyDetails({letter, name, rows}, isOpen) {
  return element('details', {open: isOpen, 'data-letter': letter},
    element('summary', {}, element('span', {className: 'letter'}, letter), name),
    element('dl', {}, rows.map(([label, text]) => [element('dt', {}, label), element('dd', {}, text)])));
}

function pairDetails(pair, bodies) {
  if (!pair) return [];
  const [first, second] = [...bodies].sort((a, b) => a.id - b.id);
  const changes = state.kind?.live ? [] : [
    element('button', {onclick: () => send('declare', {allow: false})}, 'exclude this pair'),
    element('button', {onclick: () => send('declare', {allow: true})}, 'allow this pair')];
  const beyond = !pair.filter && pair.reported === false ? 'beyond max_distance, so in no table' : '';
  return [
    pair.reason ? element('p', {className: 'trouble'}, pair.reason) : element('div', {},
      element('span', {className: pair.distance < 0 ? 'distance overlap' : 'distance'}, millimetres(pair.distance)), ' ',
      element('span', {className: 'bound', title: 'certified: the true distance is no farther from this one'},
        `± ${pair.error_bound === null ? '∞' : pair.error_bound.toExponential(1)} m`)),
    hint(pair.filter ? `Queries leave this pair out: ${pair.filter}.` : `Queries report this pair${beyond && ` (${beyond})`}.`),
    pair.p_WCa ? element('dl', {},
      [[first, pair.p_WCa], [second, pair.p_WCb]].sort(([a], [b]) => (a.letter < b.letter ? -1 : 1)).map(([{letter}, point]) =>
        [element('dt', {}, `nearest on ${letter}`), element('dd', {}, `${point.map(value => value.toFixed(4)).join(' ')} m`)])) : null,
    element('div', {className: 'row'}, changes),
  ];
}

on('selection', ({bodies, pair}) => {
  const open = [...$('selection').querySelectorAll('details[open]')].map(each => each.dataset.letter);
  if (!bodies.length) {
    $('selection').replaceChildren(hint('Click on a body for its shape, pose and properties; on a second one for their distance.'));
    return;
  }
  const isOpen = letter => (bodies.length === 1 ? true : open.includes(letter) && open.length < 3);
  $('selection').replaceChildren(...pairDetails(pair, bodies),
    ...bodies.map(body => bodyDetails(body, isOpen(body.letter))),
    element('div', {className: 'row'},
      element('button', {onclick: () => send('fly')}, 'fly to it'),
      element('button', {title: 'Escape', onclick: () => send('select', {bodies: []})}, 'clear')));
});

// What is drawn.

const viewTab = element('div');
const option = (name, value) => send('option', {name, value});

function check(label, isOn, change) {
  return element('label', {}, element('input', {type: 'checkbox', checked: isOn, onchange: event => change(event.target.checked)}), label);
}

function toggled(list, name, isIn) {
  return isIn ? [...new Set([...list, name])] : list.filter(each => each !== name);
}

function range(label, low, high, step, value, change, unit = '') {
  const send = throttled(change);
  const slider = element('input', {type: 'range', min: low, max: high, step, value, 'aria-label': label});
  const field = element('input', {type: 'number', min: low, max: high, step: 'any', value: +value.toFixed(4), 'aria-label': `${label} ${unit}`});
  slider.addEventListener('input', () => { field.value = slider.value; send(Number(slider.value)); });
  field.addEventListener('change', () => { slider.value = field.value; send(Number(field.value)); });
  const set = now => {
    if (document.activeElement !== slider) slider.value = now;
    if (document.activeElement !== field) field.value = +now.toFixed(unit === '°' ? 2 : 4);
  };
  return {set, row: element('div', {className: 'field'}, element('span', {}, unit ? `${label} [${unit}]` : label), slider, field)};
}

const LEVELS = ['bound', 'fast', 'balanced', 'exact'];
let distanceField = null;

function showView() {
  const {options, scene} = state;
  if (!options) return;
  if (!distanceField) distanceField = range('max_distance', 0, Math.max(2, options.max_distance), 0.01, options.max_distance, value => option('max_distance', value), 'm');
  distanceField.set(options.max_distance);
  const levels = LEVELS.includes(options.accuracy) ? LEVELS : [...LEVELS, options.accuracy];
  const box = (label, name) => check(label, options[name], value => option(name, value));
  viewTab.replaceChildren(
    ...titled('Query', distanceField.row,
      element('div', {className: 'field'}, element('span', {}, 'accuracy'),
        element('select', {'aria-label': 'accuracy', onchange: event => option('accuracy', event.target.value)},
          levels.map(level => element('option', {value: level, selected: level === options.accuracy}, level))))),
    ...titled('Layers', element('div', {className: 'checks'},
      ['proximity', 'illustration', 'perception'].map(layer => check(layer, options.layers.includes(layer),
        value => option('layers', toggled(options.layers, layer, value)))))),
    ...titled('Draw', element('div', {className: 'checks'},
      box('names', 'names'), box('frames', 'frames'), box('normals', 'normals'),
      box('error bounds', 'bounds'), box('contact surfaces', 'contacts'), box('ground grid', 'grid'))),
    ...titled('Sources', element('div', {className: 'checks'}, (scene?.sources ?? []).map(([name, colour]) =>
      check(element('span', {}, swatch(rgb(colour)), name), !options.hidden.includes(name),
        value => option('hidden', toggled(options.hidden, name, !value)))))),
    ...titled('Keep', element('div', {className: 'controls'},
      element('button', {onclick: () => send('picture')}, 'picture (PNG)'),
      state.kind?.live ? null : ['yaml', 'csv'].map(format =>
        element('button', {onclick: () => send('poses', {format})}, `poses (${format.toUpperCase()})`)))),
  );
}
on('options', showView);
on('scene', showView);
on('kind', showView);

// Rules and filters.

const rulesTab = element('div');
function showRules() {
  const rules = state.rules ?? [], filters = state.filters ?? [];
  const ruleRow = rule => element('tr', {
    className: rule.pair ? 'link' : '', onclick: () => rule.pair && visit(rule.pair),
  },
  element('td', {}, swatch(rule.entered ? rgb(rule.colour) : 'var(--line)'), rule.name), element('td', {}, rule.level),
  element('td', {}, rule.entered ? element('strong', {}, `entered: ${rule.said}`) : rule.said || 'not entered'),
  element('td', {className: 'number'}, rule.distance === null ? 'no shown pair' : millimetres(rule.distance)));
  rulesTab.replaceChildren(
    ...titled('Proximity rules', rules.length ? table(['rule', 'level', 'state', 'nearest'], rules.map(ruleRow)) : hint('This scene has no rules.')),
    ...titled('Filters of this page', filters.length
      ? table(['on', 'declaration'], filters.map(([text, isOn], row) => element('tr', {},
        element('td', {}, element('input', {type: 'checkbox', checked: isOn, 'aria-label': text, onchange: event => send('switch', {row, on: event.target.checked})})),
        element('td', {}, text))))
      : hint(state.kind?.live ? 'Filters of a running node are explained here, and not changed: select two bodies.'
        : 'None. Select two bodies to exclude or allow their pair.')));
}
function table(columns, rows) {
  return element('table', {}, element('thead', {}, element('tr', {}, columns.map(name => element('th', {scope: 'col'}, name)))), element('tbody', {}, rows));
}
on('rules', showRules);
on('filters', showRules);
on('kind', showRules);

// Joints and frames.

const motionTab = element('div');
const jointFields = {};
function showMotion({joints, frames}) {
  const robots = [...new Set(joints.map(joint => joint.robot))];
  motionTab.replaceChildren(
    element('div', {className: 'controls'}, element('button', {onclick: () => send('reset')}, 'reset to the beginning')),
    ...robots.map(robot => element('details', {open: robots.length === 1}, element('summary', {}, `joints of ${robot}`),
      joints.filter(joint => joint.robot === robot).map(jointField))),
    ...(frames.length ? titled('Move a frame', element('select', {
      id: 'frame', 'aria-label': 'frame with the gizmo', onchange: event => send('frame', {name: event.target.value}),
    }, element('option', {value: ''}, 'none'), frames.map(name => element('option', {value: name}, name)))) : []));
}
function jointField({id, name, angle, lower, upper}) {
  const [factor, unit] = angle ? [DEGREES, '°'] : [1000, 'mm'];
  jointFields[id] = [factor, range(name, +(factor * lower).toFixed(3), +(factor * upper).toFixed(3), 'any', factor * Math.max(0, lower),
    value => send('joint', {name: id, value: value / factor}), unit)];
  return jointFields[id][1].row;
}
on('motion', showMotion);
on('values', ({joints, frame}) => {
  for (const [id, value] of Object.entries(joints)) {
    const [factor, field] = jointFields[id] ?? [];
    if (field) field.set(factor * value);
  }
  if ($('frame')) $('frame').value = frame;
});

// A running node: sensors, ages, events.

const liveTab = element('div');
/** Return a text with the short names of the bodies that it names; it may be broken behind slashes and colons. */
const shortened = text => text.split(' | ').map(part => shortByName[part] ?? part).join(' | ')
  .split(/(?<=\/|::)/).flatMap((part, k) => (k ? [element('wbr'), part] : part));
/** Return the class of a cell: names and topics may be broken anywhere, numbers and their units nowhere. */
const kindOf = cell => /::|^\S+\/\S+$/.test(cell) ? 'name' : /^-?[\d.]+( \S+)?$/.test(cell) ? 'amount' : '';
/** Return a table whose rows name their pair, if any, in a line of its own below the cells. */
function liveTable(columns, rows) {
  const last = columns.indexOf('pair');
  const others = list => list.filter((_, column) => column !== last);
  return table(others(columns), rows.flatMap(([cells, warns, pair]) => {
    const attributes = () => ({className: `${warns ? 'warns' : ''} ${pair ? 'link' : ''}`, onclick: () => pair && visit(pair)});
    const row = element('tr', attributes(), others(cells).map(cell => element('td', {className: kindOf(cell)}, shortened(cell))));
    if (!cells[last]) return [row];
    row.classList.add('above');
    return [row, element('tr', attributes(), element('td', {className: 'name', colSpan: columns.length - 1}, shortened(cells[last])))];
  }));
}
function showLive() {
  const sensors = state.sensors ?? {rows: [], kinds: [], colours: []}, options = state.options;
  const shown = ({title, columns, rows, empty}) => titled(title, rows.length ? liveTable(columns, rows) : hint(empty));
  // The long table of ages is the last one.
  const tables = state.tables ?? [], isLong = ({title}) => title.startsWith('Ages');
  const parts = tables.filter(each => !isLong(each)).flatMap(shown);
  if (sensors.rows.length && options) {
    const hidden = source => options.hidden.includes(`sensor ${source}`);
    parts.push(...titled('Sensed maps', element('div', {className: 'checks'}, sensors.kinds.map(([kind, label]) =>
      check(label, !options.hidden_cells.includes(kind), value => option('hidden_cells', toggled(options.hidden_cells, kind, !value))))),
    table(['show', 'source', 'cells'], sensors.rows.map(([source, counts]) => element('tr', {},
      element('td', {}, element('input', {type: 'checkbox', checked: !hidden(source), 'aria-label': source,
        onchange: event => option('hidden', toggled(options.hidden, `sensor ${source}`, !event.target.checked))})),
      element('td', {}, source),
      element('td', {}, sensors.kinds.filter(([kind]) => kind in counts).map(([kind, label]) => `${counts[kind]} ${label}`).join(', ')))))));
  }
  liveTab.replaceChildren(...parts, ...tables.filter(isLong).flatMap(shown));
}
for (const section of ['tables', 'sensors', 'options']) on(section, showLive);

// The status and the legend.

const statusPlace = element('div');
on('status', ({lines, troubles}) => {
  const isWarning = line => line.startsWith('NOT');
  // Over the picture: the panel may be closed, and what is not complete must not look so.
  $('warnings').replaceChildren(...lines.filter(isWarning).map(line => element('p', {}, line)));
  statusPlace.replaceChildren(
    ...lines.filter(line => !isWarning(line)).map(hint),
    ...troubles.map(line => element('p', {className: 'trouble'}, line)));
});
on('progress', ({done, count}) => notify(done < count ? `drawn ${done} of ${count}` : ''));

function showLegend() {
  const {scene, options, rules} = state;
  if (!scene || !options) return;
  const line = (colour, text, thin = false) => element('li', {}, swatch(colour, thin), text);
  const colours = scene.legend, items = [];
  for (const [name, colour] of scene.sources) items.push(line(rgb(colour), options.hidden.includes(name) ? `${name} (hidden)` : name));
  items.push(line(rgb(colours.distances), 'gap: nearest points', true), line(rgb(colours.contacts), 'overlap: deepest points', true));
  if (options.normals) items.push(line(rgb(colours.normals), 'normal, out of B into A', true));
  items.push(line('rgb(160, 0, 255)', 'selected'));
  for (const level of new Set((rules ?? []).map(rule => rule.level))) items.push(line(rgb(colours[`rule ${level}`]), `entered rule: ${level}`, true));
  for (const [kind, ...colour] of state.sensors?.colours ?? []) items.push(line(rgb(colour), `sensed: ${kind}`));
  if (options.contacts) items.push(line('linear-gradient(90deg, #0b2a6f, #f2e500)', 'contact pressure, from none'));
  $('legend').lastElementChild.replaceChildren(...items);
}
for (const section of ['scene', 'options', 'rules', 'sensors']) on(section, showLegend);
