// A walk as an Xsens device sends it, through a logger's decoder into a recording, and that through
// the program that reckons walks: it must find what it finds in the columns the walk came from.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <wayfare/decode/xbus.hpp>
#include <wayfare/io/marg_text.hpp>
#include <wayfare/io/mcap_writer.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include "io/support.hpp"

namespace wayfare {
namespace {

using ::wayfare::testing::TemporaryFolder;

void put_vector(std::vector<std::uint8_t>& out, std::uint16_t kind, const Eigen::Vector3d& v) {
  const std::size_t at = out.size();
  out.resize(at + 15);
  decode::store_be(kind, &out[at]);
  out[at + 2] = 12;
  for (std::size_t i = 0; i < 3; ++i)
    decode::store_be(static_cast<float>(v[static_cast<int>(i)]), &out[at + 3 + 4 * i]);
}

/// One MTData2 message: sample time in 0.1 ms, rate, acceleration, field.
std::vector<std::uint8_t> message(const MargSample& s, Duration since) {
  std::vector<std::uint8_t> data = {0x10, 0x60, 4, 0, 0, 0, 0};
  decode::store_be(static_cast<std::uint32_t>(since / std::chrono::microseconds(100)), &data[3]);
  put_vector(data, 0x8020, s.angular_rate_radps);
  put_vector(data, 0x4020, s.specific_force_mps2);
  if (s.magnetic_field_uT.allFinite()) put_vector(data, 0xC020, s.magnetic_field_uT / 49.0);
  std::vector<std::uint8_t> out(data.size() + 8);
  out.resize(decode::write_xbus(0xFF, decode::XbusId::mt_data2, data, out));
  return out;
}

/// Records what the device's decoder makes of the walk; arrivals are late by up to 20 ms.
void record(const MargRecording& walk, const std::string& path) {
  auto writer = io::McapWriter::create(path);
  auto decoder = logger::make_decoder({"unit", "xsens", 115200, ""});
  ASSERT_TRUE(writer && decoder);
  const LogTime start = LogTime::from_nanoseconds(1'700'000'000'000'000'000);
  std::optional<std::uint16_t> channel;
  std::mt19937 random(1);
  Duration before{0};
  for (const MargSample& sample : walk) {
    const Duration since = sample.time - walk.front().time;
    before = std::max(before, since + std::chrono::microseconds(random() % 20'000));
    (*decoder)->feed(message(sample, since), start + before, [&](logger::DecodedMessage m) {
      if (!channel) {
        const auto schema =
            writer->add_schema(m.stream->schema, "jsonschema", m.stream->schema_json);
        channel = *writer->add_channel(m.stream->topic, m.stream->encoding, *schema);
      }
      ASSERT_TRUE(writer->write(*channel, start + before, m.time, m.json));
    });
  }
  EXPECT_EQ((*decoder)->status().messages, walk.size());
  ASSERT_TRUE(writer->close());
}

/// Number behind `what` in the program's table.
double found(const std::string& table, const std::string& what) {
  const auto at = table.find("\n" + what + " ");
  return at == table.npos ? std::nan("") : std::atof(table.c_str() + at + what.size() + 1);
}

std::string pedestrian(const std::string& file, const std::string& out) {
  const std::string command = WAYFARE_PEDESTRIAN " '" + file + "' --out '" + out + "' 2>&1";
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;)
    text.append(buffer, n);
  EXPECT_EQ(::pclose(pipe), 0) << text;
  return text;
}

TEST(LoggedWalk, IsReckonedAsItsColumnsAre) {
  const TemporaryFolder folder;
  const auto walk = io::read_marg(WAYFARE_WALK);
  ASSERT_TRUE(walk);
  record(walk->samples, folder / "walk.mcap");
  const std::string columns = pedestrian(WAYFARE_WALK, folder / "columns");
  const std::string logged = pedestrian(folder / "walk.mcap", folder / "logged");
  EXPECT_GT(found(columns, "steps"), 70.0) << columns;
  EXPECT_EQ(found(logged, "steps"), found(columns, "steps")) << logged;
  // Single precision on the wire, and stamps by the least late of the arrivals.
  EXPECT_NEAR(found(logged, "length"), found(columns, "length"), 0.005 * found(columns, "length"));
}

}  // namespace
}  // namespace wayfare
