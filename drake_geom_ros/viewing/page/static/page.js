// The page as a whole: tabs, the frame with the picture, theme, and the address that restores a view.

const TABS = {pairs: pairsTab, view: viewTab, rules: rulesTab, motion: motionTab, live: liveTab};
const LABELS = {pairs: 'Pairs', view: 'View', rules: 'Rules and filters', motion: 'Joints', live: 'Node'};
let tab = 'pairs';

for (const [name, content] of Object.entries(TABS)) {
  $('tabs').append(element('button', {role: 'tab', id: `to-${name}`, onclick: () => showTab(name)}, LABELS[name]));
  content.className = 'tab';
  content.setAttribute('role', 'tabpanel');
  $('tab-bodies').append(content);
}
$('tab-bodies').append(statusPlace);
statusPlace.className = 'tab';

function showTab(name) {
  tab = name;
  for (const [each, content] of Object.entries(TABS)) {
    content.hidden = each !== name;
    $(`to-${each}`).setAttribute('aria-selected', each === name);
  }
  keepAddress();
}

on('kind', ({live, title}) => {
  document.title = `${title} · drake_geom_ros`;
  $('title').textContent = title;
  $('reset').hidden = live;
  $('to-motion').hidden = live;
  $('to-live').hidden = !live;
});

// The picture: viser's page in a frame, without its own panel.

const HIDDEN = '[data-floating-window], .mantine-Notifications-root, .mantine-Paper-root {display: none !important}';
on('hello', ({key}) => {
  notify('');
  const dark = document.documentElement.dataset.theme === 'dark';
  send('dark', {on: dark});
  if (restored.camera) send('look', restored.camera);
  $('picture').src = `${BASE}3d/${key}/${dark ? '?darkMode' : ''}`;
});
$('picture').addEventListener('load', () => {
  const inside = $('picture').contentDocument;
  inside?.head?.append(Object.assign(inside.createElement('style'), {textContent: HIDDEN}));
});

function setTheme(dark) {
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
  $('theme').textContent = dark ? 'light' : 'dark';
  send('dark', {on: dark});
}
$('theme').onclick = () => {
  const dark = document.documentElement.dataset.theme !== 'dark';
  localStorage.setItem('drake_geom_ros theme', dark ? 'dark' : 'light');
  setTheme(dark);
  keepAddress();
};

// The panel: open beside the picture, closed at the start where there is little room.

function setPanel(isOpen) {
  $('panel').classList.toggle('closed', !isOpen);
  $('toggle-panel').setAttribute('aria-pressed', isOpen);
  $('toggle-panel').setAttribute('aria-expanded', isOpen);
}
const isNarrow = matchMedia('(max-width: 760px)');
$('toggle-panel').onclick = () => setPanel($('panel').classList.contains('closed'));
setPanel(!isNarrow.matches);
$('legend').open = !isNarrow.matches;

for (const button of document.querySelectorAll('[data-view]')) button.onclick = () => send('view', {name: button.dataset.view});
$('reset').onclick = () => send('reset');
$('copy-link').onclick = async () => {
  keepAddress.now();
  await navigator.clipboard?.writeText(location.href).catch(() => null);
  notify('the address of this view is in the address bar and on the clipboard', 3);
};

document.addEventListener('keydown', event => {
  if (event.target.closest('input, select, button, summary, .plot')) return;
  if (event.key === 'Escape') send('select', {bodies: []});
  else if (event.key === ' ' && state.timeline) { send('play', {on: !state.clock?.playing}); event.preventDefault(); }
  else if (event.key === ',') send('step', {count: -1});
  else if (event.key === '.') send('step', {count: 1});
});

// The address.

const SHARED = ['max_distance', 'accuracy', 'layers', 'hidden', 'names', 'frames', 'normals', 'bounds', 'contacts', 'grid'];
const restored = readAddress();

function readAddress() {
  try {
    return JSON.parse(decodeURIComponent(location.hash.slice(1)) || '{}');
  } catch {
    return {};
  }
}

const writeAddress = () => {
  const {options, selection, clock, camera} = state;
  if (!options) return;
  const kept = {tab, options: Object.fromEntries(SHARED.map(name => [name, options[name]]))};
  if (camera) kept.camera = camera;
  if (selection?.bodies.length) kept.selected = selection.bodies.map(body => body.name);
  if (clock && !clock.playing) kept.time = clock.time;
  if (state.values && !clock) kept.joints = state.values.joints;
  if (document.documentElement.dataset.theme === 'dark') kept.dark = true;
  history.replaceState(null, '', `#${encodeURIComponent(JSON.stringify(kept))}`);
};
function keepAddress() {
  clearTimeout(keepAddress.waiting);
  keepAddress.waiting = setTimeout(writeAddress, 400);
}
keepAddress.now = writeAddress;

let isRestored = false;
function restore() {
  const moves = state.kind?.live || ('clock' in state && 'values' in state);
  if (isRestored || !state.scene?.bodies.length || !state.options || !state.kind || !moves) return;
  isRestored = true;
  for (const [name, value] of Object.entries(restored.options ?? {})) {
    if (JSON.stringify(state.options[name]) !== JSON.stringify(value)) send('option', {name, value});
  }
  if (restored.time !== undefined && state.clock) send('time', {value: restored.time});
  for (const [name, value] of Object.entries(restored.joints ?? {})) {
    if (state.values?.joints[name] !== value) send('joint', {name, value});
  }
  if (restored.selected) send('select_names', {names: restored.selected});
  for (const section of ['options', 'selection', 'clock', 'camera', 'values']) on(section, keepAddress);
}
for (const section of ['scene', 'options', 'kind', 'values', 'clock']) on(section, restore);

const kept = localStorage.getItem('drake_geom_ros theme');
const prefersDark = kept ? kept === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
showTab(restored.tab in TABS ? restored.tab : 'pairs');
setTheme(restored.dark ?? prefersDark);
connect();
