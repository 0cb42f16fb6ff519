
// In a notebook: a view at the end of a widget's model. There can be several of one model.

const GONE = ["comm_live_update", "comm:close"]; // of a model
const PATIENCE = 5000, PAUSE = 25; // milliseconds: each message takes some of Jupyter's own

function render({ model, el }) {
  const root = document.createElement("div");
  el.append(root);
  const name = crypto.randomUUID?.() ?? String(Math.random());
  let gone = false; // restarted, the kernel has no memory of this
  const leave = () => {
    gone = true;
    clearTimeout(waits);
    receive({ error: "the kernel has gone: run the cell again" });
  };
  let waits = 0; // for an answer
  const receive = view(root, (message) => {
    model.send({ view: name, message });
    if (gone) leave();
    else if (message.do !== "shown") waits ||= setTimeout(doubt, PATIENCE);
  }, PAUSE);
  const doubt = () => receive({ error: "no answer: the kernel is busy, or gone: run the cell again" });
  const take = ({ view: whose, header }, [file]) => {
    const type = header.final ? "image/png" : "image/jpeg";
    if (whose !== name) return;
    gone = false;
    waits = clearTimeout(waits) ?? 0;
    receive(header, new Blob([file], { type }));
  };
  model.on("msg:custom", take);
  for (const end of GONE) model.on(end, leave);
  model.send({ view: name, message: null }); // it is there
  const close = () => {
    removeEventListener("pagehide", close); // as when the tab is reloaded
    model.off("msg:custom", take);
    for (const end of GONE) model.off(end, leave);
    model.send({ view: name, message: false }); // it is gone
  };
  addEventListener("pagehide", close);
  return close;
}

export default { render };
