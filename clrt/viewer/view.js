// A scene on a canvas: what is done with pointer and keys is said, and pictures come back.

const MARKUP = `
  <div>
    <canvas tabindex="0" role="application" aria-label="The picture. Arrow keys turn it, with Shift
      they pan; plus and minus zoom, Enter picks what is in the middle."></canvas>
    <pre hidden tabindex="0"></pre>
    <output role="status"></output>
  </div>
  <form>
    <button type="button" name="reset" title="R">Reset</button>
    <button type="button" name="projection" title="O" aria-pressed="false">Orthographic</button>
    <label>Samples <select name="samples"></select></label>
    <label class="style" hidden>Style <select name="style"></select></label>
    <span class="time" hidden>
      <button type="button" name="play" title="Space" aria-pressed="false">Play</button>
      <label>Frame <input type="range" name="frame" min="0" value="0"></label>
      <output name="at">0</output>
    </span>
    <button type="button" name="save" title="S" disabled>Save picture</button>
    <button type="button" name="command" disabled>Copy as command</button>
    <button type="button" name="toml" disabled>Copy as TOML</button>
  </form>`;

const SAMPLES = [1, 4, 16, 64, 256, 1024];
const CLICK = 4; // pixels that a pointer may move in a click
const STEP = 1 / 36; // of the picture's height that an arrow key moves

// root: an element that becomes the view. send: takes a message.
// Returns what takes a header and a picture's file (a Blob), as they come.
export function view(root, send) {
  root.classList.add("clrt-view");
  root.innerHTML = MARKUP;
  const canvas = root.querySelector("canvas");
  const context = canvas.getContext("bitmaprenderer");
  const text = root.querySelector("pre");
  const status = root.querySelector("output[role=status]");
  const form = root.querySelector("form").elements;
  let changes = 0; // that were said
  let newest = 0; // picture that was drawn
  let final = null; // the last one, if nothing has changed since
  let name = "picture";
  let playing = null; // since when, and from which frame
  let frames = 1, fps = 30;
  let width = 0, height = 0; // of the picture: the canvas has the pixels of the screen

  function change(message) {
    changes += 1;
    final = null;
    for (const button of ["save", "command", "toml"]) form[button].disabled = true;
    send(message);
    return changes;
  }

  function receive(header, file) {
    if (header.about) about(header.about);
    else if ("picked" in header) say(picked(header.picked));
    else if (header.error) say(header.error);
    else show(header, file);
  }

  function about(told) {
    ({ name, frames, fps } = told);
    root.querySelector(".time").hidden = frames < 2;
    form.frame.max = frames - 1;
    root.querySelector(".style").hidden = !told.styles.length;
    form.style.replaceChildren(...told.styles.map((name) => new Option(name, name)));
    say(`${told.spheres.toLocaleString("en")} spheres`);
  }

  async function show(header, file) {
    const bitmap = await createImageBitmap(file, { colorSpaceConversion: "none" });
    if (header.number > newest) {
      newest = header.number;
      context.transferFromImageBitmap(bitmap);
      controls(header);
      if (header.final && header.changes === changes) {
        final = { ...header, file };
        form.save.disabled = form.toml.disabled = false;
        form.command.disabled = !header.command;
      }
      root.dispatchEvent(new CustomEvent("picture", { detail: header, bubbles: true }));
    }
    bitmap.close();
    send({ do: "shown", number: header.number }); // the next one can come while this is painted
  }

  function controls(header) {
    const straight = header.projection === "orthographic";
    form.projection.setAttribute("aria-pressed", straight);
    if (![...form.samples.options].some((o) => o.value == header.most)) {
      const all = [...new Set([...SAMPLES, header.most])].sort((a, b) => a - b);
      form.samples.replaceChildren(...all.map((n) => new Option(n, n)));
    }
    form.samples.value = header.most;
    form.style.value = header.style;
    if (!header.moves && header.most > 1) say(`${header.samples} of ${header.most} samples`);
    if (!playing) form.frame.value = header.frame;
    form.at.value = header.frame;
  }

  const say = (what) => (status.value = what);

  function picked(sphere) {
    if (!sphere) return "nothing there";
    const short = (v) => (typeof v === "number" ? Number(v.toPrecision(6)) : v);
    const value = (v) => (Array.isArray(v) ? `(${v.map(short).join(", ")})` : short(v));
    return Object.entries(sphere).map(([key, v]) => `${key} ${value(v)}`).join(", ");
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

  let held = null; // the pointer: where it went down and where it was
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || held) return;
    canvas.setPointerCapture(event.pointerId);
    held = { id: event.pointerId, from: at(event), last: at(event), moved: false };
  });
  // The raw ones do not wait for the screen's next frame.
  const moved = "onpointerrawupdate" in window ? "pointerrawupdate" : "pointermove";
  canvas.addEventListener(moved, (event) => {
    if (held?.id !== event.pointerId) return;
    const here = at(event);
    const far = Math.hypot(here[0] - held.from[0], here[1] - held.from[1]) > CLICK * ratio();
    if (!(held.moved ||= far)) return;
    const [x, y] = [here[0] - held.last[0], here[1] - held.last[1]];
    held.last = here;
    if (x || y) change({ do: event.shiftKey ? "pan" : "turn", x, y });
  });
  canvas.addEventListener("pointerup", (event) => {
    if (held?.id !== event.pointerId) return;
    if (!held.moved) pick(...held.from);
    held = null;
  });
  canvas.addEventListener("pointercancel", () => (held = null));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const [x, y] = at(event);
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 40 : 1;
    zoom(Math.exp((-event.deltaY * lines) / 500), x, y);
  }, { passive: false });

  const pick = (x, y) => send({ do: "pick", x: Math.max(Math.floor(x), 0), y: Math.max(Math.floor(y), 0) });
  // Whole numbers are the middles of pixels there.
  const zoom = (factor, x, y) =>
    change({ do: "zoom", factor: Math.min(Math.max(factor, 0.01), 100), x: x - 0.5, y: y - 0.5 });
  const middle = () => [width / 2, height / 2];

  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const KEYS = {
    "+": () => zoom(1.1, ...middle()),
    "=": () => zoom(1.1, ...middle()),
    "-": () => zoom(1 / 1.1, ...middle()),
    Enter: () => pick(...middle()),
    r: () => form.reset.click(),
    o: () => form.projection.click(),
    s: () => form.save.click(),
    " ": () => frames > 1 && form.play.click(),
  };
  // Plain keys are heard before a notebook, which would delete cells, hears them.
  const keyed = (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const [target, ...outer] = event.composedPath();
    if (outer.includes(root)) event.stopPropagation();
    if (target !== canvas) return;
    const way = ARROWS[event.key], does = KEYS[event.key];
    if (!way && !does) return;
    event.preventDefault();
    if (does) return does();
    const [x, y] = way.map((step) => step * STEP * height);
    change({ do: event.shiftKey ? "pan" : "turn", x, y });
  };
  root.addEventListener("focusin", () => addEventListener("keydown", keyed, true));
  root.addEventListener("focusout", () => removeEventListener("keydown", keyed, true));

  form.reset.onclick = () => change({ do: "reset" });
  form.projection.onclick = () => {
    const straight = form.projection.getAttribute("aria-pressed") === "true";
    change({ do: "project", projection: straight ? "perspective" : "orthographic" });
  };
  form.samples.onchange = () => change({ do: "sample", samples: Number(form.samples.value) });
  form.frame.oninput = () => change({ do: "frame", frame: Number(form.frame.value) });
  form.style.onchange = () => change({ do: "restyle", style: form.style.value });
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
    if (!asked && frame !== Number(form.frame.value)) {
      form.frame.value = frame;
      asked = change({ do: "frame", frame });
    }
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
