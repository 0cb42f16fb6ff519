// A scene on a canvas: what is done with pointers and keys is said, and pictures come back.

const MARKUP = `
  <div class="picture">
    <canvas tabindex="0" role="application" aria-label="The picture. Arrow keys turn it, with Shift
      they pan; plus and minus zoom, Enter picks what is in the middle, H lists all keys."></canvas>
    <canvas class="over" aria-hidden="true"></canvas>
    <table hidden aria-label="What was picked"></table>
    <pre hidden tabindex="0"></pre>
    <output role="status"></output>
  </div>
  <form>
    <button type="button" name="menu" aria-expanded="false">Menu</button>
    <button type="button" name="reset" title="R">Reset</button>
    <details name="clrt">
      <summary>View</summary>
      <div class="sides"></div>
    </details>
    <button type="button" name="projection" title="O" aria-pressed="false">Orthographic</button>
    <label>Samples <select name="samples"></select></label>
    <details name="clrt" class="look" hidden>
      <summary>Look</summary>
      <div>
        <label>Style <select name="style"></select></label>
        <label>Colour by <input name="color" list="clrt-columns" placeholder="as it is"></label>
        <label>Colours <select name="cmap"></select></label>
        <label>Range <input name="clim" placeholder="low high"></label>
        <label>Select <input name="select" placeholder="x > 0" spellcheck="false"></label>
        <label>Opacity <input name="opacity" placeholder="0 to 1" spellcheck="false"></label>
        <output name="wrong" role="alert"></output>
        <datalist id="clrt-columns"></datalist>
      </div>
    </details>
    <span class="time" hidden>
      <button type="button" name="back" title="," aria-label="Frame before">‹</button>
      <button type="button" name="play" title="Space" aria-pressed="false">Play</button>
      <button type="button" name="on" title="." aria-label="Next frame">›</button>
      <label>Frame <input type="range" name="frame" min="0" value="0"></label>
      <output name="at">0</output>
    </span>
    <button type="button" name="save" title="S" disabled>Save picture</button>
    <details name="clrt">
      <summary>Copy</summary>
      <div>
        <button type="button" name="command" disabled>Copy as command</button>
        <button type="button" name="toml" disabled>Copy as TOML</button>
      </div>
    </details>
    <button type="button" name="full" title="F">Fullscreen</button>
    <details name="clrt" class="help">
      <summary>Keys</summary>
      <dl></dl>
    </details>
  </form>`;

const SAMPLES = [1, 4, 16, 64, 256, 1024];
const SIDES = { c: "corner", i: "iso", x: "x", X: "-x", y: "y", Y: "-y", z: "z", Z: "-z" };
const CLICK = 4; // pixels that a pointer may move in a click
const TWICE = 400; // milliseconds between two clicks
const STEP = 1 / 36; // of the picture's height that an arrow key moves

// root: an element that becomes the view. send: takes a message. pause: milliseconds between two
// messages of what is dragged, at least. Returns what takes a header and a file, as they come.
export function view(root, send, pause = 0) {
  root.classList.add("clrt-view");
  root.innerHTML = MARKUP;
  const [canvas, over] = root.querySelectorAll("canvas");
  const context = canvas.getContext("bitmaprenderer"), drawing = over.getContext("2d");
  const find = (what) => root.querySelector(what);
  const text = find("pre"), row = find("table"), status = find("[role=status]");
  const form = find("form").elements;
  let changes = 0; // that were said
  let newest = 0; // picture that was drawn
  let final = null; // the last one, if nothing has changed since
  let layers = []; // what lies over the picture: bitmaps and where they are
  let mark = null; // of what was picked: the column, row and radius of each ball whose hull it is
  let name = "picture";
  let playing = null; // since when, and from which frame
  let frames = 1, fps = 30;
  let width = 0, height = 0; // of the picture: the canvas has the pixels of the screen

  let dragged = null; // what was not said yet
  let said = 0; // when something was
  function drag(what, x, y) {
    if (dragged?.do !== what) tell();
    dragged ??= { do: what, x: 0, y: 0, later: setTimeout(tell, Math.max(said + pause - performance.now(), 0)) };
    [dragged.x, dragged.y] = [dragged.x + x, dragged.y + y];
    if (performance.now() >= said + pause) tell();
  }
  function tell() {
    if (!dragged) return;
    const { later, ...message } = dragged;
    dragged = clearTimeout(later) ?? null;
    said = performance.now();
    change(message);
  }

  function change(message) {
    tell();
    changes += 1;
    final = null;
    for (const button of ["save", "command", "toml"]) form[button].disabled = true;
    send(message);
    return changes;
  }

  function receive(header, file) {
    if (header.about) about(header.about);
    else if ("picked" in header) picked(header);
    else if (header.error) (header.of ? form.wrong : status).value = header.error;
    else if (header.say) say(header.say);
    else show(header, file);
  }

  function options(field, names) {
    field.replaceChildren(...names.map((name) => new Option(name, name)));
  }

  function about(told) {
    ({ name, frames, fps } = told);
    find(".time").hidden = frames < 2;
    form.frame.max = frames - 1;
    find(".look").hidden = !told.styles.length;
    options(form.style, told.styles);
    options(form.cmap, told.cmaps);
    options(find("datalist"), told.columns);
    const many = ["spheres", "bonds", "capsules", "faces"].filter((what) => told[what]);
    say(many.map((what) => `${told[what].toLocaleString("en")} ${what}`).join(", "));
  }

  // A file has the layers, then the picture.
  async function show(header, file) {
    const bitmap = (part) => createImageBitmap(part, { colorSpaceConversion: "none" });
    const parts = [];
    let end = 0;
    for (const [x, y, length] of header.layers) {
      const part = file.slice(end, (end += length), "image/png");
      parts.push(bitmap(part).then((drawn) => ({ drawn, x, y })));
    }
    const whole = end ? file.slice(end, file.size, file.type) : file;
    const [drawn, ...over] = await Promise.all([bitmap(whole), ...parts]);
    if (header.preview ? !newest : header.number > newest) {
      newest = header.number ?? 0;
      context.transferFromImageBitmap(drawn);
      [layers, mark] = [over, header.mark];
      row.hidden ||= !mark; // others may be there
      cover();
      controls(header);
      if (header.final && header.changes === changes) {
        final = { ...header, file };
        form.save.disabled = form.toml.disabled = false;
        form.command.disabled = !header.command;
      }
      root.dispatchEvent(new CustomEvent("picture", { detail: header, bubbles: true }));
    }
    drawn.close();
    if (!header.preview) send({ do: "shown", number: header.number }); // the next one can come while this is painted
  }

  // Words, bars and lines are as sharp while the picture moves.
  function cover() {
    over.hidden = !layers.length && !mark; // to lay it over the picture takes time, empty as well
    if (over.hidden) return;
    if (over.width !== width || over.height !== height) [over.width, over.height] = [width, height];
    else drawing.clearRect(0, 0, width, height);
    const bands = [["#000", 5, 4], ["#fff", 4, 2], ["#000", 2, 1]]; // colour, outer and inner side
    for (const [color, outer, inner] of mark ? bands : []) {
      fill("source-over", color, outer * ratio());
      fill("destination-out", color, inner * ratio());
    }
    for (const { drawn, x, y } of layers) drawing.drawImage(drawn, x, y);
  }

  // The hull of the mark's balls, grown by so many pixels.
  function fill(how, color, grown) {
    drawing.globalCompositeOperation = how;
    drawing.fillStyle = color;
    const area = (draw) => (drawing.beginPath(), draw(), drawing.fill());
    area(() => mark.forEach(([x, y]) => drawing.lineTo(x + 0.5, y + 0.5)));
    mark.forEach(([x, y, radius], i) => {
      const [toX, toY, other] = mark[(i + 1) % mark.length];
      const way = Math.atan2(toY - y, toX - x), far = Math.hypot(toX - x, toY - y);
      area(() => drawing.arc(x + 0.5, y + 0.5, radius + grown, 0, 7));
      if (far <= Math.abs(radius - other)) return; // one is inside the other
      const aside = Math.acos((radius - other) / far); // where lines that touch both touch them
      area(() => [[x, y, radius, 1], [x, y, radius, -1], [toX, toY, other, -1], [toX, toY, other, 1]].forEach(
        ([x, y, r, side]) => drawing.lineTo(x + 0.5 + (r + grown) * Math.cos(way + side * aside),
          y + 0.5 + (r + grown) * Math.sin(way + side * aside))));
    });
    drawing.globalCompositeOperation = "source-over";
  }

  function controls(header) {
    const straight = header.projection === "orthographic";
    form.projection.setAttribute("aria-pressed", straight);
    if (![...form.samples.options].some((o) => o.value == header.most)) {
      options(form.samples, [...new Set([...SAMPLES, header.most])].sort((a, b) => a - b));
    }
    form.samples.value = header.most;
    for (const [key, value] of Object.entries(header.look)) {
      if (form[key] !== root.getRootNode().activeElement) form[key].value = value;
    }
    if (header.moves) say(status.value.replace(/^\d+ of \d+ samples$/, ""));
    else if (header.most > 1) say(`${header.samples} of ${header.most} samples`);
    if (!playing) form.frame.value = header.frame;
    form.at.value = header.frame;
  }

  const say = (what) => (status.value = what);

  function picked(header) {
    const short = (v) => (typeof v === "number" ? Number(v.toPrecision(6)) : v);
    const value = (v) => (Array.isArray(v) ? `(${v.map(short).join(", ")})` : short(v));
    const known = Object.entries(header.picked ?? {}).map(([key, v]) => [key, value(v)]);
    row.hidden = !known.length;
    row.replaceChildren();
    for (const [key, shown] of known) {
      const line = row.insertRow();
      line.append(document.createElement("th"), document.createElement("td"));
      [line.cells[0].textContent, line.cells[1].textContent] = [key, shown];
    }
    say(known.length ? `${header.name}: M looks at it` : "nothing there");
    mark = header.mark;
    cover();
    if (final?.changes === header.changes) final.command = header.command;
  }

  new ResizeObserver(([entry]) => {
    const device = entry.devicePixelContentBoxSize?.[0];
    const box = device ?? entry.contentBoxSize[0], ratio = device ? 1 : devicePixelRatio;
    const across = Math.round(box.inlineSize * ratio), down = Math.round(box.blockSize * ratio);
    if (!across || !down || (across === width && down === height)) return;
    [width, height] = [across, down];
    change({ do: "resize", width, height });
  }).observe(canvas);

  const ratio = () => width / canvas.clientWidth;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) * ratio(), (event.clientY - box.top) * ratio()];
  };
  const apart = ([a, b], [c, d]) => Math.hypot(a - c, b - d);
  const between = ([a, b], [c, d]) => [(a + c) / 2, (b + d) / 2];

  const held = new Map(); // pointers, at most two: where each was
  let from = null; // where the first went down, as long as it can be a click
  let clicked = { time: -TWICE, place: [0, 0] };
  canvas.addEventListener("pointerdown", (event) => {
    text.hidden = true;
    if (event.button !== 0 || held.size === 2) return;
    canvas.setPointerCapture(event.pointerId);
    from = held.size ? null : at(event);
    held.set(event.pointerId, at(event));
  });
  // The raw ones do not wait for the screen's next frame, but fingers and some browsers have none.
  for (const moved of ["pointerrawupdate", "pointermove"]) canvas.addEventListener(moved, (event) => {
    const last = held.get(event.pointerId), here = at(event);
    if (!last || (from && apart(here, from) <= CLICK * ratio())) return;
    from = null;
    held.set(event.pointerId, here);
    const other = [...held].find(([id]) => id !== event.pointerId)?.[1];
    const [start, end] = other ? [between(last, other), between(here, other)] : [last, here];
    const [x, y] = [end[0] - start[0], end[1] - start[1]];
    if (x || y) drag(other || event.shiftKey ? "pan" : "turn", x, y);
    if (other) zoom(apart(here, other) / Math.max(apart(last, other), 1), ...end);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (from && held.has(event.pointerId)) click(from, event.timeStamp);
    leave(event);
  });
  const leave = (event) => (held.delete(event.pointerId), (from = null));
  canvas.addEventListener("pointercancel", leave);
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 40 : 1;
    zoom(Math.exp((-event.deltaY * lines) / 500), ...at(event));
  }, { passive: false });

  function click(place, time) {
    const twice = time - clicked.time < TWICE && apart(place, clicked.place) < 2 * CLICK * ratio();
    clicked = { time: twice ? -TWICE : time, place };
    if (twice && mark) change({ do: "center" });
    else pick(...place);
  }
  const pick = (x, y) => send({ do: "pick", x: Math.max(Math.floor(x), 0), y: Math.max(Math.floor(y), 0) });
  // Whole numbers are the middles of pixels there.
  const zoom = (factor, x, y) =>
    change({ do: "zoom", factor: Math.min(Math.max(factor, 0.01), 100), x: x - 0.5, y: y - 0.5 });
  const middle = () => [width / 2, height / 2];
  const side = (view) => change({ do: "view", view });
  const step = (by) => frames > 1 && goTo((Number(form.frame.value) + by + frames) % frames);
  const goTo = (frame) => ((form.frame.value = frame), change({ do: "frame", frame }));

  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const KEYS = {
    "+": ["zoom in", () => zoom(1.1, ...middle())],
    "-": ["zoom out", () => zoom(1 / 1.1, ...middle())],
    Enter: ["pick what is in the middle", () => pick(...middle())],
    m: ["look at what was picked", () => change({ do: "center" })],
    r: ["reset", () => form.reset.click()],
    o: ["orthographic or perspective", () => form.projection.click()],
    ...Object.fromEntries(Object.entries(SIDES).map(([k, of]) => [k, [`from ${of}`, () => side(of)]])),
    " ": ["play", () => frames > 1 && form.play.click()],
    ",": ["frame before", () => step(-1)],
    ".": ["next frame", () => step(1)],
    s: ["save picture", () => form.save.click()],
    f: ["fullscreen", () => form.full.click()],
    h: ["these keys", () => find(".help").toggleAttribute("open")],
  };
  const other = { "=": "+", "?": "h" };
  find("dl").innerHTML = [["arrows", ["turn"]], ["Shift arrows", ["pan"]], ...Object.entries(KEYS)]
    .map(([key, [does]]) => `<dt><kbd>${key === " " ? "Space" : key}</kbd></dt><dd>${does}</dd>`).join("");

  // Plain keys are heard before a notebook, which would delete cells, hears them.
  const keyed = (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const [target, ...outer] = event.composedPath();
    if (outer.includes(root)) event.stopPropagation();
    if (event.key === "Escape") for (const open of root.querySelectorAll("details[open]")) open.open = false;
    if (target !== canvas) return;
    const way = ARROWS[event.key], key = other[event.key] ?? event.key;
    const [, does] = KEYS[key] ?? KEYS[key.toLowerCase()] ?? [];
    if (!way && !does) return;
    event.preventDefault();
    if (does) return does();
    const [x, y] = way.map((step) => step * STEP * height);
    drag(event.shiftKey ? "pan" : "turn", x, y);
  };
  root.addEventListener("focusin", () => addEventListener("keydown", keyed, true));
  root.addEventListener("focusout", () => removeEventListener("keydown", keyed, true));

  find(".sides").append(...Object.entries(SIDES).map(([key, of]) => {
    const button = Object.assign(document.createElement("button"), { type: "button", title: key, textContent: of });
    button.onclick = () => side(of);
    return button;
  }));
  find("form").onsubmit = (event) => event.preventDefault();
  form.menu.onclick = () => {
    form.menu.setAttribute("aria-expanded", root.classList.toggle("open"));
  };
  form.reset.onclick = () => change({ do: "reset" });
  form.projection.onclick = () => {
    const straight = form.projection.getAttribute("aria-pressed") === "true";
    change({ do: "project", projection: straight ? "perspective" : "orthographic" });
  };
  form.samples.onchange = () => change({ do: "sample", samples: Number(form.samples.value) });
  for (const key of ["style", "color", "cmap", "clim", "select", "opacity"]) {
    form[key].onchange = () => {
      form.wrong.value = "";
      change({ do: "look", key, value: form[key].value });
    };
  }
  form.full.hidden = !document.fullscreenEnabled;
  form.full.onclick = () => (document.fullscreenElement ? document.exitFullscreen() : root.requestFullscreen());
  form.frame.oninput = () => change({ do: "frame", frame: Number(form.frame.value) });
  form.back.onclick = () => step(-1);
  form.on.onclick = () => step(1);
  form.play.onclick = () => {
    playing = playing ? null : { since: performance.now(), from: Number(form.frame.value) };
    form.play.setAttribute("aria-pressed", Boolean(playing));
    if (playing) requestAnimationFrame(play);
  };

  // The frame that is due now, once the one before has come.
  let asked = 0; // the change that asked for the frame before
  root.addEventListener("picture", ({ detail }) => detail.changes >= asked && (asked = 0));
  function play(now) {
    if (!playing) return;
    const frame = Math.floor(playing.from + (Math.max(now - playing.since, 0) / 1000) * fps) % frames;
    if (!asked && frame !== Number(form.frame.value)) asked = goTo(frame);
    requestAnimationFrame(play);
  }

  form.save.onclick = () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(final.file);
    link.download = `${name.split("/").pop().replace(/\.\w+$/, "")}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  };
  const copy = async (what) => {
    text.textContent = what;
    text.hidden = false;
    try {
      await navigator.clipboard.writeText(what);
      say("copied");
    } catch {
      getSelection().selectAllChildren(text); // Ctrl-C does it
      say("selected: copy it with Ctrl-C");
    }
  };
  form.command.onclick = () => copy(final.command);
  form.toml.onclick = () => copy(final.toml);
  root.addEventListener("picture", () => (text.hidden ||= !final));

  return receive;
}
