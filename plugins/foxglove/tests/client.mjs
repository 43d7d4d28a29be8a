// Foxglove's own client of its protocol (npm's @foxglove/ws-protocol) reads channels, and does what its arguments say. It decodes
// messages by the schemas that the server advertises, and prints what it has seen as JSON.
//
//   node client.mjs URL SECONDS TOPIC... [--protocol NAME] [--get] [--set NAME=JSON] [--call SERVICE=JSON]

import { createRequire } from "node:module";
import path from "node:path";

// The packages are in the folder that the variable names: they aren't installed beside this file.
const require = createRequire(path.join(process.env.REGATTA_FOXGLOVE_NODE, "package.json"));
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const WebSocket = require("ws");
const protobuf = require("protobufjs");
require("protobufjs/ext/descriptor");

const [url, seconds, ...rest] = process.argv.slice(2);
const topics = [];
const actions = [];
let protocol = "foxglove.sdk.v1";
for (let i = 0; i < rest.length; i++) {
  if (!rest[i].startsWith("--")) topics.push(rest[i]);
  else if (rest[i] === "--protocol") protocol = rest[++i];
  else if (rest[i] === "--get") actions.push({ op: "get" });
  else {
    const [name, value] = rest[i + 1].split(/=(.*)/s);
    actions.push({ op: rest[i++].slice(2), name, value: JSON.parse(value) });
  }
}

const seen = { protocol: null, info: null, channels: {}, services: [], topics: {}, times: 0, statuses: [], parameters: [], answers: [] };
const socket = new WebSocket(url, [protocol]);
const client = new FoxgloveClient({ ws: socket });
const types = new Map();
const subscriptions = new Map();
const services = new Map();

function typeOf(channel) {
  const descriptors = protobuf.descriptor ?? require("protobufjs/ext/descriptor");
  const set = descriptors.FileDescriptorSet.decode(Buffer.from(channel.schema, "base64"));
  return protobuf.Root.fromDescriptor(set).lookupType(channel.schemaName);
}

function plain(type, data) {
  const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  const message = type.toObject(type.decode(bytes), { longs: Number, enums: String, bytes: Array, defaults: true });
  // Lists may be long.
  const text = JSON.stringify(message, (_, value) => {
    if (ArrayBuffer.isView(value)) return { length: value.length };
    return Array.isArray(value) && value.length > 8 ? { length: value.length, first: value[0] } : value;
  });
  return JSON.parse(text);
}

client.on("error", (error) => fail(error));
client.on("open", () => (seen.protocol = socket.protocol));
client.on("serverInfo", (info) => (seen.info = info));
client.on("status", ({ level, message }) => seen.statuses.push({ level, message }));
client.on("time", ({ timestamp }) => { seen.times++; seen.time = Number(timestamp); });
client.on("parameterValues", ({ parameters, id }) => seen.parameters.push({ parameters, id }));
client.on("advertise", (channels) => {
  for (const channel of channels) {
    seen.channels[channel.topic] = channel.schemaName;
    types.set(channel.topic, typeOf(channel));
    if (topics.includes(channel.topic)) subscriptions.set(client.subscribe(channel.id), channel.topic);
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const topic = subscriptions.get(subscriptionId);
  const entry = (seen.topics[topic] ??= { count: 0 });
  entry.count++;
  entry.time = Number(timestamp);
  entry.last = plain(types.get(topic), data);
});
client.on("serviceCallResponse", ({ data }) => seen.answers.push(JSON.parse(Buffer.from(data).toString())));
client.on("serviceCallFailure", ({ message }) => seen.answers.push({ failure: message }));
client.on("advertiseServices", (list) => {
  for (const service of list) services.set(service.name, service.id);
  seen.services = [...services.keys()];
});

// In turn, as a person clicks.
setTimeout(async () => {
  for (const [index, { op, name, value }] of actions.entries()) {
    if (op === "get") client.getParameters([], "all");
    if (op === "set") {
      client.subscribeParameterUpdates([name]);
      client.setParameters([{ name, value }], `set-${name}`);
    }
    if (op === "call") {
      const data = new TextEncoder().encode(JSON.stringify(value));
      client.sendServiceCallRequest({ serviceId: services.get(name), callId: index, encoding: "json", data });
    }
    await new Promise((done) => setTimeout(done, 300));
  }
}, 500);

function fail(error) {
  console.error(String(error));
  process.exit(1);
}

setTimeout(() => {
  process.stdout.write(JSON.stringify(seen), () => process.exit(0));
}, Number(seconds) * 1000);
