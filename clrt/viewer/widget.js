
// In a notebook: a view at the end of a widget's model. There can be several of one model.

function render({ model, el }) {
  const root = document.createElement("div");
  root.dataset.lmSuppressShortcuts = true; // of Jupyter, which has keys of its own
  el.append(root);
  const name = crypto.randomUUID?.() ?? String(Math.random());
  const receive = view(root, (message) => model.send({ view: name, message }));
  const take = ({ view: whose, header }, [file]) => {
    const type = header.final ? "image/png" : "image/jpeg";
    if (whose === name) receive(header, new Blob([file], { type }));
  };
  model.on("msg:custom", take);
  model.send({ view: name, message: null }); // it is there
  return () => {
    model.off("msg:custom", take);
    model.send({ view: name, message: false }); // it is gone
  };
}

export default { render };
