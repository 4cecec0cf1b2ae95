// The start of an RPLIDAR against one that is simulated by the manual, in simulated time.
#include <wayfare/decode/rplidar_start.hpp>

#include <algorithm>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/rplidar_stream.hpp>
#include <wayfare/testing/decoder_laws.hpp>

#include "rplidar_streams.hpp"
#include "simulated_rplidar.hpp"

namespace wayfare::decode {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using State = RplidarStart::State;

/// The device on its line, and what a logger decodes.
struct OnLine {
  explicit OnLine(const std::string& mode = "typical") : start(mode) {}

  void pass(Duration time) {
    for (const LogTime end = now + time; now < end; now += 10ms) {
      const Stream bytes = device.sent(10ms);
      stream.feed(bytes, now, [&](const RplidarRevolution& r) {
        ++turns;
        sample = r.points[11].time - r.points[10].time;
      });
      device.take(start.step(bytes, now).bytes());
    }
  }

  SimulatedRplidar device;
  RplidarStart start;
  RplidarStream stream{115200};
  LogTime now = LogTime::from_seconds(1e9);
  int turns = 0;
  Duration sample{0};
};

TEST(RplidarStart, IdentifiesChecksAndStarts) {
  OnLine run;
  run.pass(3s);
  EXPECT_EQ(run.start.state(), State::scanning) << run.start.problem();
  EXPECT_EQ(run.start.problem(), "");
  EXPECT_EQ(
      run.start.identity().text(),
      "A1M8, firmware 1.29, hardware 7, serial number A0A1A2A3A4A5A6A7A8A9AAABACADAEAF, health "
      "good, mode Express");
  EXPECT_EQ(run.start.identity().scan, RplidarResponse::express);
  EXPECT_TRUE(run.start.motor_by_dtr());
  // Stop, information, health, sample times; typical mode, its name, answer, sample; scan.
  EXPECT_THAT(run.device.commands,
              ElementsAre(0x25, 0x50, 0x52, 0x59, 0x84, 0x84, 0x84, 0x84, 0x82));
  EXPECT_GT(run.turns, 10);
  EXPECT_EQ(run.sample, 254us) << "as the mode tells";
}

TEST(RplidarStart, StopsAScanThatRuns) {
  for (const auto running : {RplidarResponse::node, RplidarResponse::express}) {
    OnLine run("standard");
    run.device.scan(running);
    run.pass(3s);
    EXPECT_EQ(run.start.state(), State::scanning) << run.start.problem();
    EXPECT_EQ(run.start.identity().scan, RplidarResponse::node);
    EXPECT_EQ(run.device.count(0x25), 1U);
    EXPECT_EQ(run.device.count(0x20), 1U);
    EXPECT_GT(run.turns, 20);
  }
}

TEST(RplidarStart, StartsAgainAfterAReset) {
  OnLine run;
  run.pass(3s);
  ASSERT_EQ(run.start.state(), State::scanning);
  run.device.reset();
  run.pass(3s);
  EXPECT_EQ(run.start.state(), State::scanning);
  EXPECT_TRUE(run.device.scanning());
  EXPECT_EQ(run.device.count(0x82), 2U);
  EXPECT_EQ(run.start.problem(), "");
}

TEST(RplidarStart, ResetsADeviceWithAnError) {
  OnLine run;
  run.device.health = 2;
  run.pass(5s);
  EXPECT_EQ(run.device.resets, 1);
  EXPECT_EQ(run.start.state(), State::scanning);
  OnLine worse;
  worse.device.health = 2;
  worse.device.reset_heals = false;
  worse.pass(5s);
  EXPECT_EQ(worse.device.resets, 1);
  EXPECT_EQ(worse.start.state(), State::faulty);
  EXPECT_THAT(worse.start.problem(), HasSubstr("error 0x1234 after a reset"));
  worse.device.reset_heals = true;
  worse.pass(15s);
  EXPECT_EQ(worse.device.resets, 2);
  EXPECT_EQ(worse.start.state(), State::scanning);
}

TEST(RplidarStart, ReportsAWarning) {
  OnLine run;
  run.device.health = 1;
  run.pass(3s);
  EXPECT_EQ(run.start.state(), State::scanning);
  EXPECT_THAT(run.start.problem(), HasSubstr("warning 0x1234"));
}

TEST(RplidarStart, DecodesTheScanOfADeviceThatDoesNotAnswer) {
  for (const auto running : {RplidarResponse::node, RplidarResponse::express}) {
    OnLine run;
    run.device.deaf = true;
    run.device.scan(running);
    run.pass(6s);
    EXPECT_EQ(run.start.state(), State::unanswered);
    EXPECT_EQ(run.start.identity().scan, running);
    EXPECT_THAT(run.start.problem(), HasSubstr("no answer"));
    EXPECT_GT(run.turns, 20) << static_cast<int>(running);
  }
}

TEST(RplidarStart, AsksAgainUntilThereIsAnAnswer) {
  OnLine run;
  run.device.deaf = true;
  run.pass(10s);
  EXPECT_EQ(run.start.state(), State::unanswered);
  run.device.deaf = false;  // it was plugged in
  run.pass(6s);
  EXPECT_EQ(run.start.state(), State::scanning);
}

TEST(RplidarStart, TellsOfAMotorThatStandsStill) {
  OnLine run;
  run.device.turning = false;
  run.pass(8s);
  EXPECT_THAT(run.start.problem(), HasSubstr("motor"));
  run.device.turning = true;
  run.pass(8s);
  EXPECT_EQ(run.start.state(), State::scanning);
  EXPECT_EQ(run.start.problem(), "");
}

TEST(RplidarStart, ChoosesTheMode) {
  struct Case {
    std::string wanted;
    std::uint8_t firmware;
    RplidarResponse scan;
    std::string mode, problem;
  };
  const std::vector<Case> cases = {
      {"standard", 29, RplidarResponse::node, "Standard", ""},
      {"EXPRESS", 29, RplidarResponse::express, "Express", ""},
      {"1", 29, RplidarResponse::express, "Express", ""},
      {"Boost", 29, RplidarResponse::express, "Express", "no mode Boost"},
      {"Odd", 29, RplidarResponse::node, "Standard", "not decoded"},
      {"typical", 20, RplidarResponse::express, "Express", ""},
      {"Boost", 20, RplidarResponse::express, "Express", "no mode Boost"},
      {"typical", 10, RplidarResponse::node, "Standard", ""},
  };
  for (const Case& c : cases) {
    OnLine run(c.wanted);
    run.device.firmware_minor = c.firmware;
    run.device.modes.push_back({"Odd", RplidarResponse::info, 100.0});
    run.pass(4s);
    const std::string what = c.wanted + ", 1." + std::to_string(c.firmware);
    EXPECT_EQ(run.start.state(), State::scanning) << what << run.start.problem();
    EXPECT_EQ(run.start.identity().scan, c.scan) << what;
    EXPECT_EQ(run.start.identity().mode, c.mode) << what;
    EXPECT_THAT(run.start.problem(), HasSubstr(c.problem)) << what;
    EXPECT_EQ(run.start.problem().empty(), c.problem.empty()) << what;
  }
}

TEST(RplidarStart, TurnsTheMotorByModel) {
  for (const auto& [model, duty, speed] : {std::tuple(0x28, 1U, 0U), std::tuple(0x61, 0U, 1U)}) {
    OnLine run;
    run.device.model = static_cast<std::uint8_t>(model);
    run.pass(3s);
    EXPECT_EQ(run.start.state(), State::scanning) << model;
    EXPECT_FALSE(run.start.motor_by_dtr());
    EXPECT_EQ(run.device.count(0xF0), duty);
    EXPECT_EQ(run.device.count(0xA8), speed);
  }
}

// The device wants 630 turns per minute and a duty cycle of 700. A5 ^ F0 ^ 02 ^ BC ^ 02 = E9,
// A5 ^ A8 ^ 02 ^ 76 ^ 02 = 7B, A5 ^ 82 ^ 05 ^ 01 = 23; 660 is the makers' default.
TEST(RplidarStart, TurnsTheMotorAsTheDeviceWants) {
  struct Case {
    std::uint8_t model, board, firmware;
    std::size_t asks_board;
    std::string duty, speed;
  };
  const std::vector<Case> cases = {
      {0x1F, 1, 29, 0, "", ""},               // an A1 is turned by DTR
      {0x20, 1, 29, 1, "A5F002BC02E9", ""},   // the first with a board
      {0x20, 0, 29, 1, "", ""},               // one that does not turn it
      {0x20, 2, 29, 1, "", ""},               // nor this
      {0x20, 1, 23, 1, "A5F0029402C1", ""},   // no wish before firmware 1.24
      {0x41, 1, 29, 1, "A5F002BC02E9", ""},   // series C
      {0x5F, 1, 29, 1, "A5F002BC02E9", ""},   // the last
      {0x60, 1, 29, 0, "", "A5A80276027B"}};  // series S, by its own motor
  for (const Case& c : cases) {
    OnLine run;
    run.device.model = c.model;
    run.device.board = c.board;
    run.device.firmware_minor = c.firmware;
    run.pass(3s);
    const std::string what = hex(Stream{c.model, c.board, c.firmware});
    EXPECT_EQ(run.start.state(), State::scanning) << what;
    EXPECT_EQ(run.start.motor_by_dtr(), c.model < 0x20) << what;
    EXPECT_EQ(run.device.count(0xFF), c.asks_board) << what;
    EXPECT_EQ(run.device.request(0xF0), c.duty) << what;
    EXPECT_EQ(run.device.request(0xA8), c.speed) << what;
    if (c.firmware >= 24) {
      EXPECT_EQ(run.device.request(0x82),
                "A582050100000000"
                "23")
          << what;
    }
  }
}

// Times of samples are queried from firmware 1.17 on, modes from 1.24 on or of any series after A.
TEST(RplidarStart, AsksWhatTheFirmwareKnows) {
  struct Case {
    std::uint8_t model, firmware;
    bool asks_sample, asks_modes;
    std::string mode;
  };
  for (const Case& c : {Case{0x18, 16, false, false, "Standard"},
                        {0x18, 17, true, false, "Express"},
                        {0x3F, 23, true, false, "Express"},
                        {0x18, 24, true, true, "Express"},
                        {0x41, 23, true, true, "Standard"}}) {  // which is not answered
    OnLine run;
    run.device.model = c.model;
    run.device.firmware_minor = c.firmware;
    run.pass(5s);
    const std::string what = hex(Stream{c.model, c.firmware});
    EXPECT_EQ(run.start.state(), State::scanning) << what;
    EXPECT_EQ(run.device.count(0x59) != 0, c.asks_sample) << what;
    EXPECT_EQ(run.device.count(0x84) != 0, c.asks_modes) << what;
    EXPECT_EQ(run.start.identity().mode, c.mode) << what;
    EXPECT_EQ(run.start.problem().empty(), c.model != 0x41) << what;
  }
}

// In steps of 10 ms, of which the first is at 0: 100 ms after a stop, 10 ms after the motor, 0.5 s
// for each of two answers.
TEST(RplidarStart, WaitsForItsAnswers) {
  OnLine run;
  run.device.model = 0x28;
  run.pass(100ms);
  EXPECT_THAT(run.device.commands, ElementsAre(0x25));
  run.pass(10ms);
  EXPECT_THAT(run.device.commands, ElementsAre(0x25, 0x50));
  while (run.device.count(0xF0) == 0 && run.now < LogTime::from_seconds(1e9 + 3.0)) run.pass(10ms);
  EXPECT_EQ(run.device.count(0x82), 0U);
  run.pass(10ms);
  EXPECT_EQ(run.device.count(0x82), 1U);

  OnLine silent;
  silent.device.deaf = true;
  silent.pass(1100ms);
  EXPECT_EQ(silent.start.state(), State::starting);
  silent.pass(10ms);
  EXPECT_EQ(silent.start.state(), State::unanswered);
  silent.pass(990ms);  // a second
  EXPECT_EQ(silent.start.state(), State::unanswered);
  silent.pass(10ms);
  EXPECT_EQ(silent.start.state(), State::starting);
}

// A second without packets after a scan, five before its first, ten after an error, one after a
// reset.
TEST(RplidarStart, AsksAgainAfterTheTimesOfItsStates) {
  OnLine lost;
  lost.pass(3s);
  lost.device.turning = false;
  lost.pass(950ms);
  EXPECT_EQ(lost.device.count(0x25), 1U);
  lost.pass(100ms);
  EXPECT_EQ(lost.device.count(0x25), 2U);

  OnLine still;
  still.device.turning = false;
  for (int i = 0; i < 300 && !still.device.scanning(); ++i) still.pass(10ms);
  still.pass(4950ms);
  EXPECT_EQ(still.device.count(0x25), 1U);
  still.pass(100ms);
  EXPECT_EQ(still.device.count(0x25), 2U);

  OnLine faulty;
  faulty.device.health = 2;
  faulty.device.reset_heals = false;
  for (int i = 0; i < 500 && faulty.device.resets == 0; ++i) faulty.pass(10ms);
  faulty.pass(990ms);
  EXPECT_EQ(faulty.device.count(0x25), 1U);
  faulty.pass(10ms);
  EXPECT_EQ(faulty.device.count(0x25), 2U);
  for (int i = 0; i < 500 && faulty.start.state() != State::faulty; ++i) faulty.pass(10ms);
  faulty.pass(9950ms);
  EXPECT_EQ(faulty.device.count(0x25), 2U);
  faulty.pass(100ms);
  EXPECT_EQ(faulty.device.count(0x25), 3U);
}

TEST(RplidarStart, NamesTheModels) {
  // As the maker's library: A series below 4, then C, S, T and M from 4, 6, 9 and 12 on.
  EXPECT_EQ(rplidar_model_name(0x18), "A1M8");
  EXPECT_EQ(rplidar_model_name(0x31), "A3M1");
  EXPECT_EQ(rplidar_model_name(0x41), "C1M1");
  EXPECT_EQ(rplidar_model_name(0x71), "S2M1");
  EXPECT_EQ(rplidar_model_name(0x91), "T1M1");
  EXPECT_EQ(rplidar_model_name(0xC0), "M1M0");
}

TEST(RplidarStart, SurvivesNoise) {
  Rng rng(1);
  RplidarStart start;
  LogTime now;
  std::size_t sent = 0;
  for (int i = 0; i < 20'000; ++i, now += 10ms) {
    Stream noise(rng.below(60));
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(rng());
    sent += start.step(noise, now).size;
    ASSERT_NE(start.state(), State::scanning);
  }
  EXPECT_LT(sent, 20'000U) << "of 200 seconds";
}

// --- a scan without a descriptor -----------------------------------------------------------------

Stream running_nodes() {
  Stream nodes;
  for (int i = 0; i < 400; ++i) append(nodes, node(i * 76 % (360 * 64), 4000 + i, 15, false));
  return nodes;
}

// Twelve nodes over half a degree, 32/64°, are a run; a laser that hardly turns has none.
TEST(RplidarRunning, TwelveNodesOverHalfADegree) {
  for (const auto& [count, travel_q6, run] :
       {std::tuple(12, 32, true), std::tuple(12, 31, false), std::tuple(11, 600, false)}) {
    Stream nodes;
    for (int i = 0; i < count; ++i) append(nodes, node(360 * 64 - 1, 4000));
    const Stream last = node(travel_q6 - 1, 4000);
    std::copy(last.begin(), last.end(), nodes.end() - 5);
    EXPECT_EQ(is_rplidar_run(nodes), run) << count << ", " << travel_q6;
  }
}

TEST(RplidarRunning, NodesAreFoundFromAnyByteOn) {
  const Stream all = running_nodes();
  for (std::size_t skip = 0; skip < 5; ++skip) {
    RplidarDecoder decoder{RplidarFraming::running()};
    std::size_t nodes = 0;
    const auto sink = [&](const RplidarPacket& p) {
      nodes += p.response() == RplidarResponse::node ? 1 : 0;
    };
    decoder.feed(Bytes(all).subspan(skip), sink);
    decoder.finish(sink);
    EXPECT_EQ(nodes, skip == 0 ? 400U : 399U);
  }
}

TEST(RplidarRunning, CapsulesAreTakenByTheirKind) {
  Rng rng(3);
  for (const auto kind : {RplidarResponse::express, RplidarResponse::dense, RplidarResponse::ultra,
                          RplidarResponse::ultra_dense}) {
    Stream stream;
    for (int i = 0; i < 20; ++i) {
      Stream contents(rplidar_packet_bytes(kind) - 4);
      for (auto& byte : contents) byte = static_cast<std::uint8_t>(rng());
      // A wall: distances within a few millimetres of each other, the rest by chance.
      if (kind == RplidarResponse::dense)
        for (std::size_t k = 0; k < 80; k += 2)
          store_le(static_cast<std::uint16_t>(2000 + rng.below(9)), &contents[k]);
      if (kind == RplidarResponse::express)
        for (std::size_t k = 0; k < 80; k += 5)
          for (const std::size_t at : {k, k + 2})
            store_le(static_cast<std::uint16_t>((2000 + rng.below(9)) << 2 | rng.below(4)),
                     &contents[at]);
      const int angle_q6 = i * 20 * 64 % (360 * 64);
      const std::vector<std::uint32_t> codes(
          64, ultra_dense_code(0, 300U + static_cast<unsigned>(rng.below(9)), 40));
      append(stream, kind == RplidarResponse::ultra_dense ? ultra_dense_capsule(angle_q6, codes)
                                                          : capsule(angle_q6, contents));
    }
    RplidarDecoder decoder{RplidarFraming::running()};
    std::size_t capsules = 0;
    decoder.feed(Bytes(stream).subspan(17), [&](const RplidarPacket& p) {
      EXPECT_EQ(p.response(), kind);
      ++capsules;
    });
    EXPECT_EQ(capsules, 19U) << static_cast<int>(kind);
  }
}

TEST(RplidarRunning, HqCapsulesAreTakenWhole) {
  Stream stream;
  for (std::uint16_t i = 0; i < 5; ++i)
    append(stream, hq_capsule(std::vector<HqNode>(96, HqNode{i, 4000, 200}), i));
  testing::DecoderLaws<RplidarDecoder> laws{stream, kAsText};
  laws.make = [] { return std::make_unique<RplidarDecoder>(RplidarFraming::running()); };
  laws.any_split_gives_the_same();
  RplidarDecoder decoder{RplidarFraming::running()};
  std::size_t capsules = 0;
  decoder.feed(Bytes(stream).subspan(17), [&](const RplidarPacket& p) {
    EXPECT_EQ(p.response(), RplidarResponse::hq);
    ++capsules;
  });
  EXPECT_EQ(capsules, 4U);
}

TEST(RplidarRunning, ADescriptorEndsIt) {
  Stream stream = running_nodes();
  append(stream, {0xA5, 0x25, 0xFF, 0xFF});
  append(stream, descriptor(RplidarResponse::health, 3, false));
  append(stream, {0, 0, 0});
  append(stream, descriptor(RplidarResponse::node, 5, true));
  append(stream, running_nodes());
  testing::DecoderLaws<RplidarDecoder> laws{stream, kAsText};
  laws.make = [] { return std::make_unique<RplidarDecoder>(RplidarFraming::running()); };
  laws.work_per_byte = 2.0 * RplidarFraming::kCapacity;
  laws.any_split_gives_the_same();
  laws.work_is_bounded();
  RplidarDecoder decoder{RplidarFraming::running()};
  std::size_t healthy = 0;
  decoder.feed(stream, [&](const RplidarPacket& p) {
    healthy += p.response() == RplidarResponse::health && !p.is_descriptor() ? 1 : 0;
  });
  EXPECT_EQ(healthy, 1U);
}

TEST(RplidarRunning, NoOtherBytesAreAScan) {
  Rng rng(4);
  Stream noise(2'000'000);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(rng());
  std::vector<Stream> streams = {noise};
  for (int byte = 0; byte < 256; ++byte)
    streams.emplace_back(1000, static_cast<std::uint8_t>(byte));
  for (const Stream& stream : streams) {
    RplidarDecoder decoder{RplidarFraming::running()};
    decoder.feed(stream, [](const RplidarPacket& p) { ADD_FAILURE() << text_of(p); });
    decoder.finish([](const RplidarPacket&) {});
  }
}

}  // namespace
}  // namespace wayfare::decode
