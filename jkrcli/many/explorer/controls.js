"use strict";
/* Sliders with number fields: one value in SI, kept as the text that was typed so that commands repeat it exactly. */

const STEPS = 1000, DIGITS = 4;

/* The number of a decimal text times a power of ten, rounded once. */
function scaled(text, power) {
  const [mantissa, exponent] = text.trim().toLowerCase().split("e");
  return mantissa === "" ? NaN : Number(`${mantissa}e${Number(exponent || 0) + power}`);
}

/* A number as people write it: at most that many digits, no trailing zeros. */
function plain(value, digits = DIGITS) {
  return String(Number(value.toPrecision(digits)));
}

function pretty(unit) {
  return unit.replace("^2", "²").replace(/\bu(?=[mNJ])/g, "µ");
}

class Control {
  constructor(name, spec, changed) {
    Object.assign(this, { name, spec, changed });
    this.slider = document.getElementById(`${name}-slider`);
    this.field = document.getElementById(name);
    Object.assign(this.slider, { min: 0, max: STEPS, step: 1 });
    document.getElementById(`${name}-unit`).textContent = pretty(spec.unit);
    this.slider.addEventListener("input", () => this.slid());
    this.field.addEventListener("input", () => this.typed());
    this.field.addEventListener("blur", () => { if (!this.valid()) this.write(this.text); });
    this.reset();
  }

  get value() { return scaled(this.text, this.spec.power); }

  /* The value with its unit, as an option of the command line takes it. */
  get quantity() { return this.spec.unit ? `"${this.text} ${this.spec.unit}"` : this.text; }

  reset() { this.write(plain(this.spec.value / 10 ** this.spec.power, 12)); }

  write(text) {
    this.text = text;
    this.field.value = text;
    this.place();
  }

  valid() {
    const value = scaled(this.field.value, this.spec.power);
    return Number.isFinite(value) && (!this.spec.logarithmic || value > 0 || (this.name === "w" && value === 0));
  }

  typed() {
    const fine = this.valid();
    this.field.setAttribute("aria-invalid", String(!fine));
    if (!fine) return;
    this.text = this.field.value.trim();
    this.place();
    this.changed(this.name);
  }

  slid() {
    const { low, high, logarithmic, power } = this.spec, part = Number(this.slider.value) / STEPS;
    const value = logarithmic ? low * (high / low) ** part : low + (high - low) * part;
    const resolution = 10 ** Math.floor(Math.log10((high - low) / STEPS));
    const rounded = logarithmic ? value : Math.round(value / resolution) * resolution;
    this.text = plain(rounded / 10 ** power);
    this.field.value = this.text;
    this.field.removeAttribute("aria-invalid");
    this.tell();
    this.changed(this.name);
  }

  /* Put the slider where the value is, at an end where it lies beyond. */
  place() {
    const { low, high, logarithmic } = this.spec, value = this.value;
    const part = logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    this.slider.value = Math.round(STEPS * Math.min(Math.max(part, 0), 1));
    this.tell();
  }

  tell() { this.slider.setAttribute("aria-valuetext", `${this.text} ${this.spec.unit}`.trim()); }
}

/* Numbers in people's units, as jkr prints them. */
class Units {
  constructor(tables) { this.tables = tables; }

  /* {factor, unit} in which the value is between 1 and 1000. */
  of(value, dimension) {
    const size = Math.abs(value), entries = Object.entries(this.tables[dimension]);
    if (!(size > 0)) return { factor: 1, unit: entries.find(([, power]) => power === 0)[0] };
    const rank = (power) => {
      const number = size / 10 ** power;
      return [number >= 1 && number < 1000 ? 0 : 1, Math.abs(Math.log10(size) - power - 1)];
    };
    const better = (one, other) => one[0] - other[0] || one[1] - other[1];
    const [unit, power] = entries.reduce((best, entry) => (better(rank(entry[1]), rank(best[1])) < 0 ? entry : best));
    return { factor: 10 ** power, unit };
  }

  show(value, dimension) {
    const rounded = Number(value.toPrecision(DIGITS)), { factor, unit } = this.of(rounded, dimension);
    return `${plain(rounded / factor)} ${pretty(unit)}`.replace("-", "\u2212");
  }
}
