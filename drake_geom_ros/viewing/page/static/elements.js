// Elements, numbers and colours.

const $ = id => document.getElementById(id);

/** Return an element; attributes that begin with "on" are listeners. Names are only ever text. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else if (name in made && name !== 'list') made[name] = value;
    else if (value !== undefined && value !== false) made.setAttribute(name, value);
  }
  made.append(...children.flat(Infinity).filter(child => child !== null && child !== undefined));
  return made;
}

const SVG = 'http://www.w3.org/2000/svg';

function drawn(tag, attributes = {}, text = '') {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text) made.textContent = text;
  return made;
}

const millimetres = metres => `${(1000 * metres).toFixed(3)} mm`;
const rgb = ([red, green, blue]) => `rgb(${red}, ${green}, ${blue})`;
const DEGREES = 180 / Math.PI;

/** Return a colour from orange (touching) over grey to blue (as far as is asked). */
function colourOf(distance, farthest) {
  if (distance < 0) return 'rgb(242, 89, 0)';
  const share = Math.min(1, distance / Math.max(farthest, 1e-9));
  const [from, to, part] = share < 0.5
    ? [[240, 150, 60], [165, 170, 185], 2 * share] : [[165, 170, 185], [26, 89, 255], 2 * share - 1];
  return rgb(from.map((value, k) => Math.round(value + part * (to[k] - value))));
}

function swatch(colour, thin = false) {
  const made = element('span', {className: thin ? 'swatch thin' : 'swatch'});
  made.style.background = colour;
  return made;
}

/** Return a function that calls another at most once in a frame, with the last arguments. */
function throttled(call) {
  let last = null;
  return (...values) => {
    const idle = last === null;
    last = values;
    if (idle) setTimeout(() => { const now = last; last = null; call(...now); }, 40);
  };
}

/** Return round values between two limits, about as many as asked. */
function ticks(low, high, count) {
  const raw = (high - low) / count;
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(each => each * power).find(each => each >= raw);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}
