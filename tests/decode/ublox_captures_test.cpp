// Recorded bytes of u-blox receivers, decoded, and walked through by their checksums alone.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/nmea.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ubx_messages.hpp>
#include <wayfare/decode/xbus.hpp>

#include "captures.hpp"
#include "core/counted_heap.hpp"
#include "ubx_streams.hpp"

namespace wayfare::decode {
namespace {

using Counts = std::map<std::string, std::size_t>;

/// Messages by their class and id, found by the sync characters and the checksum of RFC 1145.
Counts walk_ubx(const std::vector<std::uint8_t>& b) {
  Counts counts;
  for (std::size_t i = 0; i + 8 <= b.size();) {
    const std::size_t length = b[i + 4] + 256U * b[i + 5], end = i + 6 + length;
    unsigned sum_a = 0, sum_b = 0;
    if (b[i] == 0xB5 && b[i + 1] == 0x62 && end + 2 <= b.size()) {
      for (std::size_t k = i + 2; k < end; ++k) sum_a += b[k], sum_b += sum_a;
      if ((sum_a & 255U) == b[end] && (sum_b & 255U) == b[end + 1]) {
        ++counts[std::to_string(b[i + 2]) + "-" + std::to_string(b[i + 3])];
        i = end + 2;
        continue;
      }
    }
    ++i;
  }
  return counts;
}

/// Sentences by their address, found by $, * and the checksum.
Counts walk_nmea(const std::vector<std::uint8_t>& b) {
  Counts counts;
  std::string sentence;
  for (std::size_t i = 0; i < b.size(); ++i) {
    const auto c = static_cast<char>(b[i]);
    if (c == '$' || c == '!') {
      sentence.clear();
    } else if (c == '*' && i + 2 < b.size()) {
      unsigned sum = 0;
      for (const char s : sentence) sum ^= static_cast<unsigned char>(s);
      std::array<char, 3> text{};
      std::snprintf(text.data(), text.size(), "%02X", sum);
      const bool good =
          text[0] == static_cast<char>(b[i + 1]) && text[1] == static_cast<char>(b[i + 2]);
      if (good && sentence.find_first_of("\r\n") == sentence.npos && sentence.size() > 4)
        ++counts[sentence.substr(0, sentence.find(','))];
      sentence.clear();
    } else {
      sentence += c;
    }
  }
  return counts;
}

template <class Decoder, class Name>
Counts decoded(const std::vector<std::uint8_t>& bytes, const Name& name) {
  Counts counts;
  const auto decoder = std::make_unique<Decoder>();
  const auto sink = [&](const auto& m) { ++counts[name(m)]; };
  decoder->feed(bytes, sink);
  decoder->finish(sink);
  return counts;
}

std::string name_of(const UbxMessage& m) {
  const auto id = static_cast<unsigned>(m.id());
  return std::to_string(id >> 8U) + "-" + std::to_string(id & 255U);
}

class UbloxCaptures : public ::testing::TestWithParam<const char*> {};

TEST_P(UbloxCaptures, HoldTheMessagesThatAWalkByChecksumsFinds) {
  WAYFARE_NEEDS_RECORDING(path, std::string("devices/ublox/pygpsdata-") + GetParam() + ".log");
  const auto bytes = testing::file_bytes(path);
  const Counts ubx = decoded<UbxDecoder>(bytes, name_of);
  const Counts nmea = decoded<NmeaDecoder>(
      bytes, [](const NmeaSentence& s) { return std::string(s.talker()) + std::string(s.type()); });
  EXPECT_EQ(ubx, walk_ubx(bytes));
  EXPECT_EQ(nmea, walk_nmea(bytes));
  EXPECT_FALSE(ubx.empty() && nmea.empty());
}

INSTANTIATE_TEST_SUITE_P(Recorded, UbloxCaptures,
                         ::testing::Values("BADHDR", "MIXED", "MIXED2", "NAV", "NMEA", "RXM"));

TEST(UbloxCaptures, CountsOfTheWalk) {
  WAYFARE_NEEDS_RECORDING(path, "gnss/walk_0827/gnss_1730.ubx.gz");
  const auto bytes = testing::file_bytes(path);
  const Counts ubx = decoded<UbxDecoder>(bytes, name_of);
  EXPECT_EQ(ubx, walk_ubx(bytes));
  // Counted by a script of another language.
  EXPECT_EQ(ubx, (Counts{{"1-7", 536}, {"2-19", 2328}, {"2-21", 536}}));
}

/// Random bytes, with starts of frames among them.
std::vector<std::uint8_t> noise(std::span<const std::uint8_t> starts) {
  Rng rng(3);
  std::vector<std::uint8_t> bytes(50'000);
  for (std::uint8_t& b : bytes)
    b = rng.below(4) == 0 ? starts[rng.below(starts.size())] : static_cast<std::uint8_t>(rng());
  return bytes;
}

/// Allocations of a decoder fed in chunks.
template <class Decoder>
std::size_t allocations_of(const std::vector<std::uint8_t>& bytes) {
  const auto decoder = std::make_unique<Decoder>();
  std::size_t messages = 0;
  const auto sink = [&](const auto& /*message*/) { ++messages; };
  const std::size_t before = tests::allocations;
  for (std::size_t i = 0; i < bytes.size(); i += 37)
    decoder->feed(Bytes(bytes).subspan(i, std::min<std::size_t>(37, bytes.size() - i)), sink);
  decoder->finish(sink);
  return tests::allocations - before;
}

TEST(DecodersNoHeap, NothingIsAllocatedWhateverTheBytes) {
  WAYFARE_NEEDS_COUNTED_HEAP();
  constexpr std::uint8_t kUbx[] = {0xB5, 0x62, 0x02, 0x15, 0x00}, kNmea[] = {'$', 'G', ',', '*'},
                         kXbus[] = {0xFA, 0xFF, 0x36}, kTi[] = {0x02, 0x01, 0x04, 0x03},
                         kRplidar[] = {0xA5, 0x5A, 0x81};
  UbxBytes stream = noise(kUbx);
  append_bytes(stream, rawx({1.0, 2200, 18, true, false}, sample_measurements()));
  EXPECT_EQ(allocations_of<UbxDecoder>(stream), 0U);
  EXPECT_EQ(allocations_of<NmeaDecoder>(noise(kNmea)), 0U);
  EXPECT_EQ(allocations_of<XbusDecoder>(noise(kXbus)), 0U);
  EXPECT_EQ(allocations_of<TiDecoder>(noise(kTi)), 0U);
  EXPECT_EQ(allocations_of<RplidarDecoder>(noise(kRplidar)), 0U);
}

/// What the contents are read by does not allocate either.
TEST(DecodersNoHeap, ContentsOfReceiversMessages) {
  WAYFARE_NEEDS_COUNTED_HEAP();
  UbxBytes bytes = rawx({1.0, 2200, 18, true, false}, sample_measurements());
  append_bytes(bytes, ubx(UbxId::nav_pvt, UbxBytes(92)));
  append_bytes(bytes, ubx(UbxId::rxm_sfrbx, {0, 17, 0, 0, 1, 0, 2, 0, 1, 2, 3, 4}));
  const std::string text =
      "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"
      "$GPRMC,225446,A,4916.45,N,12311.12,W,000.5,054.7,191194,020.3,E*68\r\n";
  const auto ubx_decoder = std::make_unique<UbxDecoder>();
  const auto nmea_decoder = std::make_unique<NmeaDecoder>();
  double sum = 0.0;
  const std::size_t before = tests::allocations;
  ubx_decoder->feed(bytes, [&](const UbxMessage& m) {
    if (const auto raw = rxm_rawx(m))
      for (std::size_t i = 0; i < raw->size(); ++i) sum += raw->measurement(i).pseudorange_m;
    if (const auto frame = rxm_sfrbx(m)) sum += frame->word(0);
    if (const auto pvt = nav_pvt(m)) sum += pvt->latitude_deg;
  });
  nmea_decoder->feed({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()},
                     [&](const NmeaSentence& s) {
                       if (const auto fix = nmea_gga(s)) sum += fix->latitude_deg;
                       if (const auto motion = nmea_rmc(s)) sum += motion->latitude_deg;
                     });
  EXPECT_EQ(tests::allocations, before);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace wayfare::decode
