// Runs the module outside of a browser: reads a task from standard input and writes its result.
import { readFileSync } from "node:fs";

const path = process.argv.at(-1);
const task = JSON.parse(readFileSync(0, "utf8"));
const begun = performance.now();
let panic = "";
const host = {
  now: () => performance.now(),
  panicked: (at, length) => { panic = textAt(at, length); },
};
const { instance } = await WebAssembly.instantiate(readFileSync(path), { host });
const engine = instance.exports;
const bytesAt = (at, length) => new Uint8Array(engine.memory.buffer, at >>> 0, length >>> 0);
const textAt = (at, length) => new TextDecoder().decode(bytesAt(at, length));
const message = () => textAt(engine.carom_message(), engine.carom_length());
function put(text) {
  const bytes = new TextEncoder().encode(text);
  const at = engine.carom_room(bytes.length);
  bytesAt(at, bytes.length).set(bytes);
}

function digest(text) {
  put(text);
  engine.carom_digest();
  return message();
}

// Collisions a second, the median of the reports, and the time of the first frame that has moved.
function speed({ open, seconds }) {
  engine.carom_start();
  put(open);
  engine.carom_receive();
  const window = { centre: [0.5, 0.5], half: [0.6, 0.6], colour: "kind" };
  put(JSON.stringify({ id: 0, do: { view: window } }));
  engine.carom_receive();
  const rates = [];
  let first = null;
  while (performance.now() - begun < 1000 * seconds) {
    engine.carom_advance();
    for (let kind = engine.carom_take(); kind !== 0; kind = engine.carom_take()) {
      if (kind === 1) {
        const { status, refused } = JSON.parse(message());
        if (refused) throw new Error(refused);
        if (status && status.rate > 0) rates.push(status.rate);
        continue;
      }
      const data = new DataView(bytesAt(engine.carom_message(), engine.carom_length()).slice().buffer);
      if (data.getUint32(0, true) !== 1) continue;
      if (first === null && data.getFloat64(8, true) > 0) first = (performance.now() - begun) / 1000;
      put(JSON.stringify({ id: 0, do: { seen: data.getUint32(32, true) } }));
      engine.carom_receive();
    }
  }
  rates.sort((a, b) => a - b);
  return { first, rate: rates[rates.length >> 1] };
}

try {
  const result = task.digests ? task.digests.map(digest) : speed(task.speed);
  process.stdout.write(JSON.stringify(result));
} catch (error) {
  process.stderr.write(`${panic || error.stack}\n`);
  process.exitCode = 1;
}
