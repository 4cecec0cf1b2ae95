// Reads an MCAP file as another library understands it: node read.js FILE indexed|streaming
// prints one line a message (topic, sequence, log time, publish time, CRC-32 of its bytes).
import { open } from "node:fs/promises";
import { crc32, McapIndexedReader, McapStreamReader } from "./peer.js";

const [path, how] = process.argv.slice(2);
const file = await open(path, "r");
const size = (await file.stat()).size;
const topics = new Map();

function print(message, schemas) {
  const channel = topics.get(message.channelId);
  const schema = channel.schemaId === 0 ? "-" : schemas.get(channel.schemaId).name;
  console.log(
    `${channel.topic} ${schema} ${message.sequence} ${message.logTime} ${message.publishTime} ${crc32(message.data)}`,
  );
}

async function read(offset, length) {
  const bytes = new Uint8Array(Number(length));
  const { bytesRead } = await file.read(bytes, 0, bytes.length, Number(offset));
  if (bytesRead !== bytes.length) throw new Error("short read");
  return bytes;
}

if (how === "indexed") {
  const readable = { size: async () => BigInt(size), read };
  const reader = await McapIndexedReader.Initialize({ readable });
  for (const [id, channel] of reader.channelsById) topics.set(id, channel);
  for await (const message of reader.readMessages()) print(message, reader.schemasById);
  console.log(`total ${reader.statistics.messageCount} chunks ${reader.chunkIndexes.length}`);
  for await (const record of reader.readMetadata()) console.log(`metadata ${record.name}`);
} else {
  const reader = new McapStreamReader({ validateCrcs: true });
  const schemas = new Map();
  reader.append(await read(0, size));
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") schemas.set(record.id, record);
    if (record.type === "Channel") topics.set(record.id, record);
    if (record.type === "Message") print(record, schemas);
  }
  console.log(reader.done() ? "done" : "not done");
}
