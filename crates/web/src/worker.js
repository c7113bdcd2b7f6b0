// The engine of the page in a worker: passes messages between the page and the module.
//
// The first message from the page has the bytes of the module, or null: then they are fetched from
// beside this file. Each further one is the text of a request. To the page go texts and buffers, as
// from the socket of `carom live`, and { failed: reason } before the worker ends.
"use strict";

let engine = null;
let panic = "";
let isDue = false;
let timer = null;
const requests = [];
const turns = new MessageChannel();
turns.port1.onmessage = turn;

const bytesAt = (at, length) => new Uint8Array(engine.memory.buffer, at >>> 0, length >>> 0);
const textAt = (at, length) => new TextDecoder().decode(bytesAt(at, length));
const host = {
  now: () => performance.now(),
  panicked: (at, length) => { panic = textAt(at, length); },
};

async function load(bytes) {
  const imports = { host };
  if (bytes) return WebAssembly.instantiate(bytes, imports);
  const answer = await fetch("carom.wasm");
  if (!answer.ok) throw new Error(`carom.wasm: ${answer.status} ${answer.statusText}`);
  return WebAssembly.instantiate(await answer.arrayBuffer(), imports);
}

// Ends the worker with a reason if the module has ended.
function guarded(act) {
  try {
    act();
  } catch (error) {
    engine = null;
    postMessage({ failed: panic || String(error) });
    close();
  }
}

function execute(text) {
  const bytes = new TextEncoder().encode(text);
  const at = engine.carom_room(bytes.length);
  bytesAt(at, bytes.length).set(bytes);
  engine.carom_receive();
}

function sendAll() {
  for (let kind = engine.carom_take(); kind !== 0; kind = engine.carom_take()) {
    const [at, length] = [engine.carom_message(), engine.carom_length()];
    if (kind === 1) {
      postMessage(textAt(at, length));
    } else {
      const { buffer } = bytesAt(at, length).slice();
      postMessage(buffer, [buffer]);
    }
  }
}

// The next piece: at once, after the messages that wait, or later. A timer alone would wait for
// some milliseconds each time.
function schedule(pause) {
  if (isDue) return;
  clearTimeout(timer);
  timer = null;
  if (pause > 0.5) {
    timer = setTimeout(turn, pause);
  } else {
    isDue = true;
    turns.port2.postMessage(null);
  }
}

function turn() {
  isDue = false;
  if (!engine) return;
  guarded(() => {
    const pause = engine.carom_advance();
    sendAll();
    schedule(pause);
  });
}

function receive(text) {
  guarded(() => {
    execute(text);
    sendAll();
    schedule(0);
  });
}

addEventListener("message", async ({ data }) => {
  if (typeof data === "string") {
    if (engine) receive(data);
    else requests.push(data);
    return;
  }
  try {
    const { instance } = await load(data);
    engine = instance.exports;
  } catch (error) {
    postMessage({ failed: `the engine cannot be loaded: ${error.message || error}` });
    close();
    return;
  }
  guarded(() => {
    engine.carom_start();
    sendAll();
    requests.splice(0).forEach(receive);
    schedule(0);
  });
});
