// The conversation on the command port, with answers in the form of TI's command line.
#include <wayfare/decode/ti_commands.hpp>

#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <wayfare/core/random.hpp>

namespace wayfare::decode {
namespace {

using ::testing::HasSubstr;

const std::string kConfig =
    "% a comment\r\n"
    "sensorStop\r\n"
    "\r\n"
    "channelCfg 15 5 0\r\n"
    "  % another\n"
    "frameCfg 0 1 16 0 100 1 0\n"
    "sensorStart";

/// What the firmware prints: the echo, the answer, the prompt.
std::string answer(std::string_view command, std::string_view text = "Done") {
  return std::string(command) + "\r\n" + std::string(text) + "\n\rmmwDemo:/>";
}

TEST(TiDialogue, SendsTheCommandsOneByOne) {
  TiDialogue dialogue(kConfig, "radar.cfg");
  std::vector<std::string> sent;
  while (const auto command = dialogue.next()) {
    EXPECT_FALSE(dialogue.next()) << "the answer is missing";
    EXPECT_FALSE(dialogue.is_done());
    sent.emplace_back(*command);
    const bool stop = *command == "sensorStop";
    dialogue.feed(answer(*command, stop ? "Ignored: Sensor is already stopped\nDone" : "Done"));
  }
  EXPECT_EQ(sent, (std::vector<std::string>{"sensorStop", "channelCfg 15 5 0",
                                            "frameCfg 0 1 16 0 100 1 0", "sensorStart"}));
  EXPECT_TRUE(dialogue.is_done());
  EXPECT_EQ(dialogue.answered(), 4U);
}

TEST(TiDialogue, AnyPiecesOfTheAnswersGiveTheSame) {
  Rng rng(3);
  for (int trial = 0; trial < 200; ++trial) {
    TiDialogue dialogue(kConfig, "radar.cfg");
    dialogue.feed("\r\nmmwDemo:/>");  // before the first command
    while (const auto command = dialogue.next()) {
      std::string text = answer(*command);
      // A prompt that was still in the line's buffer.
      if (trial % 2 == 0) text = "\r\nmmwDemo:/>" + text;
      while (!text.empty()) {
        const std::size_t n = 1 + rng.below(std::min<std::size_t>(text.size(), 9));
        dialogue.feed(text.substr(0, n));
        text.erase(0, n);
      }
    }
    ASSERT_TRUE(dialogue.is_done()) << trial;
    ASSERT_EQ(dialogue.answered(), 4U);
  }
}

TEST(TiDialogue, AnErrorIsReportedWithItsLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"Error -203621", "answered 'Error -203621'"},
      {"Debug: rlSetFrameConfig failed\nError: Invalid usage of the CLI command",
       "answered 'Error: Invalid usage of the CLI command'"},
      {"'frameCfg' is not recognized as a CLI command", "is not recognized"},
      {"what?", "did not answer"}};
  for (const auto& [text, reported] : cases) {
    TiDialogue dialogue(kConfig, "radar.cfg");
    while (const auto command = dialogue.next())
      dialogue.feed(answer(*command, command->starts_with("frame") ? text : "Done"));
    ASSERT_TRUE(dialogue.error());
    EXPECT_THAT(dialogue.error()->to_string(), HasSubstr("radar.cfg:6: 'frameCfg 0 1 16"));
    EXPECT_THAT(dialogue.error()->to_string(), HasSubstr(reported));
    EXPECT_FALSE(dialogue.is_done());
    EXPECT_EQ(dialogue.answered(), 2U);
    dialogue.feed(answer("sensorStart"));  // nothing follows an error
    EXPECT_FALSE(dialogue.next());
  }
}

TEST(TiDialogue, NoiseIsNoAnswer) {
  TiDialogue dialogue(kConfig, "radar.cfg");
  ASSERT_TRUE(dialogue.next());
  EXPECT_THAT(dialogue.no_answer().to_string(), HasSubstr("radar.cfg:2: 'sensorStop': no answer"));
  for (int i = 0; i < 10'000 && !dialogue.error(); ++i) dialogue.feed(std::string(7, '\xC3'));
  ASSERT_TRUE(dialogue.error());
  EXPECT_THAT(dialogue.error()->message, HasSubstr("no sensor's command port"));
}

TEST(TiDialogue, OtherAnswersThanDone) {
  for (const auto& [text, good] : {std::pair{"Skipped", true},
                                   {"Ignored: Sensor is already stopped", true},
                                   {"Done", true},
                                   {"Almost Done", false}}) {
    TiDialogue dialogue("sensorStop", "radar.cfg");
    ASSERT_TRUE(dialogue.next());
    dialogue.feed(answer("sensorStop", text));
    EXPECT_EQ(dialogue.is_done(), good) << text;
    EXPECT_EQ(dialogue.error().has_value(), !good) << text;
  }
}

// 4096 bytes without a prompt may be an answer yet; of a fault 120 characters are shown.
TEST(TiDialogue, LengthsOfAnswers) {
  TiDialogue dialogue("sensorStop", "radar.cfg");
  ASSERT_TRUE(dialogue.next());
  dialogue.feed(std::string(4096, 'x'));
  EXPECT_FALSE(dialogue.error());
  dialogue.feed("x");
  EXPECT_TRUE(dialogue.error());

  TiDialogue faulty("sensorStop", "radar.cfg");
  ASSERT_TRUE(faulty.next());
  faulty.feed(answer("sensorStop", "Error " + std::string(200, '7')));
  ASSERT_TRUE(faulty.error());
  EXPECT_THAT(faulty.error()->message, HasSubstr("'Error " + std::string(114, '7') + "'"));
}

TEST(TiDialogue, AConfigurationWithoutCommandsIsDone) {
  for (const char* text : {"", "\n\n", "% only\n%comments"}) {
    TiDialogue dialogue(text, "empty.cfg");
    EXPECT_FALSE(dialogue.next());
    EXPECT_TRUE(dialogue.is_done());
  }
}

}  // namespace
}  // namespace wayfare::decode
