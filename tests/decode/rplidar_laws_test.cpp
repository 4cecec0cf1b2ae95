#include <memory>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/testing/decoder_laws.hpp>

#include "rplidar_streams.hpp"

namespace wayfare::decode {
namespace {

testing::DecoderLaws<RplidarDecoder> laws_of(const Stream& stream, RplidarResponse inside) {
  testing::DecoderLaws<RplidarDecoder> laws{stream, kAsText};
  laws.make = [inside] { return std::make_unique<RplidarDecoder>(RplidarFraming(inside)); };
  laws.work_per_byte = 2.0 * RplidarFraming::kCapacity;
  return laws;
}

Stream random_capsules(RplidarResponse response, int count) {
  Rng rng(5);
  Stream stream;
  for (int i = 0; i < count; ++i) {
    Stream contents(response == RplidarResponse::ultra ? 128 : 80);
    for (auto& byte : contents) byte = static_cast<std::uint8_t>(rng());
    append(stream, capsule(i * 700 % (360 * 64), contents, i == 0));
  }
  return stream;
}

TEST(RplidarLaws, Capsules) {
  for (const auto response :
       {RplidarResponse::express, RplidarResponse::ultra, RplidarResponse::dense}) {
    const auto laws = laws_of(random_capsules(response, 20), response);
    laws.check();
    const testing::DamageReport report = laws.damage(10000);
    report.record("capsules_" + std::to_string(static_cast<int>(response)));
    EXPECT_EQ(report.lost, 0U);
    // An XOR of eight bits: one damaged capsule in 256 passes and may hide its neighbour.
    EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(256.0));
    EXPECT_LE(report.hidden, 2 * report.false_frames);
    EXPECT_GT(report.undamaged, 100'000U);
  }
}

Stream random_bytes_of(RplidarResponse response, int count) {
  Rng rng(5);
  Stream stream;
  std::vector<std::uint32_t> codes(64);
  std::vector<HqNode> nodes(96);
  for (int i = 0; i < count; ++i) {
    for (auto& code : codes) code = static_cast<std::uint32_t>(rng.below(1U << 20));
    for (auto& n : nodes)
      n = {static_cast<std::uint16_t>(rng()), static_cast<std::uint32_t>(rng()),
           static_cast<std::uint8_t>(rng()), static_cast<std::uint8_t>(rng())};
    append(stream, response == RplidarResponse::hq
                       ? hq_capsule(nodes, rng())
                       : ultra_dense_capsule(i * 700 % (360 * 64), codes, i == 0));
  }
  return stream;
}

TEST(RplidarLaws, UltraDenseCapsules) {
  const auto laws =
      laws_of(random_bytes_of(RplidarResponse::ultra_dense, 20), RplidarResponse::ultra_dense);
  laws.check();
  const testing::DamageReport report = laws.damage(10000);
  report.record("ultra_dense");
  EXPECT_EQ(report.lost, 0U);
  EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(256.0));
  EXPECT_LE(report.hidden, 2 * report.false_frames);
}

TEST(RplidarLaws, HqCapsules) {
  const auto laws = laws_of(random_bytes_of(RplidarResponse::hq, 8), RplidarResponse::hq);
  laws.check();
  const testing::DamageReport report = laws.damage(1500);
  report.record("hq");
  EXPECT_EQ(report.lost, 0U);
  EXPECT_EQ(report.false_frames, 0U);  // 32 bits
}

TEST(RplidarLaws, SingleAnswers) {
  Stream stream;
  for (int i = 0; i < 10; ++i) {
    append(stream, descriptor(RplidarResponse::health, 3, false));
    append(stream, {0, 0, 0});
  }
  laws_of(stream, RplidarResponse::none).any_split_gives_the_same();
  laws_of(stream, RplidarResponse::none).work_is_bounded();
}

TEST(RplidarLaws, Nodes) {
  Rng rng(6);
  Stream nodes;
  for (int i = 0; i < 200; ++i) {
    const int angle_q6 = i * 76 % (360 * 64);
    append(nodes, node(angle_q6, static_cast<int>(rng.below(20000)),
                       static_cast<int>(rng.below(48)), angle_q6 < 76));
  }
  const auto laws = laws_of(nodes, RplidarResponse::node);
  laws.any_split_gives_the_same();
  laws.work_is_bounded();
  const testing::DamageReport report = laws.damage(10000);
  report.record("nodes");
  // Three check bits and no checksum: damage causes at most one false node, and in one of fifty
  // cases hides a neighbour or breaks the chain that would confirm it.
  EXPECT_LE(report.false_frames, report.edits);
  EXPECT_LE(report.lost + report.hidden, report.edits / 50);
  EXPECT_GT(report.undamaged, 1'900'000U);
}

}  // namespace
}  // namespace wayfare::decode
