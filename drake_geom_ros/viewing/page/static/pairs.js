// The table of pairs: sorted, searched, filtered by source, coloured by distance.

const FIRST_ROWS = 60;
const COLUMNS = [['distance', row => row[2]], ['A', row => shortOf(row[0])], ['B', row => shortOf(row[1])]];
const wanted = {column: 0, descending: false, search: '', source: '', all: false};

const searchField = element('input', {
  type: 'search', placeholder: 'search names', 'aria-label': 'search names',
  oninput: event => { wanted.search = event.target.value.toLowerCase(); showPairs(); },
});
const sourceField = element('select', {
  'aria-label': 'source or robot', onchange: event => { wanted.source = event.target.value; showPairs(); },
});
const headings = COLUMNS.map(([label], column) => element('th', {scope: 'col'}, element('button', {
  onclick: () => {
    wanted.descending = wanted.column === column && !wanted.descending;
    wanted.column = column;
    showPairs();
  },
}, label)));
const pairRows = element('tbody');
const pairsEnd = element('p', {className: 'hint'});
const pairsTab = element('div', {},
  element('div', {className: 'controls'}, searchField, sourceField),
  element('table', {id: 'pairs'}, element('thead', {}, element('tr', {}, headings)), pairRows), pairsEnd);

function matching(rows) {
  const words = wanted.search.split(/\s+/).filter(Boolean);
  return rows.filter(([a, b]) => {
    const [first, second] = [names[a], names[b]];
    if (!first || !second) return !words.length && !wanted.source;
    if (wanted.source && first.source !== wanted.source && second.source !== wanted.source) return false;
    const text = `${first.name} ${second.name} ${first.short} ${second.short}`.toLowerCase();
    return words.every(word => text.includes(word));
  });
}

function sorted(rows) {
  const key = COLUMNS[wanted.column][1], sign = wanted.descending ? -1 : 1;
  return [...rows].sort((a, b) => {
    const [first, second] = [key(a), key(b)];
    return sign * (first < second ? -1 : first > second ? 1 : 0);
  });
}

function pairRow(row, selected) {
  const [a, b, distance, bound] = row;
  const chosen = selected.length === 2 && selected.includes(a) && selected.includes(b);
  const farthest = state.options?.max_distance ?? 1;
  const visitIt = () => visit([a, b]);
  const error = state.options?.bounds ? element('div', {className: 'hint'}, `± ${bound === null ? '∞' : bound.toExponential(1)} m`) : null;
  return element('tr', {
    className: chosen ? 'link selected' : 'link', tabIndex: 0, title: `${names[a]?.name}\n${names[b]?.name}`,
    onclick: visitIt, onkeydown: event => { if (event.key === 'Enter') visitIt(); },
  },
  element('td', {className: 'number'}, swatch(colourOf(distance, farthest)), millimetres(distance), error),
  element('td', {className: 'name'}, shortOf(a)), element('td', {className: 'name'}, shortOf(b)));
}

function showPairs() {
  const {rows, count, overlaps} = state.pairs ?? {rows: [], count: 0, overlaps: 0};
  headings.forEach((heading, column) => heading.setAttribute('aria-sort',
    column !== wanted.column ? 'none' : wanted.descending ? 'descending' : 'ascending'));
  headings.forEach((heading, column) => {
    heading.firstChild.textContent = COLUMNS[column][0] + (column !== wanted.column ? '' : wanted.descending ? ' ▾' : ' ▴');
  });
  const found = sorted(matching(rows)), selected = selectedIds();
  const shown = wanted.all ? found : found.slice(0, FIRST_ROWS);
  pairRows.replaceChildren(...shown.map(row => pairRow(row, selected)));
  const notes = [];
  if (found.length > shown.length) {
    notes.push(element('button', {onclick: () => { wanted.all = true; showPairs(); }}, `and ${found.length - shown.length} more`));
  }
  if (!rows.length && state.pairs) notes.push(`no pair within ${state.options?.max_distance} m`);
  else if (!found.length) notes.push(`none of ${rows.length} pairs matches`);
  if (count > rows.length) notes.push(` The table has the ${rows.length} nearest of ${count} pairs.`);
  pairsEnd.replaceChildren(...notes);
  const bodies = state.scene?.bodies.filter(([,,, there]) => there).length ?? 0;
  $('summary').replaceChildren(`${bodies} bodies · ${count} pairs within ${state.options?.max_distance ?? '?'} m · `,
    element('span', {className: overlaps ? 'overlaps' : ''}, `${overlaps} overlap`));
}

on('pairs', showPairs);
on('selection', showPairs);
on('options', showPairs);
on('scene', ({sources}) => {
  const now = wanted.source;
  sourceField.replaceChildren(element('option', {value: ''}, 'all sources'),
    ...sources.map(([name]) => element('option', {value: name, selected: name === now}, name)));
  showPairs();
});
