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
    var svg = figure.querySelector("svg");
    this.data = data; this.figure = figure; this.svg = svg;
    var view = svg.viewBox.baseVal;
    this.box = { x: view.x, y: view.y, width: view.width, height: view.height };
    this.world = svg.querySelector(".world"); this.trail = svg.querySelector(".trail");
    this.cars = Array.from(svg.querySelectorAll(".car"));
    this.pulses = Array.from(svg.querySelectorAll(".pulse"));
    this.labels = Array.from(svg.querySelectorAll(".labels text"));
    this.key = svg.querySelector(".key"); this.ring = svg.querySelector(".collision");
    this.chosen = data.names.map(function () { return 0; });
    this.state = figure.querySelector(".cca-now"); this.why = figure.querySelector(".cca-why");
    this.points = data.t.map(function (_, k) {
      return (data.bodies[0][0][k] / 100).toFixed(2) + "," + (data.bodies[0][1][k] / 100).toFixed(2);
    });
    this.fit();
  }
  /* Numbers and their units stay on one line. */
  function whole(text) { return text.replace(/(\d) (m\/s²|m\/s|m|s)(?![a-z])/g, "$1\u00a0$2"); }
  /* The text below a view has the height of its longest text, so that the controls keep still. */
  Run.prototype.reserve = function () {
    var run = this, tall = 0, block = this.why.parentNode;
    block.style.minHeight = "";
    this.data.actions.forEach(function (action) {
      run.state.textContent = whole("00.0 s: the ego " + action[1] + ", 00.0 m/s");
      run.why.textContent = whole("Decided at 00.0 s: " + action[2]);
      tall = Math.max(tall, block.offsetHeight);
    });
    block.style.minHeight = tall + "px";
  };
  /* A car is 27 px long or more, on a phone too; what does not fit is named at the border. */
  Run.prototype.fit = function () {
    var width = Math.max(this.svg.clientWidth, 100), box = this.box, size;
    if (this.data.road) {
      box.width = Math.min(Math.max(width / 9, 60), 110);
      size = 13 * box.width / width;
      box.x = -this.data.behind * box.width;
      box.height = this.data.road + 9 * size;
      box.y = -0.5 * box.height + 0.6 * size;
    }
    this.size = 13 * box.width / width;
    this.svg.setAttribute("viewBox", [box.x, box.y, box.width, box.height].map(function (x) {
      return x.toFixed(2);
    }).join(" "));
    var scale = box.width / width, bottom = box.y + box.height - 13 * scale;
    this.key.setAttribute("transform", "translate(" + box.x.toFixed(2) + " " + bottom.toFixed(2) +
      ") scale(" + scale.toFixed(5) + ")");
    this.key.querySelector("rect").setAttribute("width", width);
    this.reserve();
  };
  function meet(a, b) {
    return Math.min(a[2] - b[0], b[2] - a[0], a[3] - b[1], b[3] - a[1]) > 0;
  }
  function around(x, y, half, up) { return [x - half, y - up, x + half, y + up]; }
  /* Text of a vehicle where it covers neither a vehicle nor another text; the last place is tried first. */
  Run.prototype.write = function (i, text, px, py, taken) {
    var size = this.size, box = this.box, half = 0.29 * size * text.length, up = 0.6 * size, run = this;
    var tall = 0.6 * this.data.sizes[i][0];
    var steps = [-1, 1, -2, 2, -3, 3, -4, 4, -5, 5];
    function place(choice) {
      var step = steps[choice], away = 0.5 * Math.min(tall, 2.4) + 0.8 * size;
      var y = py + (step > 0 ? 1 : -1) * (away + 1.15 * size * (Math.abs(step) - 1));
      var x = Math.min(Math.max(px, box.x + half + 0.3 * size), box.x + box.width - half - 0.3 * size);
      return { x: x, y: y, rect: around(x, y, half, up) };
    }
    function free(where) {
      var r = where.rect;
      return Math.min(r[1] - box.y, box.y + box.height - 2.2 * size - r[3]) > 0
        ? !taken.some(function (other) { return meet(r, other); }) : false;
    }
    var order = [this.chosen[i]].concat(steps.map(function (_, k) { return k; }));
    var choice = order.filter(function (k) { return free(place(k)); })[0];
    if (choice === undefined) { choice = this.chosen[i]; }
    run.chosen[i] = choice;
    var found = place(choice);
    taken.push(found.rect);
    return found;
  };
  /* Text of a vehicle outside of the view, at the border that it is behind. */
  Run.prototype.border = function (text, side, px, taken) {
    var size = this.size, box = this.box, half = 0.29 * size * text.length, up = 0.6 * size, k, x, y, rect;
    x = side === "left" ? box.x + half + 0.3 * size
      : side === "right" ? box.x + box.width - half - 0.3 * size
        : Math.min(Math.max(px, box.x + half + 0.3 * size), box.x + box.width - half - 0.3 * size);
    for (k = 0; 8 > k; k += 1) {
      y = side === "below" ? box.y + box.height - (3 + 1.3 * k) * size : box.y + (0.8 + 1.3 * k) * size;
      rect = around(x, y, half, up);
      if (!taken.some(function (other) { return meet(rect, other); })) { break; }
    }
    taken.push(rect);
    return { x: x, y: y };
  };
  Run.prototype.show = function (time) {
    var data = this.data, end = data.t[data.t.length - 1], t = Math.min(time, end);
    var where = bracket(t, data.t), camera = at(data.camera, where), run = this;
    var cx = camera[0] / 100, cy = camera[1] / 100, turn = camera[2] / 1e4;
    var c = Math.cos(turn), s = Math.sin(turn), box = this.box, size = this.size;
    this.world.setAttribute("transform", "scale(1 -1) rotate(" + (-turn * 180 / Math.PI).toFixed(3) +
      ") translate(" + (-cx).toFixed(3) + " " + (-cy).toFixed(3) + ")");
    var ego = null, taken = [], texts = [], over = time >= end;
    this.cars.forEach(function (car, i) {
      var pose = at(data.bodies[i], where), x = pose[0] / 100, y = pose[1] / 100, v = pose[3] / 100;
      var mark = i === 0 ? "1" : data.known[i - 1].charAt(where[0]), absent = mark === "-";
      car.style.display = absent ? "none" : "";
      if (i === 0) { ego = [x, y]; }
      car.setAttribute("transform", "translate(" + x.toFixed(3) + " " + y.toFixed(3) + ") rotate(" +
        (pose[2] / 1e4 * 180 / Math.PI).toFixed(2) + ")");
      car.classList.toggle("unknown", mark !== "1");
      if (i > 0) {
        var sent = data.received[i - 1].filter(function (m) { return t >= m / 1000; }).pop();
        var old = sent === undefined ? 9 : t - sent / 1000, pulse = run.pulses[i - 1];
        pulse.setAttribute("cx", x.toFixed(2)); pulse.setAttribute("cy", y.toFixed(2));
        pulse.setAttribute("r", (2 + 8 * Math.min(old, 0.5)).toFixed(2));
        pulse.style.opacity = absent ? 0 : 0.5 > old ? (0.9 - 1.8 * old).toFixed(2) : 0;
      }
      run.labels[i].textContent = "";
      if (absent) { return; }
      var px = c * (x - cx) + s * (y - cy), py = s * (x - cx) - c * (y - cy), angle = pose[2] / 1e4 - turn;
      var far = Math.round(Math.hypot(x - ego[0], y - ego[1]));
      var text = data.names[i] + (v > 0.1 ? " " + v.toFixed(v > 0.95 ? 0 : 1) + " m/s" : " stands still");
      var side = box.x - 2 > px ? "left" : px > box.x + box.width + 2 ? "right"
        : box.y - 2 > py ? "above" : py > box.y + box.height - 2 * size ? "below" : "";
      if (side) {
        text += i === 0 ? "" : ", " + far + " m";
        text = side === "right" ? text + " \u25b8"
          : { left: "\u25c2 ", above: "\u25b4 ", below: "\u25be " }[side] + text;
      } else {
        var half = 0.5 * data.sizes[i][0], up = 0.5 * data.sizes[i][1];
        taken.push(around(px, py, Math.abs(half * Math.cos(angle)) + Math.abs(up * Math.sin(angle)),
          Math.abs(half * Math.sin(angle)) + Math.abs(up * Math.cos(angle))));
      }
      texts.push({ i: i, text: text, side: side, px: px, py: py });
    });
    if (over ? this.ring : null) {  /* texts do not cover the sign of a collision */
      var hit = this.ring.transform.baseVal.getItem(0).matrix;
      taken.push(around(c * (hit.e - cx) + s * (hit.f - cy), s * (hit.e - cx) - c * (hit.f - cy), 3.6, 3.6));
    }
    texts.sort(function (a, b) { return (a.side ? 0 : 1) - (b.side ? 0 : 1); });
    texts.forEach(function (each) {
      var label = run.labels[each.i], found = each.side ? run.border(each.text, each.side, each.px, taken)
        : run.write(each.i, each.text, each.px, each.py, taken);
      label.style.fontSize = size + "px";
      label.setAttribute("x", found.x.toFixed(2)); label.setAttribute("y", (found.y + 0.36 * size).toFixed(2));
      label.textContent = each.text;
    });
    this.trail.setAttribute("points",
      this.points.slice(0, where[0] + 1).concat(ego[0].toFixed(2) + "," + ego[1].toFixed(2)).join(" "));
    var action = data.actions.filter(function (a) { return t + 1e-6 >= a[0]; }).pop();
    var speed = at(data.bodies[0], where)[3] / 100;
    var collision = over ? data.collision : null;
    this.svg.classList.toggle("over", Boolean(collision));
    this.state.textContent = whole((t + data.start).toFixed(1) + " s: the ego " + action[1] + ", " +
      speed.toFixed(1) + " m/s");
    this.why.textContent = whole(collision ||
      "Decided at " + (action[0] + data.start).toFixed(1) + " s: " + action[2]);
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
    window.addEventListener("resize", function () {
      runs.forEach(function (run) { run.fit(); });
      show();
    });
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
