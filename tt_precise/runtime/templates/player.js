// Tops that turn over: figures of figure.html.j2, each played from the JSON in it. One set of
// controls, of controls.html.j2, moves all.
//
// theta, phi and psi (rad), x and y of the point below the sphere's centre and lift of its lowest
// point (radii) stand every `every` s; map and graph are positions in the drawing.
const control = name => document.getElementById(`top-${name}`);
const tops = [...document.querySelectorAll("figure.top")].map(figure => {
  const { every, begin, theta, phi, psi, x, y, lift, map, graph, trail: memory, first, rest } =
    JSON.parse(figure.querySelector("script").textContent);
  const at = name => figure.querySelector(`[id$="-${name}"]`);
  const SIZE = 74, LEFT = 148, FLOOR = 232, TILT = 0.34;  // pixels a radius; view from above, rad
  const STEM = 1.75, ROUND = 0.2;  // length from the sphere's centre and round end, radii
  const end = (theta.length - 1) * every, digits = end < 1 ? 4 : 2;
  const value = (array, t) => {
    const i = Math.min(Math.floor(t / every), array.length - 2), part = t / every - i;
    return array[i] + (array[i + 1] - array[i]) * part;
  };
  // X to the right, Y away, Z up, in radii, with the contact point at the origin
  const seen = ([X, Y, Z]) => [LEFT + SIZE * X, FLOOR - SIZE * (Z * Math.cos(TILT) + Y * Math.sin(TILT))];
  const path = points => points.length
    ? "M" + points.map(p => seen(p).map(c => c.toFixed(1)).join(" ")).join("L") : "";
  const draw = t => {
    const th = value(theta, t), f = value(phi, t), s = value(psi, t);
    const up = 1 + (lift ? value(lift, t) : 0);
    const k = [Math.sin(th) * Math.cos(f), Math.sin(th) * Math.sin(f), Math.cos(th)];
    const e1 = [Math.cos(th) * Math.cos(f), Math.cos(th) * Math.sin(f), -Math.sin(th)];
    const e2 = [-Math.sin(f), Math.cos(f), 0];
    const toward = [0, -Math.cos(TILT), Math.sin(TILT)];
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const on = (height, angle, radius) => [0, 1, 2].map(i => (i === 2 ? up : 0) + height * k[i]
      + radius * (Math.cos(angle) * e1[i] + Math.sin(angle) * e2[i]));
    const turn = (height, from, to, front) => {
      const radius = Math.sqrt(1 - height * height), points = [[]];
      for (let j = 0; j <= 72; j++) {
        const p = on(height, from + (to - from) * j / 72, radius);
        const visible = dot([p[0], p[1], p[2] - up], toward) >= 0;
        if (visible === front) points.at(-1).push(p); else if (points.at(-1).length) points.push([]);
      }
      return points.map(path).join("");
    };
    at("band").setAttribute("d", turn(0.55, 0, 2 * Math.PI, true));
    at("waist").setAttribute("d", turn(-0.2, 0, 2 * Math.PI, true));
    let spots = "";
    for (let j = 0; j < 3; j++) {
      const points = [];
      for (let h = -0.2; h <= 0.551; h += 0.05) {
        const p = on(h, s + 2 * Math.PI * j / 3, Math.sqrt(1 - h * h));
        if (dot([p[0], p[1], p[2] - up], toward) >= 0) points.push(p);
      }
      spots += path(points);
    }
    at("spots").setAttribute("d", spots);
    // the model has no stem: it ends where the table is
    const tip = k[2] < 0 ? Math.min(STEM, (up - ROUND) / -k[2]) : STEM;
    const ends = [on(Math.min(0.8, tip), 0, 0), on(tip, 0, 0)].map(seen);
    const stem = at("stem"), behind = dot(k, toward) < 0;
    for (const [i, [cx, cy]] of ends.entries()) {
      stem.setAttribute(`x${i + 1}`, cx); stem.setAttribute(`y${i + 1}`, cy);
    }
    const ball = at("ball");
    const [cx, cy] = seen([0, 0, up]);
    ball.setAttribute("cx", cx); ball.setAttribute("cy", cy); ball.setAttribute("r", SIZE);
    (behind ? at("back") : at("front")).append(stem);
    const here = [value(x, t), value(y, t)], trail = [];
    for (let u = Math.max(0, t - memory); u < t; u += every / 2)
      trail.push([value(x, u) - here[0], value(y, u) - here[1], 0]);
    at("trail").setAttribute("d", path([...trail, [0, 0, 0]].filter(p => Math.hypot(...p) < 2)));
    const place = (name, [px, py]) => {
      at(name).setAttribute("cx", px.toFixed(1)); at(name).setAttribute("cy", py.toFixed(1));
    };
    place("on-map", [map.x0 + map.scale * here[0], map.y0 - map.scale * here[1]]);
    place("on-graph", [graph.x0 + graph.sx * t, graph.y0 - graph.sy * th]);
    at("angle").textContent = `θ = ${(th * 180 / Math.PI).toFixed(1)}°`;
    control("time").value = t;
    control("time").setAttribute("aria-valuetext", `${(begin + t).toFixed(2)} s, theta ${th.toFixed(3)} rad`);
    control("now").textContent = `${(begin + t).toFixed(digits)} s`;
  };
  return { figure, draw, end, first, rest };
});
if (tops.length) {
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const { figure, end, first, rest } = tops[0];
  const [button, slider, speed] = ["play", "time", "speed"].map(control);
  const draw = t => tops.forEach(top => top.draw(t));
  let now = rest, playing = false, last = 0;
  const step = stamp => {
    if (!playing) return;
    now += last ? Math.min(stamp - last, 100) / 1000 * speed.value : 0;
    last = stamp;
    if (now >= end) now = 0;
    draw(now);
    requestAnimationFrame(step);
  };
  const play = wanted => {
    playing = wanted; last = 0;
    button.textContent = wanted ? "Pause" : "Play";
    if (wanted) requestAnimationFrame(step);
  };
  button.addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => { play(false); now = Number(slider.value); draw(now); });
  control("controls").hidden = false;
  draw(now);
  if (!still.matches) { now = first; play(true); }
  still.addEventListener("change", () => { if (still.matches) play(false); });
  addEventListener("beforeprint", () => { play(false); draw(rest); });
  new IntersectionObserver(([entry]) => { if (!entry.isIntersecting) play(false); })
    .observe(figure);
}
