(function () {
  "use strict";
  var still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  function sums(column) { var sum = 0; return column.map(function (x) { sum += x; return sum; }); }
  function decode(run) {
    run.t = sums(run.t).map(function (x) { return x / 1000; });
    run.camera = run.camera.map(sums);
    run.bodies = run.bodies.map(function (body) { return body.map(sums); });
    return run;
  }
  function bracket(t, times) {
    var low = 0, high = times.length - 1, middle;
    if (t >= times[high]) { return [high, high, 0]; }
    while (high - low > 1) {
      middle = (low + high) >> 1;
      if (times[middle] > t) { high = middle; } else { low = middle; }
    }
    return [low, high, (t - times[low]) / (times[high] - times[low])];
  }
  function at(columns, where) {
    return columns.map(function (c) { return c[where[0]] + where[2] * (c[where[1]] - c[where[0]]); });
  }
  function Run(figure, data) {
    var svg = figure.querySelector("svg"), box = svg.viewBox.baseVal;
    this.data = data; this.figure = figure; this.svg = svg; this.box = box;
    this.world = svg.querySelector(".world"); this.trail = svg.querySelector(".trail");
    this.cars = Array.from(svg.querySelectorAll(".car"));
    this.pulses = Array.from(svg.querySelectorAll(".pulse"));
    this.labels = Array.from(svg.querySelectorAll("text"));
    this.state = figure.querySelector(".cca-now"); this.why = figure.querySelector(".cca-why");
    this.points = data.t.map(function (_, k) {
      return (data.bodies[0][0][k] / 100).toFixed(2) + "," + (data.bodies[0][1][k] / 100).toFixed(2);
    });
  }
  Run.prototype.show = function (time) {
    var data = this.data, end = data.t[data.t.length - 1], t = Math.min(time, end);
    var where = bracket(t, data.t), camera = at(data.camera, where), run = this, stacked = [0, 0];
    var cx = camera[0] / 100, cy = camera[1] / 100, turn = camera[2] / 1e4;
    var c = Math.cos(turn), s = Math.sin(turn), box = this.box;
    var size = 12 * box.width / Math.max(this.svg.clientWidth, 100);
    this.world.setAttribute("transform", "scale(1 -1) rotate(" + (-turn * 180 / Math.PI).toFixed(3) +
      ") translate(" + (-cx).toFixed(3) + " " + (-cy).toFixed(3) + ")");
    var ego = null, y0 = 0;
    this.cars.forEach(function (car, i) {
      var pose = at(data.bodies[i], where), x = pose[0] / 100, y = pose[1] / 100, v = pose[3] / 100;
      var mark = i === 0 ? "1" : data.known[i - 1].charAt(where[0]), absent = mark === "-";
      var known = mark === "1";
      car.style.display = absent ? "none" : "";
      if (i === 0) { ego = [x, y]; y0 = s * (x - cx) - c * (y - cy); }
      car.setAttribute("transform", "translate(" + x.toFixed(3) + " " + y.toFixed(3) + ") rotate(" +
        (pose[2] / 1e4 * 180 / Math.PI).toFixed(2) + ")");
      car.classList.toggle("unknown", !known);
      if (i > 0) {
        var sent = data.received[i - 1].filter(function (m) { return t >= m / 1000; }).pop();
        var old = sent === undefined ? 9 : t - sent / 1000, pulse = run.pulses[i - 1];
        pulse.setAttribute("cx", x.toFixed(2)); pulse.setAttribute("cy", y.toFixed(2));
        pulse.setAttribute("r", (2 + 10 * Math.min(old, 0.5)).toFixed(2));
        pulse.style.opacity = absent ? 0 : 0.5 > old ? (0.9 - 1.8 * old).toFixed(2) : 0;
      }
      var px = c * (x - cx) + s * (y - cy), py = s * (x - cx) - c * (y - cy), label = run.labels[i];
      var far = Math.round(Math.hypot(x - ego[0], y - ego[1])), text;
      text = data.names[i] + (v > 0.1 ? " " + v.toFixed(v > 0.95 ? 0 : 1) + " m/s" : " stationary");
      var before = box.x - 2 > px, after = px > box.x + box.width + 2;
      var above = box.y - 2 > py, below = py > box.y + box.height + 2;
      var away = before || after || (i === 0 ? above || below : false);
      text = i > 0 || away ? text : "";
      label.style.display = car.style.display;
      label.style.fontSize = size + "px";
      if (absent) {
        text = "";
      } else if (before || after) {
        px = before ? box.x + 0.5 * size : box.x + box.width - 0.5 * size;
        text += i === 0 ? "" : ", " + far + " m";
        text = before ? "\u25c2 " + text : text + " \u25b8";
        py = box.y + (1.2 + 1.2 * stacked[before ? 0 : 1]) * size;
        stacked[before ? 0 : 1] += 1;
        label.setAttribute("text-anchor", before ? "start" : "end");
      } else {
        label.setAttribute("text-anchor", "middle");
        px = Math.min(Math.max(px, box.x + 3.4 * size), box.x + box.width - 3.4 * size);
        py = py > y0 + 0.7 ? py + 1.3 + size : py - 1.5;
        if (away) {
          text = (above ? "\u25b4 " : "\u25be ") + text;
          py = above ? box.y + 1.2 * size : box.y + box.height - 0.5 * size;
        }
      }
      label.setAttribute("x", px.toFixed(2)); label.setAttribute("y", py.toFixed(2));
      label.textContent = text;
    });
    this.trail.setAttribute("points",
      this.points.slice(0, where[0] + 1).concat(ego[0].toFixed(2) + "," + ego[1].toFixed(2)).join(" "));
    var action = data.actions.filter(function (a) { return t + 1e-6 >= a[0]; }).pop();
    var speed = at(data.bodies[0], where)[3] / 100, over = time >= end;
    var collision = over ? data.collision : null;
    this.svg.classList.toggle("over", Boolean(collision));
    this.state.textContent = (t + data.start).toFixed(1) + " s, " + speed.toFixed(1) + " m/s, " + action[1];
    this.why.textContent = collision || action[2];
    this.why.classList.toggle("cca-collision", Boolean(collision));
  };
  function start(root) {
    if (root.dataset.ready) { return; }
    root.dataset.ready = "1";
    var data = JSON.parse(root.querySelector("script[type='application/json']").textContent);
    var figures = root.querySelectorAll(".cca-run");
    var runs = data.map(function (run, i) { return new Run(figures[i], decode(run)); });
    var end = Math.max.apply(null, runs.map(function (r) { return r.data.t[r.data.t.length - 1]; }));
    var button = root.querySelector("button"), slider = root.querySelector("input");
    var speed = root.querySelector("select"), clock = root.querySelector(".cca-clock");
    var now = 0, last = null, playing = false, touched = still;
    function show() {
      runs.forEach(function (run) { run.show(now); });
      slider.value = now; clock.textContent = now.toFixed(1) + " / " + end.toFixed(1) + " s";
      slider.setAttribute("aria-valuetext", now.toFixed(1) + " seconds");
    }
    function name() { button.textContent = playing ? "Pause" : now >= end ? "Replay" : "Play"; }
    function frame(stamp) {
      if (!playing) { return; }
      if (last !== null) { now = Math.min(now + (stamp - last) / 1000 * Number(speed.value), end); }
      last = stamp;
      show();
      if (now >= end) { playing = false; name(); } else { window.requestAnimationFrame(frame); }
    }
    function play(on) {
      if (on === playing) { return; }
      if (on) { if (now >= end) { now = 0; } }
      playing = on; last = null; name();
      if (on) { window.requestAnimationFrame(frame); }
    }
    function seek(t) { now = Math.min(Math.max(t, 0), end); show(); name(); }
    button.addEventListener("click", function () { touched = true; play(!playing); });
    slider.addEventListener("input", function () {
      touched = true; play(false); seek(Number(slider.value));
    });
    root.addEventListener("keydown", function (event) {
      var step = { ArrowLeft: -0.5, ArrowRight: 0.5, ",": -0.1, ".": 0.1, Home: -end, End: end }[event.key];
      if (event.target !== root) { return; }
      if (event.key === " ") { touched = true; play(!playing); }
      else if (step !== undefined) { touched = true; play(false); seek(now + step); }
      else { return; }
      event.preventDefault();
    });
    slider.max = end;
    window.addEventListener("resize", show);
    if (window.IntersectionObserver) {
      new IntersectionObserver(function (entries) {
        var seen = entries[entries.length - 1].isIntersecting;
        if (!seen) { play(false); } else if (!touched) { touched = true; play(true); }
      }, { threshold: 0.6 }).observe(root);
    }
    show(); name();
  }
  document.querySelectorAll(".cca").forEach(start);
}());
