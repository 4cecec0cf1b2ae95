// The bytes of an inertial unit (Xsens MTi), as a serial line delivers them: in pieces that do not
// end where messages end, after noise, and with one message damaged.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/xbus.hpp>

using namespace wayfare;

int main() {
  const std::vector<std::uint8_t> message{
      0xFA, 0xFF, 0x36, 0x1E,                                      // MTData2, 30 bytes
      0x40, 0x20, 0x0C,                                            // acceleration, three floats:
      0,    0,    0,    0,    0x3F, 0,    0, 0, 0x41, 0x1C, 0, 0,  // 0, 0.5, 9.75 m/s²
      0x80, 0x20, 0x0C,                                            // rate of turn, three floats:
      0x3F, 0,    0,    0,    0xBE, 0x80, 0, 0, 0,    0,    0, 0,  // 0.5, -0.25, 0 rad/s
      0x7C};                                                       // checksum
  std::vector<std::uint8_t> stream{0x13, 0x37, 0x42};              // noise
  for (int i = 0; i < 4; ++i) stream.insert(stream.end(), message.begin(), message.end());
  stream[60] ^= 0x01;  // a bit of the second message

  decode::XbusDecoder decoder;
  const auto sink = [](const decode::XbusMessage& received) {
    const auto sample = decode::mt_sample(received.data());
    if (received.id() != decode::XbusId::mt_data2 || !sample) return;
    const auto imu = decode::to_imu_sample(*sample, LogTime());
    if (!imu) return;
    const Eigen::Vector3d& rate = imu->angular_rate_radps;
    const Eigen::Vector3d& force = imu->specific_force_mps2;
    std::printf("byte %3d: rate %.2f %.2f %.2f rad/s, force %.2f %.2f %.2f m/s2\n",
                static_cast<int>(received.position()), rate.x(), rate.y(), rate.z(), force.x(),
                force.y(), force.z());
  };
  for (std::size_t at = 0; at < stream.size(); at += 8) {
    const decode::Bytes all(stream);
    decoder.feed(all.subspan(at, std::min<std::size_t>(8, all.size() - at)), sink);
  }
  decoder.finish(sink);

  const decode::DecoderStatistics& s = decoder.statistics();
  std::printf("%d messages, %d wrong checksum, %d bytes skipped\n", static_cast<int>(s.frames),
              static_cast<int>(s.checksum_failures), static_cast<int>(s.skipped_bytes));
}
