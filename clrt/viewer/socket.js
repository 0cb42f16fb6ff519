
// The page: a view at the end of a socket.

const root = document.querySelector("#view");
const address = new URL(`ws${location.search}`, location.href);
address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
const socket = new WebSocket(address);
socket.binaryType = "arraybuffer";
let receive = ({ error }) => (root.textContent = error);
socket.onopen = () => {
  receive = view(root, (message) => socket.send(JSON.stringify(message)));
};
// A header in JSON, a newline, a file.
socket.onmessage = ({ data }) => {
  const bytes = new Uint8Array(data);
  const end = bytes.indexOf(10);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
  const type = header.final ? "image/png" : "image/jpeg";
  receive(header, new Blob([bytes.subarray(end + 1)], { type }));
};
socket.onclose = ({ reason }) => receive({ error: reason || "clrt has gone: start it again" });
