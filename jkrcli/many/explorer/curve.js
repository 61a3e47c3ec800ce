"use strict";
/* The adhesive curve by Eq. 13 from the table that jkr wrote: columns and their derivatives at close radii, cubics
   through both between them. Nothing is solved here. SI units. */

const STABLE = "stable", GRIPPED = "displacement-control", UNSTABLE = "unstable";

/* Nonadhesive series at unit modulus, with the shift t = sqrt(4 pi a/S') of w = 1; "every" entry is a row of it. */
class Table {
  constructor({ table, every, columns, band, level }) {
    Object.assign(this, { every, columns, band, level });
    this.samples = table.a.map((_, i) => Object.fromEntries(Object.keys(table).map((name) => [name, table[name][i]])));
  }

  /* The entry at the part s of the way from entry i to the next. */
  between(i, s) {
    const low = this.samples[i], high = this.samples[i + 1], h = high.a - low.a, at = { a: low.a + s * h };
    for (const name of ["delta", "P", "S", "t"]) {
      const f = low[name], rise = high[name] - f, m = h * low[`d${name}`], n = h * high[`d${name}`];
      const cubic = m + n - 2 * rise, square = 3 * rise - 2 * m - n;
      at[name] = ((cubic * s + square) * s + m) * s + f;
      at[`d${name}`] = ((3 * cubic * s + 2 * square) * s + m) / h;
    }
    return at;
  }
}

/* What a device of a stiffness [N/m] controls: P itself (0), else delta + P/stiffness (infinite: delta). */
function control(stiffness, delta, P) {
  return stiffness === 0 ? P : delta + P / stiffness;
}

/* The curve for a work of adhesion w [J/m^2] and moduli that are factor times those of the table, under the profile
   times another factor. */
class AdhesiveCurve {
  constructor(table, w, factor, profile = 1) {
    Object.assign(this, { table, w, factor, profile, q: Math.sqrt(w / factor) });
  }

  point({ a, delta, P, S, t }) {
    return { a, delta: this.profile * delta - this.q * t, P: this.factor * (this.profile * P - this.q * S * t) };
  }

  rates({ ddelta, dP, S, t, dS, dt }) {
    const { profile, q, factor } = this;
    return { delta: profile * ddelta - q * dt, P: factor * (profile * dP - q * (S * dt + dS * t)) };
  }

  /* The rate of what the device controls: stable where positive. */
  rate(at, stiffness) {
    const { delta, P } = this.rates(at);
    return control(stiffness, delta, P);
  }

  position(at, stiffness) {
    const { delta, P } = this.point(at);
    return control(stiffness, delta, P);
  }

  /* Entries of the table where the function vanishes, and whether it rises there. */
  zeros(f) {
    const { samples } = this.table, signs = samples.map((at) => Math.sign(f(at))), found = [];
    for (let i = 0; i + 1 < samples.length; i++) {
      const last = i + 2 >= samples.length;
      if (signs[i] * signs[i + 1] > 0 || (signs[i + 1] === 0 && !last)) continue;
      found.push({ at: this.bisect(f, i, signs[i]), rising: signs[i + 1] > signs[i] });
    }
    return found;
  }

  bisect(f, i, sign) {
    if (sign === 0) return this.table.samples[i];
    let low = 0, high = 1;
    while (high - low > 1e-12) {
      const middle = (low + high) / 2;
      if (Math.sign(f(this.table.between(i, middle))) === sign) low = middle; else high = middle;
    }
    return this.table.between(i, high);
  }

  /* The last stable point on retraction, or {reason}. */
  pullOff(stiffness) {
    if (this.w === 0) return { reason: "there is no adhesion at w = 0" };
    const { samples } = this.table, ends = [samples[0], samples[samples.length - 1]];
    const held = (at) => this.position(at, stiffness);
    const minima = this.zeros((at) => this.rate(at, stiffness)).filter(({ rising }) => rising).map(({ at }) => at);
    const best = minima.reduce((low, at) => (low === null || held(at) < held(low) ? at : low), null);
    const end = held(ends[1]) < held(ends[0]) ? ends[1] : ends[0];
    if (best === null || held(best) > held(end)) {
      return { reason: end === ends[0]
        ? "below the smallest radius of the series: solve to smaller radii (loading.spacing = \"log\")"
        : "beyond the largest radius of the series: increase [loading] radius" };
    }
    if (held(best) > 0) return { reason: "some contact remains below the smallest radius of the series" };
    return this.point(best);
  }

  /* The largest stable contact under the load P [N]: an entry of the table, or null. */
  resting(P) {
    const stable = this.zeros((at) => this.point(at).P - P).filter(({ rising }) => rising);
    return stable.length ? stable[stable.length - 1].at : null;
  }

  /* The curve in parts of one stability under the device; neighbours share a point. */
  parts(stiffness) {
    const turns = this.zeros((at) => this.rate(at, stiffness)).map(({ at }) => at), { samples } = this.table;
    const all = [...samples, ...turns].sort((one, other) => one.a - other.a), parts = [];
    let part = [];
    for (const at of all) {
      part.push(at);
      if (turns.includes(at)) { parts.push(part); part = [at]; }
    }
    parts.push(part);
    return parts.filter((points) => points.length > 1).map((points) => ({
      stable: this.w === 0 || this.rate(points[points.length >> 1], stiffness) > 0,
      points: points.map((at) => this.point(at)),
    }));
  }

  /* Half-widths {delta, P} at the series' radii, or null where no error is known. */
  errors() {
    const { band } = this.table;
    if (band === null) return null;
    const width = ([one, linear, square], by) =>
      one.map((c, i) => by * Math.sqrt(Math.max(c + this.q * linear[i] + this.q ** 2 * square[i], 0)));
    return { delta: width(band.delta, 1), P: width(band.P, this.factor) };
  }

  /* The columns of jkr transform's CSV file. */
  columns() {
    const c = this.table.columns, { factor, q } = this, errors = this.errors();
    const shift = c.a.map((a, i) => q * Math.sqrt((4 * Math.PI * a) / c.dS[i]));
    const [delta, P] = this.w === 0 ? [c.delta_H, c.P_H] : [c.delta, c.P];
    return {
      a_m: c.a,
      delta_m: delta.map((value, i) => value - shift[i]),
      P_N: P.map((value, i) => factor * (value - c.S[i] * shift[i])),
      delta_H_m: c.delta_H,
      P_H_N: c.P_H.map((value) => factor * value),
      S_N_per_m: c.S.map((value) => factor * value),
      dS_da_N_per_m2: c.dS.map((value) => factor * value),
      ...(errors && { P_err_N: errors.P, delta_err_m: errors.delta }),
      branch: c.a.map((_, i) => this.branch(this.table.samples[i * this.table.every])),
      ...(errors && { level: c.a.map(() => this.table.level) }),
    };
  }

  branch(at) {
    const { delta, P } = this.rates(at);
    return this.w === 0 || P > 0 ? STABLE : delta > 0 ? GRIPPED : UNSTABLE;
  }

  csv() {
    const columns = this.columns(), names = Object.keys(columns);
    const rows = columns.a_m.map((_, i) => names.map((name) => columns[name][i]).join(","));
    return [names.join(","), ...rows].join("\n") + "\n";
  }
}

/* Where a viscoelastic specimen loses contact by its history; ratio: its relaxed over its instantaneous modulus. At rest under
   the load P [N], then pulled at once, it answers with the moduli at t = 0 under the profile times ratio, up to the
   radius of rest; the displacement counts from the dent that is kept. */
function byHistory(table, w, factor, ratio, P, stiffness) {
  const relaxed = new AdhesiveCurve(table, w, factor * ratio), pulled = new AdhesiveCurve(table, w, factor, ratio);
  const depthless = ({ P: force, a, reason }) => (reason ? { reason } : { P: force, a });
  return {
    slow: relaxed.pullOff(stiffness), rest: fromRest(relaxed, pulled, ratio, P, stiffness),
    most: depthless(pulled.pullOff(stiffness)),
  };
}

function fromRest(relaxed, pulled, ratio, P, stiffness) {
  const { samples } = relaxed.table, last = relaxed.point(samples[samples.length - 1]).P;
  const rest = relaxed.resting(P);
  if (rest === null) {
    return { reason: last < P ? "its rest is beyond the largest radius of the series: increase [loading] radius"
      : "no contact rests under this load" };
  }
  const held = (at) => pulled.position(at, stiffness);
  const minima = pulled.zeros((at) => pulled.rate(at, stiffness)).filter(({ at, rising }) => rising && at.a < rest.a);
  const lowest = [rest, ...minima.map(({ at }) => at)].reduce((low, at) => (held(at) < held(low) ? at : low));
  if (held(samples[0]) < held(lowest)) return { reason: "below the smallest radius of the series" };
  const { a, delta, P: force } = pulled.point(lowest);
  return { a, delta: delta + (1 - ratio) * relaxed.point(rest).delta, P: force };
}
