// Two loggers that would share lines or a control socket.

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "listening.hpp"
#include "one_device.hpp"

namespace wayfare::logger {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::wayfare::testing::has_read;
using ::wayfare::testing::OneDevice;
using ::wayfare::testing::sensor;

const std::string kThisProcess = "process " + std::to_string(::getpid());

TEST(TwoLoggers, DoNotShareALine) {
  OneDevice device;
  auto first = std::move(*Logger::start(device.options));
  device.send("1234");
  ASSERT_TRUE(has_read(*first, 4));
  const auto second = Logger::start(device.options);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().to_string(),
              AllOf(HasSubstr(device.terminal.path()), HasSubstr(kThisProcess)));
  // The first one is unharmed.
  device.send("5678");
  EXPECT_TRUE(has_read(*first, 8));
  first.reset();
  EXPECT_TRUE(Logger::start(device.options));
}

TEST(TwoLoggers, DoNotShareASocket) {
  OneDevice device, other;
  device.options.control_socket = other.options.control_socket = device.folder / "control";
  const auto& path = device.options.control_socket;
  const auto first = Logger::start(device.options);
  ASSERT_TRUE(first);
  const auto second = Logger::start(other.options);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().to_string(), AllOf(HasSubstr(path), HasSubstr(kThisProcess)));
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(TwoLoggers, RemoveTheirOwnSocketOnly) {
  OneDevice device, other;
  device.options.control_socket = other.options.control_socket = device.folder / "control";
  const auto& path = device.options.control_socket;
  auto first = std::move(*Logger::start(device.options));
  // Someone removes the socket, so that it looks unused.
  ASSERT_EQ(::unlink(path.c_str()), 0);
  const auto second = Logger::start(other.options);
  ASSERT_TRUE(second);
  first.reset();
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(LoggerPorts, NoneIsOfTheNetwork) {
  const auto before = ::wayfare::testing::listened_addresses();
  OneDevice device;
  device.options.control_socket = device.folder / "control";
  const auto logger = Logger::start(device.options);
  ASSERT_TRUE(logger);
  ASSERT_TRUE((*logger)->begin());
  device.send("1234");
  ASSERT_TRUE(has_read(**logger, 4));
  EXPECT_EQ(::wayfare::testing::listened_addresses(), before);
}

TEST(LoggerPorts, OfTwoSensorsAreTwo) {
  OneDevice device;
  LoggerOptions options = device.options;
  options.sensors.push_back(sensor({"twin", "raw", 115200, ""}, device.terminal.path()));
  const auto same = Logger::start(options);
  ASSERT_FALSE(same);
  EXPECT_THAT(same.error().to_string(),
              AllOf(HasSubstr("the port of unit and of twin"), HasSubstr(device.terminal.path())));
  // By another name, as in /dev/serial/by-id.
  const std::string link = device.folder / "link";
  ASSERT_EQ(::symlink(device.terminal.path().c_str(), link.c_str()), 0);
  options.sensors.back().port = link;
  EXPECT_FALSE(Logger::start(options));
  options.sensors.pop_back();
  options.control_port = link;
  const auto control = Logger::start(options);
  ASSERT_FALSE(control);
  EXPECT_THAT(control.error().to_string(), HasSubstr("the port of unit and of the control"));
}

}  // namespace
}  // namespace wayfare::logger
