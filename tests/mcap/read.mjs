// Reads recordings of `pickline run --record` with Foxglove's own library, and holds their
// schemas to what Foxglove makes fields of. Prints how many messages there are of each topic.
//
// What it makes fields of: docs.foxglove.dev, "Custom schema encodings", and, as that is
// short, the parser of its last open version (Foxglove Studio 1, MPL-2.0).

import { open, readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";

// From run.sh.
const { MODULES } = process.env;
const { McapIndexedReader, McapStreamReader } = createRequire(join(MODULES, "package.json"))(
  "@mcap/core",
);
const [folder] = process.argv.slice(2);
const PLAIN = ["boolean", "string", "number", "integer"];
const failures = [];

function check(holds, text) {
  if (!holds) failures.push(text);
}

/** Holds an object, and what is in it, to what there are fields for. */
function checkObject(schema, path) {
  check(schema.type === "object", `${path}: no object`);
  check(schema.properties instanceof Object, `${path}: no properties`);
  for (const [name, field] of Object.entries(schema.properties ?? {})) {
    checkField(field, `${path}.${name}`);
  }
}

function checkField(field, path, isItem = false) {
  for (const word of ["$ref", "oneOf", "anyOf", "allOf", "contentEncoding"]) {
    check(!(word in field), `${path}: ${word}`);
  }
  if (field.type === "object") {
    checkObject(field, path);
  } else if (field.type === "array" && !isItem) {
    checkField(field.items ?? {}, `${path}[]`, true);
  } else {
    check(PLAIN.includes(field.type), `${path}: type ${JSON.stringify(field.type)}`);
  }
}

function checkChannel(name, channel, schema) {
  const place = `${name}: ${channel.topic}`;
  check(channel.messageEncoding === "json", `${place}: messages in ${channel.messageEncoding}`);
  check(schema?.encoding === "jsonschema", `${place}: schema in ${schema?.encoding}`);
  checkObject(JSON.parse(new TextDecoder().decode(schema.data)), place);
}

function count(counts, name, channel, message) {
  const value = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(message.data));
  const is = value instanceof Object && !Array.isArray(value);
  check(is, `${name}: ${channel.topic}: a message is no object`);
  counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
}

/** One that was finished, by its index, as Foxglove opens it. */
async function whole(name) {
  const file = await open(join(folder, name));
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, length) => {
      const buffer = new Uint8Array(Number(length));
      const { bytesRead } = await file.read(buffer, 0, buffer.length, Number(offset));
      return buffer.subarray(0, bytesRead);
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable });
  check(reader.chunkIndexes.length > 0, `${name}: no index of chunks`);
  for (const channel of reader.channelsById.values()) {
    checkChannel(name, channel, reader.schemasById.get(channel.schemaId));
  }
  const counts = {};
  let last = 0n;
  // It finds them by the index of each chunk: what is not in one is missed here.
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    check(message.logTime >= last, `${name}: log times go back`);
    last = message.logTime;
    count(counts, name, reader.channelsById.get(message.channelId), message);
  }
  // What is on the time line of Foxglove before a message is read.
  const { statistics } = reader;
  check(statistics.messageEndTime === last, `${name}: ends at ${statistics.messageEndTime}`);
  for (const [id, channel] of reader.channelsById) {
    const told = Number(statistics.channelMessageCounts.get(id) ?? 0n);
    const found = counts[channel.topic] ?? 0;
    check(told === found, `${name}: ${channel.topic}: ${told} by the statistics, ${found} found`);
  }
  await file.close();
  return counts;
}

/** One without an index, from its beginning as far as it goes. */
async function torn(name) {
  const reader = new McapStreamReader({ validateCrcs: true });
  reader.append(new Uint8Array(await readFile(join(folder, name))));
  const [channels, schemas, counts] = [new Map(), new Map(), {}];
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") schemas.set(record.id, record);
    if (record.type === "Channel") {
      channels.set(record.id, record);
      checkChannel(name, record, schemas.get(record.schemaId));
    }
    if (record.type === "Message") count(counts, name, channels.get(record.channelId), record);
  }
  return counts;
}

const counts = {
  "messages.mcap": await whole("messages.mcap"),
  "system.mcap": await whole("system.mcap"),
  "killed.mcap": await torn("killed.mcap"),
};
for (const failure of new Set(failures)) console.error(`tests/mcap/read.mjs: ${failure}`);
if (failures.length > 0) process.exit(1);
console.log(JSON.stringify(counts));
