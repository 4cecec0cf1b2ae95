#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <system_error>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace wayfare::testing {

/// A temporary folder for one test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "wayfare-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code code;
    std::filesystem::remove_all(path_, code);
    EXPECT_FALSE(code) << path_ << " cannot be removed: " << code.message();
  }

  [[nodiscard]] std::string operator/(const std::string& name) const {
    return (path_ / name).string();
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The path of a recording, empty where it is absent.
inline std::string recording(const std::string& name) {
  const char* folder = WAYFARE_DATA_DIR;
  const std::string path = std::string(folder) + "/" + name;
  return *folder != '\0' && std::filesystem::exists(path) ? path : std::string();
}

}  // namespace wayfare::testing

/// Defines `path`, or skips the test and names the missing recording.
#define WAYFARE_NEEDS_RECORDING(path, name)                     \
  const std::string path = ::wayfare::testing::recording(name); \
  if ((path).empty()) GTEST_SKIP() << "needs the recording " << (name) << " in WAYFARE_DATA_DIR"
