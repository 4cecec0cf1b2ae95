// Reads a ROS 2 recording as viewers do: node read.js FILE prints one line a message, decoded by
// the schema that is in the file.
import { open } from "node:fs/promises";
import rosmsg from "@foxglove/rosmsg";
import serialization from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader } from "@mcap/core";

const file = await open(process.argv[2], "r");
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    await file.read(bytes, 0, bytes.length, Number(offset));
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({ readable });
console.log(`profile ${reader.header.profile}`);
const decoders = new Map();
for (const [id, channel] of reader.channelsById) {
  const schema = reader.schemasById.get(channel.schemaId);
  const text = new TextDecoder().decode(schema.data);
  const decoder = new serialization.MessageReader(rosmsg.parse(text, { ros2: true }));
  decoders.set(id, { topic: channel.topic, type: schema.name, decoder });
}

function words(topic, m) {
  const stamp = (header) => `${header.stamp.sec} ${header.stamp.nanosec} ${header.frame_id}`;
  if (topic === "/scan")
    return [stamp(m.header), m.ranges.length, m.ranges[0], m.ranges[480], m.range_max];
  if (topic === "/odom") {
    const { position, orientation } = m.pose.pose;
    return [stamp(m.header), m.child_frame_id, position.x, position.y, orientation.z, orientation.w];
  }
  if (topic === "/radar") return [stamp(m.header), m.width, ...m.x, ...m.velocities];
  if (topic === "/imu")
    return [stamp(m.header), m.angular_velocity.z, m.linear_acceleration_covariance[0]];
  if (topic === "/truth")
    return [stamp(m.header), m.pose.position.x, m.pose.position.y, m.pose.orientation.z];
  const { header, child_frame_id, transform } = m.transforms[0];
  return [m.transforms.length, stamp(header), child_frame_id, transform.translation.x];
}

for await (const message of reader.readMessages()) {
  const { topic, type, decoder } = decoders.get(message.channelId);
  console.log([topic, type, ...words(topic, decoder.readMessage(message.data))].join(" "));
}
