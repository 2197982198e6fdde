// The web socket to the page's server: sections in, commands out.

const state = {};  // the newest value of each section
const listeners = {};
const BASE = location.pathname.replace(/\/*$/, '/');
let socket = null;

/** Call a function with each new value of a section. */
function on(section, listener) {
  (listeners[section] ??= []).push(listener);
}

/** Send a command; it is lost while there is no connection. */
function send(name, values = {}) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({do: name, ...values}));
}

function connect() {
  socket = new WebSocket(`${location.protocol.replace('http', 'ws')}//${location.host}${BASE}link`);
  socket.onmessage = event => {
    const {section, value} = JSON.parse(event.data);
    state[section] = value;
    for (const listener of listeners[section] ?? []) listener(value);
  };
  socket.onclose = () => {
    notify('no connection: what is shown is of before; trying again');
    setTimeout(connect, 1000);
  };
}

let hiding = 0;
function notify(text, seconds = 0) {
  $('notice').textContent = text;
  $('notice').hidden = !text;
  clearTimeout(hiding);
  if (seconds) hiding = setTimeout(() => notify(''), 1000 * seconds);
}

on('error', text => notify(text, 6));
on('file', ({name, text}) => {
  const link = element('a', {href: URL.createObjectURL(new Blob([text])), download: name});
  link.click();
  URL.revokeObjectURL(link.href);
});

const names = {};  // of bodies: full name, short name, source
const shortByName = {};
on('scene', ({bodies}) => {
  for (const key of Object.keys(names)) delete names[key];
  for (const [id, name, short] of bodies) {
    names[id] = {name, short, source: name.split('::')[0]};
    shortByName[name] = short;
  }
});
const shortOf = id => names[id]?.short ?? `#${id}`;
const selectedIds = () => (state.selection?.bodies ?? []).map(body => body.id);

/** Select a pair, and let this browser's camera fly to it. */
const visit = pair => send('visit', {bodies: pair});
