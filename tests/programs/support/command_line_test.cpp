// Options, their help and the exit codes of programs.

#include "support/command_line.hpp"

#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace wayfare::examples {
namespace {

using ::testing::HasSubstr;

struct Values {
  std::string log, axis = "x";
  std::vector<double> origin;
  double share = 0.25;
  int threads = 1;
  bool force = false;
};

/// Parses the words as those of a program "mapper"; its output is taken as text.
class CommandLineTest : public ::testing::Test {
 protected:
  CommandLineTest() : app_("Map a building. It writes a map.") {
    app_.add_file("LOG", values_.log, "the recorded log").required();
    app_.add_number("--share", values_.share, 0.0, 1.0, "of the inliers");
    app_.add_number("--threads", values_.threads, 1, 256, "worker threads");
    app_.add_option("--forward", values_.axis, "axis of the unit")
        .one_of({"x", "y"})
        .show_default();
    app_.add_option("--origin", values_.origin, "latitude and longitude, degrees")
        .delimiter(',')
        .expected(2);
    app_.add_flag("--force", values_.force, "replace existing files");
    app_.example("robot.log --share 0.5", "half of the points");
  }

  std::optional<int> parse(std::vector<std::string> words) {
    words.insert(words.begin(), "/usr/bin/mapper");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const auto code = app_.parse(static_cast<int>(argv.size()), argv.data());
    out_ = ::testing::internal::GetCapturedStdout();
    error_ = ::testing::internal::GetCapturedStderr();
    return code;
  }

  Values values_;
  CommandLine app_;
  std::string out_, error_;
};

constexpr const char* kFile = "/dev/null";

TEST_F(CommandLineTest, TakesValuesOfTheRightKind) {
  EXPECT_EQ(parse({kFile, "--share", "0.5", "--origin=51.5,-114", "--forward", "y"}), std::nullopt);
  EXPECT_EQ(values_.share, 0.5);
  EXPECT_EQ(values_.axis, "y");
  EXPECT_EQ(values_.origin, (std::vector<double>{51.5, -114}));
  EXPECT_EQ(out_ + error_, "");
}

TEST_F(CommandLineTest, AnUnknownOptionNamesTheNearest) {
  const auto meant = [&](const std::string& word) {
    EXPECT_EQ(parse({kFile, word, "3"}), 2);
    EXPECT_EQ(out_, "");
    const std::size_t begin = error_.find("did you mean ");
    return begin == std::string::npos ? ""
                                      : error_.substr(begin + 13, error_.find('?') - begin - 13);
  };
  EXPECT_EQ(meant("--thread"), "--threads");
  EXPECT_EQ(meant("--treads"), "--threads");
  EXPECT_EQ(meant("--htreads=3"), "--threads");  // two neighbours swapped: one edit
  EXPECT_EQ(meant("--shape"), "--share");
  EXPECT_EQ(meant("--hepl"), "--help");
  EXPECT_EQ(meant("--bathymetry"), "");
  EXPECT_THAT(error_, HasSubstr("mapper: unknown option --bathymetry\n"));
  EXPECT_THAT(error_, HasSubstr("mapper --help"));
}

TEST_F(CommandLineTest, AnUnknownOptionComesBeforeWhatIsMissing) {
  EXPECT_EQ(parse({"--sharee", "0.5"}), 2);
  EXPECT_THAT(error_, HasSubstr("unknown option --sharee; did you mean --share?"));
}

TEST_F(CommandLineTest, WrongArgumentsEndWithTwo) {
  EXPECT_EQ(parse({}), 2);
  EXPECT_THAT(error_, HasSubstr("mapper: LOG is required"));
  EXPECT_EQ(parse({kFile, "--share", "2"}), 2);
  EXPECT_THAT(error_, HasSubstr("--share: must be from 0 to 1, is 2\n"));
  EXPECT_EQ(parse({kFile, "--share", "nan"}), 2);
  EXPECT_EQ(parse({kFile, "--share", "many"}), 2);
  EXPECT_THAT(error_, HasSubstr("--share: must be a number, is many\n"));
  EXPECT_EQ(parse({kFile, "--threads", "1.5"}), 2);
  EXPECT_THAT(error_, HasSubstr("--threads: must be a whole number, is 1.5\n"));
  EXPECT_EQ(parse({kFile, "--share"}), 2);
  EXPECT_EQ(parse({kFile, "--forward", "z"}), 2);
  EXPECT_EQ(parse({kFile, "--origin", "1"}), 2);
  EXPECT_EQ(parse({kFile, "another", "third"}), 2);
}

TEST_F(CommandLineTest, NumbersWithOneLimit) {
  double sigma = 1.0, gap = 1.0;
  std::size_t seed = 1;
  app_.add_positive("--sigma", sigma, "of a range, m");
  app_.add_option("--gap", gap, "m").not_negative();
  app_.add_option("--seed", seed, "of the random numbers");
  EXPECT_EQ(parse({kFile, "--sigma", "1e-3", "--gap", "0", "--seed", "0"}), std::nullopt);
  EXPECT_EQ(parse({kFile, "--sigma", "0"}), 2);
  EXPECT_THAT(error_, HasSubstr("--sigma: must be positive, is 0\n"));
  EXPECT_EQ(parse({kFile, "--gap", "-1"}), 2);
  EXPECT_THAT(error_, HasSubstr("--gap: must not be negative, is -1\n"));
  EXPECT_EQ(parse({kFile, "--seed", "-1"}), 2);
  EXPECT_THAT(error_, HasSubstr("--seed: must not be negative, is -1\n"));
}

TEST_F(CommandLineTest, AFileThatIsNotThereEndsWithOne) {
  EXPECT_EQ(parse({"/nowhere/robot.log"}), 1);
  EXPECT_EQ(error_, "mapper: /nowhere/robot.log: does not exist\n");
  EXPECT_EQ(parse({"/tmp"}), 1);
  EXPECT_EQ(error_, "mapper: /tmp: is a folder\n");
}

TEST_F(CommandLineTest, HelpNamesValuesRangesDefaultsExamplesAndExitCodes) {
  EXPECT_EQ(parse({"--share", "2", "--help"}), 0);
  EXPECT_EQ(error_, "");
  EXPECT_EQ(out_,
            "Map a building. It writes a map.\n"
            "\n"
            "Usage: mapper [OPTIONS] LOG\n"
            "\n"
            "Arguments:\n"
            "  LOG                         the recorded log\n"
            "\n"
            "Options:\n"
            "  -h, --help                  print this help and exit\n"
            "  --version                   print the version and exit\n"
            "  --man-page                  print this help as a man page and exit\n"
            "  --bash-completion           print a completion for bash and exit\n"
            "  --share NUMBER              of the inliers (0 to 1; default 0.25)\n"
            "  --threads INTEGER           worker threads (1 to 256; default 1)\n"
            "  --forward x|y               axis of the unit (default x)\n"
            "  --origin NUMBER,NUMBER      latitude and longitude, degrees\n"
            "  --force                     replace existing files\n"
            "\n"
            "Examples:\n"
            "  mapper robot.log --share 0.5\n"
            "      half of the points\n"
            "\n"
            "Exit codes:\n"
            "  0  done\n"
            "  1  a file, a device or its data cannot be used\n"
            "  2  wrong arguments\n"
            "  3  done, but the result is in doubt, for the reason printed\n");
}

TEST_F(CommandLineTest, HelpIsWrappedAtEightyColumns) {
  bool flag = false;
  std::string text = "lengthy";
  for (int i = 0; i < 40; ++i) text += " wörds";
  app_.add_flag("--lengthy", flag, text);
  EXPECT_EQ(parse({"--help"}), 0);
  std::istringstream lines(out_);
  for (std::string line; std::getline(lines, line);) {
    std::size_t width = 0;
    for (const char c : line) width += (static_cast<unsigned char>(c) & 0xc0) != 0x80 ? 1 : 0;
    EXPECT_LE(width, 80U) << line;
  }
}

TEST_F(CommandLineTest, ManPageHasTheSameOptions) {
  EXPECT_EQ(parse({"--man-page"}), 0);
  EXPECT_THAT(out_, HasSubstr(".SH NAME\nmapper \\- Map a building\n"));
  for (const char* option : {"\\-\\-share NUMBER", "\\-\\-threads INTEGER", "\\-\\-forward x|y"})
    EXPECT_THAT(out_, HasSubstr(std::string("\\fB") + option + "\\fR"));
  EXPECT_THAT(out_, HasSubstr(".SH \"EXIT STATUS\""));
}

TEST_F(CommandLineTest, CompletionOffersOptionsAndWords) {
  EXPECT_EQ(parse({"--bash-completion"}), 0);
  if (std::system("bash -c true") != 0) GTEST_SKIP() << "there is no bash";
  const std::string script = ::testing::TempDir() + "mapper.bash";
  std::ofstream(script) << out_;
  const auto offered = [&](const std::string& words, int at) {
    const std::string result = script + ".txt";
    const std::string command = "bash -c 'source " + script + "; COMP_WORDS=(" + words +
                                "); COMP_CWORD=" + std::to_string(at) +
                                "; _wayfare_mapper; echo \"${COMPREPLY[@]}\"' >" + result;
    EXPECT_EQ(std::system(command.c_str()), 0);
    std::string line;
    std::ifstream file(result);
    std::getline(file, line);
    return line;
  };
  EXPECT_EQ(offered("mapper --fo", 1), "--forward --force");
  EXPECT_EQ(offered("mapper --forward \"\"", 2), "x y");
  EXPECT_EQ(offered("mapper --forward = y", 3), "y");
  EXPECT_EQ(offered("mapper --threads \"\"", 2), "");
  EXPECT_EQ(offered("mapper /dev/nul", 1), "/dev/null");
}

TEST(Nearest, CountsInsertionsDeletionsReplacementsAndSwaps) {
  EXPECT_EQ(nearest("kitten", {"sitten", "sitting"}), "sitten");
  EXPECT_EQ(nearest("abcdef", {"badcef", "xxxdef"}), "badcef");  // two swaps, three replacements
  EXPECT_EQ(nearest("abcdef", {"xyzuvw"}), "");
  EXPECT_EQ(nearest("", {"abc"}), "");
  EXPECT_EQ(nearest("abc", {}), "");
}

TEST(ExitCode, TellsDataUseAndDoubtApart) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(exit_code("mapper", Result<void>{}), 0);
  EXPECT_EQ(exit_code("mapper", Result<Doubt>(Doubt{})), 0);
  EXPECT_EQ(exit_code("mapper", Result<void>(Error{ErrorCode::parse, "is empty", "robot.log"})), 1);
  EXPECT_EQ(exit_code("mapper", Result<void>(bad_use("needs --map"))), 2);
  EXPECT_EQ(exit_code("mapper", Result<Doubt>(bad_use("needs --map"))), 2);
  EXPECT_EQ(exit_code("mapper", Result<Doubt>(Doubt{"not converged"})), 3);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "mapper: robot.log: is empty\n"
            "mapper: needs --map\nmapper --help lists the arguments.\n"
            "mapper: needs --map\nmapper --help lists the arguments.\n"
            "mapper: in doubt: not converged\n");
}

}  // namespace
}  // namespace wayfare::examples
